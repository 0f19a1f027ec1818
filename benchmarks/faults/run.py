"""One fault over real DDS: rig, node and recorder, each a process, in a domain of their own."""

import time
from typing import NamedTuple

import yaml

from benchmarks.faults.cases import Case
from benchmarks.faults.recorder import ALARM, DIAGNOSTICS, STATE, TRUTH, Heard, load
from benchmarks.graph.bench import bench

_PATIENCE = 60.0  # [s] beyond a run's own time
_ARRIVING = 1.0  # [s] in which what is under way arrives


class Record(NamedTuple):
    """What was heard. Times of arrival are on the wall clock, as the truth's stamps."""

    states: list[Heard]
    alarms: list[Heard]
    diagnostics: list[Heard]
    truths: list[Heard]
    alive: bool  # the node, at the end


def play(case: Case) -> Record:
    """Play a case in real time.

    Raises
    ------
    ProgramError
        If rig or recorder fails, or the node does not start.
    """
    with bench() as place:
        # Judged is the node, not what else this machine is busy with.
        node = place.start_node(case.config, longest_pool=0.0)
        scenario, written = place.folder / "scenario.yaml", place.folder / "heard"
        scenario.write_text(yaml.safe_dump(dict(case.script)), encoding="utf-8")
        recorder = place.start("benchmarks.faults.recorder", str(written), str(case.acknowledged))
        recorder.wait_for("ready")
        rig = place.start(
            "belt_ros.rig.main",
            *("--ros-args", "-p", f"config_file:={case.config}"),
            *("-p", f"scenario_file:={scenario}"),
            *("-p", "wait_for_subscriber:=20.0", "-p", "subscribers:=2"),
        )
        rig.wait(_PATIENCE + case.duration)
        time.sleep(_ARRIVING)
        alive = node.alive
        recorder.stop()
        heard = load(written)
    return Record(heard[STATE], heard[ALARM], heard[DIAGNOSTICS], heard[TRUTH], alive)
