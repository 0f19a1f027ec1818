"""The virtual rig: a belt drive, or several, with faults on request."""

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.substitutions import LaunchConfiguration, PathJoinSubstitution
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue
from launch_ros.substitutions import FindPackageShare

# Arguments that are parameters of the rig: type, default, meaning.
_PARAMETERS = {
    "output": (str, "joint_state", "what readings go out as: joint_state, pulley_state or float64"),
    "drives": (int, "0", "so many drives alike, drive_1 and so on; 0: as params_file says"),
    "driver_rate": (float, "0.0", "readings of a driver per second [Hz]; 0: every sample"),
    "driven_rate": (float, "0.0", "readings of a driven pulley per second [Hz]; 0: every sample"),
    "truth_rate": (float, "0.0", "messages of the truth per second [Hz]; 0: every sample"),
    "loads": (bool, "false", "whether hub loads and span tension are measured too"),
    "fault": (str, "", "what goes wrong from the start, e.g. 'stuck driven_speed duration=5'"),
    "loop": (bool, "false", "whether the scenario begins again at its end"),
    "rate_factor": (float, "1.0", "times faster than real time"),
    "subscribers": (float, "1.0", "how many are waited for on each topic with speeds"),
    "wait_for_subscriber": (float, "60.0", "longest wait for them [s]"),
}


def generate_launch_description() -> LaunchDescription:
    """Play a scenario; end with it."""
    share = FindPackageShare("belt_ros")
    return LaunchDescription(
        [
            DeclareLaunchArgument(
                "params_file",
                default_value=PathJoinSubstitution([share, "config", "demo_drive.yaml"]),
                description="YAML that describes the drive, or several",
            ),
            DeclareLaunchArgument(
                "scenario_file",
                default_value=PathJoinSubstitution([share, "config", "scenarios", "demo.yaml"]),
                description="YAML that scripts speed, load and faults",
            ),
            DeclareLaunchArgument(
                "namespace", default_value="", description="namespace of the rig and its topics"
            ),
            DeclareLaunchArgument(
                "joint_states_topic",
                default_value="joint_states",
                description="topic that the joint states go out on",
            ),
            *(
                DeclareLaunchArgument(name, default_value=default, description=meaning)
                for name, (_, default, meaning) in _PARAMETERS.items()
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
                        **{
                            name: ParameterValue(LaunchConfiguration(name), value_type=kind)
                            for name, (kind, _, _) in _PARAMETERS.items()
                        },
                    }
                ],
                remappings=[("joint_states", LaunchConfiguration("joint_states_topic"))],
                output="screen",
            ),
        ]
    )
