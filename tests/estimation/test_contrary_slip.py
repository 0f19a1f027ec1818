"""A belt cannot slip against the power that it transmits: then a sensor is wrong, not the belt."""

from pathlib import Path

import numpy as np

from belt_ros.estimation import Phase, measurement_from_joints
from belt_ros.rig import simulate
from belt_ros.rig.faults import Fault, FaultKind, SensorFaults
from belt_ros.rig.scenario import scenario_from_mapping
from belt_ros.settings import load_settings

CONVEYOR = Path(__file__).resolve().parents[2] / "config" / "conveyor_drive.yaml"
BEGIN, END, LAST = 6.0, 9.0, 11.0  # [s]


def test_a_torque_of_the_wrong_sign_teaches_nothing_of_the_tension() -> None:
    """On a long conveyor of whose tail no torque is measured, nothing else contradicts it."""
    conveyor = load_settings(CONVEYOR)
    script = {
        "duration": LAST,
        "seed": 1,
        "sample_rate": 50.0,
        "speed": [[0.5, 0.0], [3.0, 5.0]],
        "load": [[0.0, 15.0], [3.5, 15.0], [5.0, 60.0]],
        "motor.bandwidth": 3.0,
        "condition.tension": 1100.0,
    }
    faults = SensorFaults(np.random.default_rng(0))
    faults.add(Fault(FaultKind.WRONG_SIGN, BEGIN, END, "driver_torque", float("nan")))
    faults.add(Fault(FaultKind.DROPOUT, 0.0, LAST, "driven_torque", float("nan")))
    monitor = conveyor.monitor()
    phases = set()
    for sample in simulate(conveyor, scenario_from_mapping(script, conveyor)):
        for stamp_ns, joints in faults.reports(sample.stamp_ns, sample.joints):
            read = measurement_from_joints(
                conveyor.driver,
                conveyor.driven,
                stamp_ns,
                joints.names,
                joints.velocities,
                joints.efforts,
                joints.positions,
            )
            estimate = monitor.step(read).estimate
            if BEGIN < stamp_ns * 1e-9 < END:
                phases.add(estimate.phase)
    assert Phase.LOST in phases
    assert estimate.phase is Phase.RUNNING
    tension, margin = estimate.mean_tension, estimate.margin
    assert abs(tension.value - sample.truth.mean_tension) < 2.0 * tension.stddev < 1000.0
    assert abs(margin.value - sample.truth.margin) < 2.0 * margin.stddev
