"""The estimator of one belt drive."""

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import LifecycleNode


def _belt_node(context: LaunchContext) -> list[LifecycleNode]:
    parameters = [LaunchConfiguration("params_file")]
    memory_file = LaunchConfiguration("memory_file").perform(context)
    if memory_file:
        parameters.append({"memory_file": memory_file})
    return [
        LifecycleNode(
            package="belt_ros",
            executable="belt_node",
            name="belt_node",
            namespace=LaunchConfiguration("namespace"),
            parameters=parameters,
            remappings=[("joint_states", LaunchConfiguration("joint_states_topic"))],
            output="screen",
        )
    ]


def generate_launch_description() -> LaunchDescription:
    """Start `belt_node`, which configures and activates itself unless told otherwise."""
    return LaunchDescription(
        [
            DeclareLaunchArgument(
                "params_file", description="YAML that describes the drive; examples in config/"
            ),
            DeclareLaunchArgument(
                "namespace", default_value="", description="namespace of the node and its topics"
            ),
            DeclareLaunchArgument(
                "joint_states_topic",
                default_value="joint_states",
                description="topic with the velocity and effort of both pulleys",
            ),
            DeclareLaunchArgument(
                "memory_file",
                default_value="",
                description="file that keeps what was learned of this belt from one run to the "
                "next; empty: as params_file says",
            ),
            OpaqueFunction(function=_belt_node),
        ]
    )
