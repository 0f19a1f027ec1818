"""Each fault does to readings what it says, for as long as it says, and nothing else."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from belt_ros.rig.faults import PLACES, Fault, FaultKind, Report, SensorFaults
from belt_ros.rig.sensors import JointSample

PERIOD_NS = 10_000_000
Passed = list[tuple[int, list[Report]]]  # (time [ms], what goes out then)


def reading(number: int) -> JointSample:
    """All six readings tell the number of their sample, and none is like another."""
    return JointSample(
        ("driver", "driven"),
        (number + 0.1, number + 0.2),
        (number + 0.3, number + 0.4),
        (number + 0.5, number + 0.6),
    )


def passed(*faults: Fault, samples: int = 20, start_ns: int = 10**18, seed: int = 0) -> Passed:
    """What goes out of a run of `samples` at 100 Hz, with stamps since its start."""
    pipeline = SensorFaults(np.random.default_rng(seed))
    for fault in faults:
        pipeline.add(fault, start_ns)
    out: Passed = []
    for number in range(samples):
        now = start_ns + number * PERIOD_NS
        reports = pipeline.reports(now, reading(number))
        out.append((10 * number, [Report(stamp - start_ns, joints) for stamp, joints in reports]))
    return out


def row(joints: JointSample) -> list[float]:
    return [*joints.positions, *joints.velocities, *joints.efforts]


def order(out: Passed) -> list[int]:
    """Numbers of the samples that come out, in the order in which they do."""
    return [stamp // PERIOD_NS for _, reports in out for stamp, _ in reports]


def test_without_faults_readings_go_out_as_they_are() -> None:
    for number, (_, reports) in enumerate(passed()):
        assert reports == [Report(number * PERIOD_NS, reading(number))]


CHANGES: dict[FaultKind, tuple[float, Callable[[float, float], float]]] = {
    FaultKind.DROPOUT: (math.nan, lambda x, first: math.nan),
    FaultKind.STUCK: (math.nan, lambda x, first: first),
    FaultKind.SPIKE: (7.0, lambda x, first: x + 7.0),
    FaultKind.QUANTISED: (4.0, lambda x, first: 4.0 * round(x / 4.0)),
    FaultKind.DELAYED: (0.03, lambda x, first: max(x - 3.0, first)),
    FaultKind.WRONG_SIGN: (math.nan, lambda x, first: -x),
}
OF_JOINT_STATES = {FaultKind.DROPOUT, FaultKind.DELAYED}


@pytest.mark.parametrize(
    ("kind", "sensor"),
    [
        (kind, sensor)
        for kind in CHANGES
        for sensor in PLACES
        if sensor != "all" or kind not in OF_JOINT_STATES
    ],
)
def test_fault_of_a_sensor_changes_its_readings_from_begin_to_before_end(
    kind: FaultKind, sensor: str
) -> None:
    value, change = CHANGES[kind]
    out = passed(Fault(kind, 0.05, 0.12, sensor, value))

    for number, (_, reports) in enumerate(out):
        expected = row(reading(number))
        if 5 <= number < 12:
            for place in PLACES[sensor]:
                expected[place] = change(expected[place], row(reading(5))[place])
        (report,) = reports
        assert report.stamp_ns == number * PERIOD_NS
        np.testing.assert_allclose(row(report.joints), expected, rtol=1e-12)


def test_fault_without_length_acts_on_one_reading() -> None:
    out = passed(Fault(FaultKind.SPIKE, 0.043, 0.043, "driver_torque", 50.0))
    hit = [number for number, (_, [report]) in enumerate(out) if report.joints != reading(number)]
    assert hit == [5]


def test_dropout_of_all_leaves_nothing() -> None:
    assert order(passed(Fault(FaultKind.DROPOUT, 0.05, 0.12))) == [*range(5), *range(12, 20)]


def test_share_hits_some_readings_by_the_seed() -> None:
    fault = Fault(FaultKind.DROPOUT, 0.0, share=0.3)
    lost = 1.0 - len(order(passed(fault, samples=2000))) / 2000
    assert lost == pytest.approx(0.3, abs=0.04)
    assert order(passed(fault, seed=1)) == order(passed(fault, seed=1))
    assert order(passed(fault, seed=1)) != order(passed(fault, seed=2))


def test_delayed_joint_states_come_late_with_their_own_stamps() -> None:
    out = passed(Fault(FaultKind.DELAYED, 0.05, 0.12, value=0.03))

    arrivals = {stamp // 10**6: time for time, reports in out for stamp, _ in reports}
    for stamp, time in arrivals.items():
        assert time - stamp == (30 if 50 <= stamp < 120 else 0)
    assert len(arrivals) == 20


def test_when_a_delay_ends_late_joint_states_come_between_those_in_time() -> None:
    out = passed(Fault(FaultKind.DELAYED, 0.05, 0.12, value=0.03))
    assert order(out) == [*range(5), 5, 6, 7, 8, 9, 12, 10, 13, 11, 14, *range(15, 20)]


def test_delay_that_is_no_multiple_of_the_period_ends_with_the_next_sample() -> None:
    out = passed(Fault(FaultKind.DELAYED, 0.0, value=0.024))
    assert [len(reports) for _, reports in out[:5]] == [0, 0, 0, 1, 1]


def test_reordered_joint_states_come_in_swapped_pairs_and_none_is_lost() -> None:
    even = passed(Fault(FaultKind.REORDERED, 0.05, 0.11))
    assert order(even) == [*range(5), 6, 5, 8, 7, 10, 9, *range(11, 20)]
    odd = passed(Fault(FaultKind.REORDERED, 0.05, 0.12))
    assert order(odd) == [*range(5), 6, 5, 8, 7, 10, 9, 11, *range(12, 20)]


@pytest.mark.parametrize("jump", [5.0, -5.0])
def test_time_jump_moves_stamps_and_nothing_else(jump: float) -> None:
    out = passed(Fault(FaultKind.TIME_JUMP, 0.05, 0.12, value=jump))
    for number, (_, [report]) in enumerate(out):
        moved = round(jump * 1e9) if 5 <= number < 12 else 0
        assert report == Report(number * PERIOD_NS + moved, reading(number))


def test_faults_add_up() -> None:
    out = passed(
        Fault(FaultKind.SPIKE, 0.0, math.inf, "driver_speed", 1.0),
        Fault(FaultKind.WRONG_SIGN, 0.0, math.inf, "driver_speed"),
        Fault(FaultKind.TIME_JUMP, 0.0, value=1.0),
        Fault(FaultKind.DELAYED, 0.0, value=0.02),
    )
    time, (report,) = out[-1]
    assert report.stamp_ns - 10**9 == (time - 20) * 10**6
    assert report.joints.velocities[0] == pytest.approx(-(17 + 0.3 + 1.0))


VALUES = {FaultKind.SPIKE: 1e9, FaultKind.QUANTISED: 1e-9, FaultKind.DELAYED: 0.03}
FAULTS = st.builds(
    lambda kind, begin, length, sensor: Fault(
        kind,
        begin,
        begin + length,
        "all" if kind in {FaultKind.REORDERED, FaultKind.TIME_JUMP} else sensor,
        VALUES.get(kind, -1e6),
    ),
    st.sampled_from(FaultKind),
    st.floats(0.0, 0.2),
    st.sampled_from([0.0, 0.05, 1e308, math.inf]),
    st.sampled_from(list(PLACES)),
)


@settings(max_examples=200, deadline=None, derandomize=True)
@given(st.lists(FAULTS, max_size=6))
def test_any_faults_together_give_each_joint_state_once_at_most(faults: list[Fault]) -> None:
    out = passed(*faults, samples=30)
    assert sum(len(reports) for _, reports in out) <= 30
    for _, reports in out:
        for stamp, joints in reports:
            assert isinstance(stamp, int)
            assert not any(map(math.isinf, row(joints)))


def test_ended_faults_act_no_more_but_let_go_what_they_hold() -> None:
    pipeline = SensorFaults(np.random.default_rng(0))
    later = Fault(FaultKind.STUCK, 1.0)
    now = Fault(FaultKind.DELAYED, 0.0, value=0.02)
    for fault in (now, later):
        pipeline.add(fault)
    for number in range(5):
        pipeline.reports(number * PERIOD_NS, reading(number))

    assert pipeline.end() == (now,)
    out = [pipeline.reports(n * PERIOD_NS, reading(n)) for n in range(5, 8)]
    assert [[stamp // PERIOD_NS for stamp, _ in reports] for reports in out] == [
        [3, 5],
        [4, 6],
        [7],
    ]
    assert len(pipeline) == 1
    assert pipeline.end() == ()


def test_a_single_spike_that_waits_for_its_reading_is_ended_too() -> None:
    pipeline = SensorFaults(np.random.default_rng(0))
    pipeline.reports(0, reading(0))
    spike = Fault(FaultKind.SPIKE, 0.0, 0.0, "driver_torque", 50.0)
    pipeline.add(spike)

    assert pipeline.end() == (spike,)
    assert pipeline.reports(PERIOD_NS, reading(1)) == (Report(PERIOD_NS, reading(1)),)
    assert len(pipeline) == 0


def test_a_single_spike_that_has_been_read_is_no_more_to_be_ended() -> None:
    pipeline = SensorFaults(np.random.default_rng(0))
    pipeline.add(Fault(FaultKind.SPIKE, 0.0, 0.0, "driver_torque", 50.0))
    assert pipeline.reports(0, reading(0)) != (Report(0, reading(0)),)
    assert pipeline.end() == ()
