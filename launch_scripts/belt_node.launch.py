"""The estimator of one belt drive."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import LifecycleNode


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
            LifecycleNode(
                package="belt_ros",
                executable="belt_node",
                name="belt_node",
                namespace=LaunchConfiguration("namespace"),
                parameters=[LaunchConfiguration("params_file")],
                remappings=[("joint_states", LaunchConfiguration("joint_states_topic"))],
                output="screen",
            ),
        ]
    )
