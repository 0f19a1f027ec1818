"""Verdicts and pages of the benchmark on the graph, and one short run of it."""

import math
import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import yaml

pytest.importorskip("rclpy", reason="ROS 2 is not installed")
pytest.importorskip("belt_msgs", reason="belt_msgs is not built")

from belt_msgs.msg import BeltState
from rclpy.serialization import serialize_message

from belt_ros.settings import load_settings
from benchmarks.graph import drives, kill, latency, rate, stages
from benchmarks.graph.counter import Heard
from benchmarks.graph.parts import PARTS
from benchmarks.graph.program import ROOT
from benchmarks.graph.results import keep

PAPER = ROOT / "config" / "paper_drive.yaml"
RATE = rate.Rate("1000 Hz", "code", 1000, 998, 2, 225, 4, 300.0, 900.0, 2e3, 1.0, 5000, 0.1, 0.2)
DRIVES = drives.Drives(
    "50 drives", "code", 50, 100.0, 5000, 4950, 5000, 5000, 0.01, 300.0, 900.0, 2e3, 300.0, 0.5, 0
)
KILL = kill.Kill("100 Hz", 0, "code", 0, 3.0, 2.0, 0.02, 1.0, 2, 2, 1.0, 1.0)
STAGE = stages.Stage("BeltMonitor.step", "code", 100, 50.0, 60.0)


def turn(program: str, number: int, p50: float, processor: float) -> latency.Turn:
    return latency.Turn("100 Hz", program, number, "code", 200, 200, 200, p50, 2 * p50, processor)


TURNS = [
    turn("node", 0, 300.0, 200.0),
    turn("relay", 0, 200.0, 100.0),
    turn("node", 1, 320.0, 250.0),
    turn("relay", 1, 200.0, 100.0),
]
ROWS = {"rate": [RATE], "latency": TURNS, "drives": [DRIVES], "kill": [KILL], "stages": [STAGE]}


@pytest.mark.parametrize("name", PARTS)
def test_rows_survive_the_file_and_are_renewed_by_case(name: str, tmp_path: Path) -> None:
    first = keep(PARTS[name], ROWS[name], tmp_path)
    again = keep(PARTS[name], ROWS[name], tmp_path)
    assert first == again == (tmp_path / f"graph_{name}.md").read_text(encoding="utf-8")
    other = keep(PARTS[name], [row._replace(case="other") for row in ROWS[name]], tmp_path)
    assert len(other.splitlines()) > len(first.splitlines()) or name in ("kill", "stages")
    lines = (tmp_path / f"graph_{name}.csv").read_text(encoding="utf-8").splitlines()
    assert len(lines) == 1 + 2 * len(ROWS[name])


def refused(lines: list[str]) -> int:
    return sum("**no**" in line for line in lines)


def test_a_lost_message_and_grown_memory_are_told() -> None:
    assert refused(rate.rate_verdicts([RATE])) == 0
    assert refused(rate.rate_verdicts([RATE._replace(accepted=994)])) == 0  # in the last pool
    assert refused(rate.rate_verdicts([RATE._replace(accepted=993)])) == 1
    assert refused(rate.rate_verdicts([RATE._replace(growth=2_000_000)])) == 1


def test_latency_is_judged_by_ratios_of_neighbouring_turns() -> None:
    lines = "\n".join(latency.latency_verdicts(TURNS))
    assert "1.55 | yes" in lines
    assert "2.25 | yes" in lines
    slow = [row._replace(p50=500.0) if row.program == "node" else row for row in TURNS]
    assert refused(latency.latency_verdicts(slow)) == 1


def test_unanswered_messages_spoil_the_ratios() -> None:
    silent = [row._replace(states=100) if row.program == "node" else row for row in TURNS]
    assert refused(latency.latency_verdicts(silent)) == 2


def test_drives_that_lag_or_miss_states_are_told() -> None:
    assert refused(drives.drives_verdicts([DRIVES])) == 0
    assert refused(drives.drives_verdicts([DRIVES._replace(used=4900)])) == 1
    assert refused(drives.drives_verdicts([DRIVES._replace(states=4000)])) == 1
    assert refused(drives.drives_verdicts([DRIVES._replace(p99=2e5)])) == 2
    behind = DRIVES._replace(pooled=float("nan"), p99=float("nan"))
    assert refused(drives.drives_verdicts([behind])) == 2


def test_a_node_that_nobody_heard_after_a_kill_is_a_miss() -> None:
    second = 10**9
    state = BeltState(tension_knowledge=BeltState.KNOWLEDGE_LEARNED, accepted_count=100)
    heard = Heard(np.array([second]), np.array([second]), (serialize_message(state),))
    lives = [kill.Life(0, 1, 10 * second), kill.Life(11 * second, 12 * second, 15 * second)]
    (row,) = kill.judged(lives, heard, 100.0)
    assert (row.back, row.known_before, row.known_after) == (math.inf, 1, 0)
    assert refused(kill.kill_verdicts([KILL, row])) == 3


def test_a_terminated_benchmark_takes_its_programs_along(tmp_path: Path) -> None:
    script = (
        "import os, pathlib, time; from benchmarks.graph.program import Program, die_together;"
        "die_together(); p = Program('http.server', pathlib.Path('log'), os.environ,"
        " '--bind', '127.0.0.1', '0'); print(p.pid, flush=True); time.sleep(60)"
    )
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-c", script]
    with subprocess.Popen(
        command, cwd=tmp_path, env=environment, stdout=subprocess.PIPE, text=True
    ) as benchmark:
        assert benchmark.stdout is not None
        child = int(benchmark.stdout.readline())
        os.kill(child, 0)
        benchmark.terminate()
        assert benchmark.wait(20.0) == 128 + signal.SIGTERM
    with pytest.raises(ProcessLookupError):
        os.kill(child, 0)


def test_kills_are_judged_by_what_is_back() -> None:
    assert refused(kill.kill_verdicts([KILL])) == 0
    assert refused(kill.kill_verdicts([KILL, KILL._replace(back=1.5)])) == 1
    assert refused(kill.kill_verdicts([KILL, KILL._replace(known_after=1)])) == 1
    assert refused(kill.kill_verdicts([KILL, KILL._replace(stiffness=3.0)])) == 1
    assert refused(kill.kill_verdicts([KILL._replace(while_starting=1)])) == 3


@pytest.mark.ros
@pytest.mark.slow
def test_a_short_run_at_a_low_rate_loses_nothing(tmp_path: Path) -> None:
    parameters = yaml.safe_load(PAPER.read_text())
    # A sender that is late catches up, and what it then sends would be pooled.
    parameters["/**"]["ros__parameters"]["limits.pool_period"] = 0.0
    (tmp_path / "drive.yaml").write_text(yaml.safe_dump(parameters))
    run = rate.run_rate(tmp_path / "drive.yaml", 50.0, 2.0, depth=200, warm_up=1.0)
    assert (run.sent, run.together) == (150, 1)
    assert run.accepted + run.rejected == 150
    assert run.states == 100
    assert 0.0 < run.p50 <= run.p99 <= run.longest


def test_parameters_of_several_drives_describe_each() -> None:
    values = drives.several_parameters(PAPER, 3)
    names = drives.drive_names(3)
    assert values["drives"] == list(names)
    assert len({load_settings(PAPER, values, drive=name).driver.name for name in names}) == 3
