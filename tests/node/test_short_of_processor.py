"""More input than the processor can follow: the node pools it, and stays with its machine."""

import math
import time
from collections.abc import Callable
from pathlib import Path

import yaml
from belt_msgs.msg import BeltState
from node_harness import PAPER_DRIVE, SECOND, Client, NodeProcess, joint_state, ns

from benchmarks.graph.drives import drive_names, several_parameters

DRIVES = 30
SECONDS, LONGEST = 8.0, 20.0
LATE = 1.0  # [s]
RATE = 100.0  # [Hz]


def many_drives(tmp_path: Path) -> tuple[Path, list[str]]:
    """So many of the paper's drives that no core steps them all a hundred times a second."""
    values = several_parameters(PAPER_DRIVE, DRIVES)
    joints = [
        str(values[f"{drive}.{pulley}.joint"])
        for drive in drive_names(DRIVES)
        for pulley in ("driver", "driven")
    ]
    path = tmp_path / "drives.yaml"
    path.write_text(yaml.safe_dump({"/**": {"ros__parameters": values}}))
    return path, joints


def swinging(client: Client, joints: list[str], followed: Callable[[], bool]) -> int:
    """Send what loads that swing all the time bring, each drive its own; return how many.

    Where others take the processor as well, the node needs longer to find out how much to pool, and
    is late until then: send until it has `followed`.
    """
    due = time.monotonic()
    for sample in range(round(LONGEST * RATE)):
        if sample >= SECONDS * RATE and followed():
            return sample
        client.now_ns = time.time_ns()
        torques = [
            30.0 + 10.0 * math.sin(2.0 * math.pi * (sample / 100.0 + number / DRIVES))
            for number in range(DRIVES)
        ]
        effort = [sign * torque for torque in torques for sign in (1.0, -1.0)]
        velocity = [speed for t in torques for speed in (120.0, 120.0 - 0.02 * t)]
        client.send_raw(joint_state(client.now_ns, velocity, effort, joints))
        due += 1.0 / RATE
        client.spin(due - time.monotonic())
    raise AssertionError(f"it falls behind for {LONGEST} s")


def test_short_of_processor_it_pools_and_loses_nothing(
    client: Client, ros_domain: int, tmp_path: Path
) -> None:
    params, joints = many_drives(tmp_path)
    states: list[tuple[float, BeltState]] = []

    def take(state: BeltState) -> None:
        states.append(((time.time_ns() - ns(state.header.stamp)) / SECOND, state))

    client.node.create_subscription(BeltState, "belt_node/drive_7/state", take, 1000)

    def late() -> float:
        return max((late for late, _ in states[-10:]), default=math.inf)

    overloaded = {"input_reliability": "reliable", "longest_pool": 0.2}
    with NodeProcess(ros_domain, tmp_path / "log", params, **overloaded) as node:
        node.wait_for_log("active, listening on")
        client.until(lambda: client.node.count_subscribers("joint_states") > 0)
        client.spin(0.5)
        sent = swinging(client, joints, lambda: late() < LATE)
        client.until(lambda: ns(states[-1][1].header.stamp) > client.now_ns - 0.5 * SECOND)
        row = client.row("belt_node: node")
        values = {pair.key: float(pair.value) for pair in row.values}

        last = states[-1][1]
        assert last.accepted_count > sent - 40  # what is still being pooled has not been counted
        assert sum(last.rejection_counts) == 0
        assert last.reset_count == 0
        assert late() < LATE
        assert 0.02 <= values["pooled for want of processor [s]"] <= 0.2
        assert "averaged" in row.message
        assert node.log.count("falls behind") == 1
        assert node.alive
