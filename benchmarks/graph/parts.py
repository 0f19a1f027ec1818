"""What there is to measure: for each sub-command its page and its table."""

from benchmarks.graph import drives, kill, latency, rate, stages
from benchmarks.graph.results import Part

_PROCESSES = (
    "Node, sender and subscriber are processes of one machine and one ROS domain, over Fast DDS, "
    "all reliable. Delays are from the header stamp, set when a message is published, to the "
    "arrival of the state at the subscriber; of pooled messages, from that of the last. "
)

PARTS = {
    part.name: part
    for part in (
        Part(
            "rate",
            "The node at a steady rate",
            f"{_PROCESSES}The first {rate.WARM_UP:g} s do not count for delays, states and memory. "
            "Memory: in RAM, median of the last tenth of the run less that of the first.",
            rate.Rate,
            rate.rate_verdicts,
            rate.rate_lines,
        ),
        Part(
            "latency",
            "The node beside a bare relay",
            f"{_PROCESSES}The relay takes the same joint states in, by the same executor, and "
            "gives out a belt state of which only the stamp is new. Both are sent to by turns of "
            f"{latency.BLOCK:g} s; ratios are medians over neighbouring turns. The load changes "
            "every two seconds; where it is steady, most messages only wait for the next step, and "
            "still have a state each.",
            latency.Turn,
            latency.latency_verdicts,
            latency.latency_lines,
            texts=2,
        ),
        Part(
            "drives",
            "Many drives in one process",
            f"{_PROCESSES}All joints come in one joint state, each drive at another point of the "
            "load's cycle. Measurements that cannot be followed are averaged (`longest_pool`): a "
            "state is then of several, of which the last counts for the delay; those that wait for "
            "the next state at the end are not missed. "
            f"The first {rate.WARM_UP:g} s do not count.",
            drives.Drives,
            drives.drives_verdicts,
            drives.drives_lines,
        ),
        Part(
            "kill",
            "The node killed at random moments",
            "kill -9 with a memory file that is written often, input going on all the while; one "
            "kill in four meets the node while it starts. The first message that the new process "
            "takes is told by its counts. Before: the last state that was certainly saved.",
            kill.Kill,
            kill.kill_verdicts,
            kill.kill_lines,
        ),
        Part(
            "stages",
            "Where the time of one message goes",
            "Processor time of the thread that calls each stage by itself, on the messages of a "
            "drive under load, none of which is pooled. Publishing is to one subscriber in another "
            "process.",
            stages.Stage,
            stages.stage_verdicts,
            stages.stage_lines,
        ),
    )
}
