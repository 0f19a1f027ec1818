"""The estimator for everyday use: started again if it dies, its diagnostics in a tree."""

from ament_index_python.packages import PackageNotFoundError, get_package_prefix
from launch import LaunchContext, LaunchDescription
from launch.actions import (
    DeclareLaunchArgument,
    IncludeLaunchDescription,
    LogInfo,
    OpaqueFunction,
)
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

_AGGREGATOR = "diagnostic_aggregator"
_OF_THE_NODE = {
    "name": ("belt_node", "name of the node"),
    "namespace": ("", "namespace of the node and its topics"),
    "joint_states_topic": ("joint_states", "topic with the velocity and effort of the pulleys"),
    "memory_file": ("", "file that keeps what was learned; empty: as params_file says"),
    "use_sim_time": ("", "whether time is that of /clock; empty: as params_file says"),
    "log_level": ("info", "least severity of what is logged"),
}


def _aggregator(context: LaunchContext) -> list[Node | LogInfo]:
    if LaunchConfiguration("aggregate").perform(context) != "true":
        return []
    try:
        get_package_prefix(_AGGREGATOR)
    except PackageNotFoundError:
        return [LogInfo(msg=f"{_AGGREGATOR} is not installed; /diagnostics is there without it")]
    return [
        Node(
            package=_AGGREGATOR,
            executable="aggregator_node",
            name="analyzers",
            parameters=[LaunchConfiguration("analyzers_file")],
            output="screen",
        )
    ]


def generate_launch_description() -> LaunchDescription:
    """Start the node, and diagnostic_aggregator where it is installed."""
    share = FindPackageShare("belt_ros")
    return LaunchDescription(
        [
            DeclareLaunchArgument(
                "params_file",
                description="YAML that describes the drive, or several; examples in config/",
            ),
            *(
                DeclareLaunchArgument(name, default_value=default, description=meaning)
                for name, (default, meaning) in _OF_THE_NODE.items()
            ),
            DeclareLaunchArgument(
                "aggregate",
                default_value="true",
                choices=["true", "false"],
                description="whether to sort /diagnostics into a tree, /diagnostics_agg",
            ),
            DeclareLaunchArgument(
                "analyzers_file",
                default_value=PathJoinSubstitution([share, "config", "analyzers.yaml"]),
                description="YAML that tells diagnostic_aggregator what belongs together",
            ),
            IncludeLaunchDescription(
                PythonLaunchDescriptionSource(
                    PathJoinSubstitution([share, "launch", "belt_node.launch.py"])
                ),
                launch_arguments={
                    "params_file": LaunchConfiguration("params_file"),
                    "respawn": "true",
                    **{name: LaunchConfiguration(name) for name in _OF_THE_NODE},
                }.items(),
            ),
            OpaqueFunction(function=_aggregator),
        ]
    )
