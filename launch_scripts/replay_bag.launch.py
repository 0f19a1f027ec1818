"""A recorded bag, played to the estimator on the bag's own time."""

from launch import LaunchContext, LaunchDescription
from launch.actions import (
    DeclareLaunchArgument,
    EmitEvent,
    ExecuteProcess,
    OpaqueFunction,
    RegisterEventHandler,
    Shutdown,
)
from launch.event_handlers import OnProcessStart
from launch.events import matches_action
from launch.events.process import ProcessExited
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import LifecycleNode
from launch_ros.event_handlers import OnStateTransition
from launch_ros.events.lifecycle import ChangeState
from lifecycle_msgs.msg import Transition


def _play(context: LaunchContext) -> list[ExecuteProcess]:
    topics = LaunchConfiguration("topics").perform(context).split()
    loops = LaunchConfiguration("loop").perform(context) == "true"
    command = ["ros2", "bag", "play", LaunchConfiguration("bag")]
    command += ["--clock", LaunchConfiguration("clock_rate")]
    command += ["--rate", LaunchConfiguration("rate"), "--disable-keyboard-controls"]
    command += ["--loop"] if loops else []
    command += ["--topics", *topics] if topics else []
    return [
        ExecuteProcess(
            cmd=command, output="screen", on_exit=Shutdown(reason="the bag has been played")
        )
    ]


def _end(_event: ProcessExited, context: LaunchContext) -> Shutdown | None:
    """End with the node, unless the end is what it ended for."""
    return None if context.is_shutdown else Shutdown(reason="the node has ended")


def generate_launch_description() -> LaunchDescription:
    """Start the node, play the bag as soon as it is active, and end with the bag."""
    node = LifecycleNode(
        package="belt_ros",
        executable="belt_node",
        name="belt_node",
        namespace=LaunchConfiguration("namespace"),
        parameters=[
            # Best effort, the default, hears what was recorded in either way; so that nothing is
            # lost all the same, much may wait.
            {"input_depth": 10000},
            LaunchConfiguration("params_file"),
            # A bag that plays while kernels are still being compiled would be missed.
            # What it teaches is of then, and not to be kept for now.
            {"use_sim_time": True, "autostart": False, "use_memory": False},
        ],
        remappings=[("joint_states", LaunchConfiguration("joint_states_topic"))],
        ros_arguments=["--log-level", LaunchConfiguration("log_level")],
        output="screen",
        on_exit=_end,
    )

    def request(transition: int) -> EmitEvent:
        return EmitEvent(
            event=ChangeState(lifecycle_node_matcher=matches_action(node), transition_id=transition)
        )

    return LaunchDescription(
        [
            DeclareLaunchArgument("bag", description="directory of the bag, or its file"),
            DeclareLaunchArgument(
                "params_file",
                description="YAML that describes the drive, or several; examples in config/",
            ),
            DeclareLaunchArgument(
                "namespace", default_value="", description="namespace of the node and its topics"
            ),
            DeclareLaunchArgument(
                "joint_states_topic",
                default_value="joint_states",
                description="topic of the bag with the velocity and effort of the pulleys",
            ),
            DeclareLaunchArgument(
                "topics",
                default_value="",
                description="what to play, separated by spaces; empty: all. Leave out what a node "
                "has published in the recording",
            ),
            DeclareLaunchArgument(
                "rate", default_value="1.0", description="times faster than it was recorded"
            ),
            DeclareLaunchArgument(
                "loop",
                default_value="false",
                choices=["true", "false"],
                description="whether it begins again at its end; the node then starts anew",
            ),
            DeclareLaunchArgument(
                "clock_rate", default_value="100.0", description="messages on /clock per second"
            ),
            DeclareLaunchArgument(
                "log_level",
                default_value="info",
                choices=["debug", "info", "warn", "error", "fatal"],
                description="least severity of what the node logs",
            ),
            RegisterEventHandler(
                OnProcessStart(
                    target_action=node, on_start=[request(Transition.TRANSITION_CONFIGURE)]
                )
            ),
            RegisterEventHandler(
                OnStateTransition(
                    target_lifecycle_node=node,
                    start_state="configuring",
                    goal_state="inactive",
                    entities=[request(Transition.TRANSITION_ACTIVATE)],
                )
            ),
            RegisterEventHandler(
                OnStateTransition(
                    target_lifecycle_node=node,
                    goal_state="unconfigured",
                    entities=[Shutdown(reason="the node cannot be configured")],
                )
            ),
            RegisterEventHandler(
                OnStateTransition(
                    target_lifecycle_node=node,
                    goal_state="active",
                    entities=[OpaqueFunction(function=_play)],
                )
            ),
            node,
        ]
    )
