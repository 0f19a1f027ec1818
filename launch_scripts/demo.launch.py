"""A virtual belt drive, and the estimator that watches it."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription, Shutdown
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.substitutions import FindPackageShare

# The node may have kernels to compile before it listens.
_PATIENCE = 60.0  # [s]


def generate_launch_description() -> LaunchDescription:
    """Play a scenario on the rig beside the node; end with the scenario."""
    share = FindPackageShare("belt_ros")
    return LaunchDescription(
        [
            DeclareLaunchArgument(
                "params_file",
                default_value=PathJoinSubstitution([share, "config", "demo_drive.yaml"]),
                description="YAML that describes the drive, to the node and to the rig",
            ),
            DeclareLaunchArgument(
                "scenario_file",
                default_value=PathJoinSubstitution([share, "config", "scenarios", "demo.yaml"]),
                description="YAML that scripts speed, load and faults",
            ),
            DeclareLaunchArgument(
                "namespace",
                default_value="",
                description="namespace of both nodes and their topics",
            ),
            IncludeLaunchDescription(
                PythonLaunchDescriptionSource(
                    PathJoinSubstitution([share, "launch", "belt_node.launch.py"])
                ),
                launch_arguments={
                    "params_file": LaunchConfiguration("params_file"),
                    "namespace": LaunchConfiguration("namespace"),
                    "use_memory": "false",  # what a virtual drive teaches is nobody's belt
                }.items(),
            ),
            Node(
                package="belt_ros",
                executable="belt_rig",
                name="belt_rig",
                namespace=LaunchConfiguration("namespace"),
                parameters=[
                    {
                        "config_file": LaunchConfiguration("params_file"),
                        "scenario_file": LaunchConfiguration("scenario_file"),
                        "wait_for_subscriber": _PATIENCE,
                    }
                ],
                output="screen",
                on_exit=Shutdown(reason="the scenario has ended"),
            ),
        ]
    )
