"""Three processes over real DDS: the rig overloads the belt, the node says so, a client hears."""

import itertools
import os
import subprocess
import sys
from pathlib import Path

import pytest
from belt_msgs.msg import SlipAlarm
from node_harness import ROOT, Client, NodeProcess, ns

DRIVE = ROOT / "config" / "demo_drive.yaml"
RATE = 100.0
DURATION = 7.0
SCENARIO = f"""
name: overload
duration: {DURATION}
sample_rate: {RATE}
seed: 4
speed: [[0.0, 0.0], [1.0, 120.0]]
load: [[1.5, 0.0], [1.7, 30.0]]
condition: {{tension: 440.0, friction_stiffness: 6.0e+6}}
events:
  - {{at: 3.5, load: 70.0, over: 0.1}}
  - {{at: 5.0, load: 15.0, over: 0.1}}
"""
TRIP, GROSS_SLIP = 3, 3


@pytest.fixture(scope="module")
def overload(module_ros_domain: int, tmp_path_factory: pytest.TempPathFactory):
    """Run the overload once; the client that heard it, and the exit codes."""
    place: Path = tmp_path_factory.mktemp("overload")
    scenario = place / "overload.yaml"
    scenario.write_text(SCENARIO)
    client = Client(module_ros_domain)
    with NodeProcess(
        module_ros_domain, place / "node.log", DRIVE, input_reliability="reliable"
    ) as node:
        node.wait_for_log("active")
        client.until(lambda: client.node.count_publishers("belt_node/state") > 0)
        client.spin(1.0)
        rig = subprocess.Popen(
            [
                *(sys.executable, "-m", "belt_ros.rig.main", "--ros-args"),
                *("-p", f"config_file:={DRIVE}", "-p", f"scenario_file:={scenario}"),
                *("-p", "wait_for_subscriber:=20.0"),  # on a busy machine, longer than by default
            ],
            cwd=ROOT,
            env={**os.environ, "ROS_DOMAIN_ID": str(module_ros_domain)},
        )
        client.until(lambda: rig.poll() is not None, timeout=60.0)
        client.spin(1.0)
        assert node.alive, node.log
    client.close()
    assert rig.returncode == 0
    return client


def test_every_joint_state_gives_a_state_at_the_input_rate(overload) -> None:
    stamps = [ns(state.header.stamp) for state in overload.states]
    assert len(stamps) == round(DURATION * RATE) + 1
    assert all(b - a == round(1e9 / RATE) for a, b in itertools.pairwise(stamps))


def test_diagnostics_come_once_a_second(overload) -> None:
    times = [time for time, _ in overload.diagnostics]
    seconds = times[-1] - times[0]
    assert len(times) >= round(seconds)


def test_the_overload_raises_the_alarm_and_trips_it(overload) -> None:
    begin = ns(overload.states[0].header.stamp)
    raised = [alarm for alarm in overload.alarms if alarm.active]
    assert raised
    first = (ns(raised[0].header.stamp) - begin) * 1e-9
    assert 3.5 < first < 4.2
    trips = [alarm for alarm in raised if alarm.severity == TRIP]
    assert trips
    assert trips[0].condition == GROSS_SLIP
    assert "gross slip" in trips[0].message


def test_the_alarm_clears_after_the_overload_and_stays_latched(overload) -> None:
    silence = SlipAlarm.CONDITION_SENSOR_STALE  # once the rig has ended
    last = [alarm for alarm in overload.alarms if alarm.condition != silence][-1]
    assert not last.active
    assert last.latched_severity == TRIP
    assert not last.acknowledged
