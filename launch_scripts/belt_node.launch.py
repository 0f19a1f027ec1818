"""The estimator of one belt drive, or of several."""

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import LifecycleNode

_SWITCHES = ("autostart", "use_sim_time", "use_memory")
_RESPAWN_DELAY = 2.0  # [s]


def _belt_node(context: LaunchContext) -> list[LifecycleNode]:
    given = {
        name: LaunchConfiguration(name).perform(context) for name in (*_SWITCHES, "memory_file")
    }
    # What is not given here is left to the file: as a parameter, it would go before it.
    own = {
        name: value == "true" if name in _SWITCHES else value
        for name, value in given.items()
        if value
    }
    return [
        LifecycleNode(
            package="belt_ros",
            executable="belt_node",
            name=LaunchConfiguration("name"),
            namespace=LaunchConfiguration("namespace"),
            parameters=[LaunchConfiguration("params_file"), *([own] if own else [])],
            remappings=[("joint_states", LaunchConfiguration("joint_states_topic"))],
            ros_arguments=["--log-level", LaunchConfiguration("log_level")],
            respawn=LaunchConfiguration("respawn").perform(context) == "true",
            respawn_delay=_RESPAWN_DELAY,
            output="screen",
        )
    ]


def generate_launch_description() -> LaunchDescription:
    """Start `belt_node`, which configures and activates itself unless told otherwise."""
    return LaunchDescription(
        [
            DeclareLaunchArgument(
                "params_file",
                description="YAML that describes the drive, or several; examples in config/",
            ),
            DeclareLaunchArgument(
                "name", default_value="belt_node", description="name of the node"
            ),
            DeclareLaunchArgument(
                "namespace", default_value="", description="namespace of the node and its topics"
            ),
            DeclareLaunchArgument(
                "joint_states_topic",
                default_value="joint_states",
                description="topic with the velocity and effort of the pulleys",
            ),
            DeclareLaunchArgument(
                "autostart",
                default_value="",
                choices=["", "true", "false"],
                description="whether it configures and activates itself; if not, "
                "`ros2 lifecycle set` does; empty: as params_file says",
            ),
            DeclareLaunchArgument(
                "use_sim_time",
                default_value="",
                choices=["", "true", "false"],
                description="whether time is that of /clock; empty: as params_file says",
            ),
            DeclareLaunchArgument(
                "memory_file",
                default_value="",
                description="file that keeps what was learned of this belt from one run to the "
                "next; empty: as params_file says",
            ),
            DeclareLaunchArgument(
                "use_memory",
                default_value="",
                choices=["", "true", "false"],
                description="whether memory_file is read and written; empty: as params_file says",
            ),
            DeclareLaunchArgument(
                "log_level",
                default_value="info",
                choices=["debug", "info", "warn", "error", "fatal"],
                description="least severity of what is logged",
            ),
            DeclareLaunchArgument(
                "respawn",
                default_value="false",
                choices=["true", "false"],
                description="whether it is started again after it has died",
            ),
            OpaqueFunction(function=_belt_node),
        ]
    )
