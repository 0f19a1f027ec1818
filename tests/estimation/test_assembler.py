"""Samples of several sources become one row of measurements, in order, none lost or doubled."""

import dataclasses
import itertools
import math
import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from belt_ros.estimation import Joint, Measurement, measurement_from_joints
from belt_ros.estimation.assembler import Assembler, Dropped, joined
from belt_ros.estimation.joint_readings import JointReadings
from belt_ros.estimation.measurement import Sensor

MILLISECOND = 1_000_000
SECOND = 1_000_000_000
CHANNELS = [sensor.name.lower() for sensor in Sensor]
SIMPLE = settings(derandomize=True, deadline=None, max_examples=200)


def sample(channel: int, milliseconds: float, value: float | None = None) -> Measurement:
    """What source number `channel` measures: the quantity of that place."""
    stamp = round(milliseconds * MILLISECOND)
    return Measurement(stamp, **{CHANNELS[channel]: milliseconds if value is None else value})


def measured(measurement: Measurement) -> dict[str, float]:
    values = {name: getattr(measurement, name) for name in CHANNELS}
    return {name: value for name, value in values.items() if not math.isnan(value)}


def run(assembler: Assembler, sent: list[tuple[int, float]]) -> list[Measurement | Dropped]:
    return [out for source, time in sent for out in assembler.add(source, sample(source, time))]


def seen(out: list[Measurement | Dropped]) -> list[tuple[float, ...]]:
    """For each measurement, the times [ms] that its samples were sent at."""
    return [tuple(measured(item).values()) for item in out if isinstance(item, Measurement)]


def test_a_single_source_is_passed_through_as_it_is() -> None:
    assembler = Assembler(window=0.0, slop=0.0, sources=1, most=10)
    sent = [sample(0, time) for time in (5.0, 3.0, 3.0, 9000.0, 1.0)]

    for item in sent:
        (out,) = assembler.add(0, item)
        assert out is item
    assert assembler.pending == 0


def test_samples_of_one_instant_are_joined_and_leave_when_all_have_been_heard() -> None:
    assembler = Assembler(window=1.0, slop=0.0, sources=2, most=10)

    assert run(assembler, [(0, 10.0)]) == []
    (out,) = run(assembler, [(1, 10.0)])

    assert out == Measurement(10 * MILLISECOND, driver_speed=10.0, driven_speed=10.0)
    assert assembler.pending == 0


def test_what_is_joined_within_the_slop_has_the_earliest_stamp() -> None:
    assembler = Assembler(window=1.0, slop=0.001, sources=2, most=10)
    first, second = run(assembler, [(0, 10.9), (1, 10.0), (0, 20.0), (1, 21.1), (1, 30.0)])

    assert first == Measurement(10 * MILLISECOND, driver_speed=10.9, driven_speed=10.0)
    assert second == Measurement(20 * MILLISECOND, driver_speed=20.0)


def test_samples_of_the_same_quantity_are_not_joined() -> None:
    assembler = Assembler(window=1.0, slop=0.001, sources=2, most=10)
    out = [
        item
        for source, time in [(0, 10.0), (1, 10.5), (0, 20.0), (1, 20.0)]
        for item in assembler.add(source, sample(0, time))
    ]

    assert seen(out) == [(10.0,), (10.5,), (20.0,)]
    assert assembler.pending == 1  # the other of 20.0


def test_sources_at_different_rates_leave_in_the_order_of_their_stamps() -> None:
    assembler = Assembler(window=1.0, slop=0.0, sources=2, most=100)
    out = run(assembler, [(0, 1), (0, 2), (0, 3), (1, 2.5), (0, 4), (0, 5), (1, 5)])

    assert seen(out) == [(1,), (2,), (2.5,), (3,), (4,), (5, 5)]


def test_a_silent_source_holds_up_the_others_for_the_window_only() -> None:
    assembler = Assembler(window=0.05, slop=0.0, sources=2, most=1000)
    run(assembler, [(0, 0), (1, 0)])
    for time in range(1, 990):
        out = run(assembler, [(0, time)])
        assert seen(out) == ([(time - 51.0,)] if time > 51 else [])


def test_a_source_silent_for_longer_than_the_gap_is_not_waited_for() -> None:
    assembler = Assembler(window=0.05, slop=0.0, sources=3, most=1000, gap=0.2)
    run(assembler, [(0, 0), (1, 0)])  # the third never says anything
    waiting = {}
    for time in range(10, 400, 10):
        run(assembler, [(0, time)])
        waiting[time] = assembler.pending

    assert all(waiting[time] == 6 for time in range(60, 201, 10))
    assert all(waiting[time] == 0 for time in range(210, 400, 10))


def test_another_gap_counts_at_once() -> None:
    assembler = Assembler(window=0.05, slop=0.0, sources=2, most=1000, gap=10.0)
    run(assembler, [(0, 0), (1, 0), *((0, time) for time in range(10, 310, 10))])
    assert assembler.pending > 0  # for the other source
    assembler.retune(0.2)
    run(assembler, [(0, 310)])
    assert assembler.pending == 0


def test_what_is_older_than_what_has_left_is_dropped() -> None:
    assembler = Assembler(window=0.05, slop=0.0, sources=2, most=100)
    out = run(assembler, [(0, 10), (0, 100), (1, 5), (1, 11)])

    assert out[0] == sample(0, 10)
    assert out[1:] == [Dropped(1, 5 * MILLISECOND), sample(1, 11)]


def test_no_more_wait_than_may() -> None:
    assembler = Assembler(window=10.0, slop=0.0, sources=2, most=5, gap=10.0)
    for time in range(100):
        run(assembler, [(0, time)])
        assert assembler.pending <= 5
    assert assembler.pending == 5


def test_flush_releases_all_in_order() -> None:
    assembler = Assembler(window=1.0, slop=0.0, sources=3, most=100)
    assert run(assembler, [(0, 3), (1, 1), (0, 4), (1, 3)]) == []

    assert seen([*assembler.flush()]) == [(1,), (3, 3), (4,)]
    assert assembler.pending == 0
    assert assembler.flush() == []


def test_a_bag_that_begins_again_goes_on_there_after_all_of_before_has_left() -> None:
    assembler = Assembler(window=0.05, slop=0.0, sources=2, most=100)
    out = run(assembler, [(0, 9000), (1, 9000), (0, 9010), (0, 0), (1, 0), (0, 10), (1, 10)])

    assert seen(out) == [(9000, 9000), (9010,), (0, 0), (10, 10)]
    assert not any(isinstance(item, Dropped) for item in out)


def test_a_jump_forwards_passes_as_well() -> None:
    assembler = Assembler(window=0.05, slop=0.0, sources=2, most=100)
    out = run(assembler, [(0, 0), (1, 0), (0, 10), (0, 9000), (1, 9000), (0, 9010), (1, 9010)])

    assert seen(out) == [(0, 0), (10,), (9000, 9000), (9010, 9010)]


def test_a_jump_of_those_that_live_is_one_though_another_has_died() -> None:
    assembler = Assembler(window=0.05, slop=0.0, sources=2, most=100)
    out = run(assembler, [(0, 9000), (1, 9000), *((0, time) for time in range(0, 200, 10))])

    assert [times[0] for times in seen(out)] == [9000, *range(0, 150, 10)][: len(seen(out))]
    assert assembler.pending <= 6


def test_what_has_long_been_dead_has_no_say_in_a_jump() -> None:
    assembler = Assembler(window=0.05, slop=0.0, sources=2, most=100, gap=0.2)
    run(assembler, [(1, 8500), *((0, 8500 + time) for time in range(0, 500, 10))])
    out = run(assembler, [(0, 0), (0, 10), (0, 60)])

    assert seen(out) == [(0,)]  # the jump is believed at once, and the dead waited for once more
    assert assembler.pending == 2


@pytest.mark.parametrize("wild", [0.0, 2.0e12])
def test_one_wild_stamp_is_dropped_and_disturbs_nothing(wild: float) -> None:
    assembler = Assembler(window=0.05, slop=0.0, sources=2, most=100)
    before = [(source, 5000.0 + time) for time in range(0, 50, 10) for source in (0, 1)]
    after = [(source, 5000.0 + time) for time in range(50, 100, 10) for source in (0, 1)]
    out = run(assembler, [*before, (1, wild), *after])

    assert seen(out) == [(5000.0 + time, 5000.0 + time) for time in range(0, 100, 10)]
    assert [item for item in out if isinstance(item, Dropped)] == [
        Dropped(1, round(wild) * MILLISECOND)
    ]


@pytest.mark.parametrize("skew", [-5000.0, 5000.0])
def test_a_source_whose_clock_is_wrong_makes_no_row_of_jumps(skew: float) -> None:
    assembler = Assembler(window=0.05, slop=0.0, sources=2, most=100)
    times = [10_000.0 + time for time in range(0, 2000, 10)]
    out = run(assembler, [(s, time + s * skew) for time in times for s in (0, 1)])
    stamps = [item.stamp_ns for item in out if isinstance(item, Measurement)]
    jumps = [abs(b - a) > SECOND for a, b in itertools.pairwise(stamps)]

    assert sum(jumps) <= 1
    assert len(stamps) >= 190  # those of the one that is believed


def test_with_disorder_a_source_is_sorted() -> None:
    assembler = Assembler(window=0.0, slop=0.0, sources=1, most=100, disorder=0.02, gap=1.0)
    sent = (10, 0, 20, 15, 5, 40, 25, 30, 100)
    out = run(assembler, [(0, time) for time in sent])

    assert seen(out + assembler.flush()) == [(time,) for time in sorted(sent)]


@pytest.mark.parametrize("bad", [math.nan, math.inf, -1.0])
@pytest.mark.parametrize("place", ["window", "slop", "disorder", "gap"])
def test_times_that_are_none_are_refused(place: str, bad: float) -> None:
    times = {"window": 0.0, "slop": 0.0, "disorder": 0.0, "gap": 1.0} | {place: bad}
    with pytest.raises(ValueError, match="finite"):
        Assembler(sources=2, most=10, **times)


def test_no_sources_and_no_room_are_refused() -> None:
    for numbers in ({"sources": 0, "most": 1}, {"sources": 1, "most": 0}):
        with pytest.raises(ValueError, match="at least one"):
            Assembler(0.0, 0.0, **numbers)


def test_joining_is_all_or_nothing() -> None:
    speed, torque = Measurement(1, driver_speed=1.0), Measurement(2, driver_torque=2.0)

    assert joined(speed, torque) == Measurement(1, driver_speed=1.0, driver_torque=2.0)
    assert joined(speed, Measurement(2, driver_speed=1.0, driver_torque=2.0)) is None


# Stamps of three sources, in any order whatever: near each other, far apart, equal.
anything = st.lists(
    st.tuples(
        st.integers(0, 2),
        st.one_of(
            st.integers(0, 200), st.integers(0, 40).map(lambda n: 100 * n), st.integers(0, 10**13)
        ),
    ),
    max_size=60,
)
configurations = st.builds(
    Assembler,
    window=st.sampled_from([0.0, 0.01, 0.05]),
    slop=st.sampled_from([0.0, 0.003]),
    sources=st.just(3),
    most=st.sampled_from([1, 4, 1000]),
    disorder=st.sampled_from([0.0, 0.01]),
    gap=st.sampled_from([0.0, 0.1, 1.0]),
)


@SIMPLE
@given(configurations, anything)
def test_nothing_is_lost_or_doubled_whatever_comes(
    assembler: Assembler, sent: list[tuple[int, int]]
) -> None:
    came, dropped = [], 0
    for number, (source, time) in enumerate(sent):
        out = assembler.add(source, sample(source, time, value=float(number)))
        came += [v for m in out if isinstance(m, Measurement) for v in measured(m).values()]
        dropped += sum(isinstance(item, Dropped) for item in out)
        assert len(came) + dropped + assembler.pending == number + 1
        assert assembler.pending <= assembler._most
    came += [value for m in assembler.flush() for value in measured(m).values()]

    assert assembler.pending == 0
    assert len(set(came)) == len(came) == len(sent) - dropped


@SIMPLE
@given(configurations, anything)
def test_stamps_decrease_only_at_a_jump(assembler: Assembler, sent: list[tuple[int, int]]) -> None:
    gap = assembler._gap
    out: list[Measurement | Dropped] = []
    for source, time in sent:
        out += assembler.add(source, sample(source, time))
    out += assembler.flush()
    newest = previous = 0
    for stamp in (item.stamp_ns for item in out if isinstance(item, Measurement)):
        jumped = stamp < newest - gap
        assert jumped or stamp >= previous
        newest = stamp if jumped else max(newest, stamp)
        previous = stamp


rates = st.tuples(*[st.integers(1, 12)] * 3)
seeds = st.integers(0, 2**32 - 1)


def regular(periods: tuple[int, ...], jitter: random.Random) -> list[tuple[int, float]]:
    """Three sources of constant rates for 300 ms, of unequal phase, by stamp."""
    sent = [
        (source, time + phase)
        for source, period in enumerate(periods)
        for phase in [jitter.choice([0.0, 0.25, 0.5])]
        for time in range(0, 300, period)
    ]
    return sorted(sent, key=lambda item: item[1])


@SIMPLE
@given(rates, seeds, st.sampled_from([0.0, 0.0003, 0.002]))
def test_arrival_in_any_order_within_the_window_gives_the_same(
    periods: tuple[int, ...], seed: int, slop: float
) -> None:
    chance = random.Random(seed)
    sent = regular(periods, chance)
    # Each source is late by a time of its own, which may vary, but keeps its order.
    delay = [chance.uniform(0.0, 40.0) for _ in periods]
    due: list[tuple[float, int, float]] = []
    last = [-math.inf] * 3
    for source, time in sent:
        last[source] = max(last[source], time + delay[source] + chance.uniform(0.0, 5.0))
        due.append((last[source], source, time))
    shuffled = [(source, time) for _, source, time in sorted(due, key=lambda item: item[0])]

    def result(order: list[tuple[int, float]]) -> list[Measurement | Dropped]:
        assembler = Assembler(window=0.05, slop=slop, sources=3, most=1000)
        return run(assembler, order) + assembler.flush()

    assert result(shuffled) == result(sent)
    assert not any(isinstance(item, Dropped) for item in result(shuffled))


@SIMPLE
@given(rates, seeds, st.sampled_from([0.0, 0.0003, 0.002]))
def test_disorder_within_sources_gives_the_same(
    periods: tuple[int, ...], seed: int, slop: float
) -> None:
    chance = random.Random(seed)
    sent = regular(periods, chance)
    shuffled = sorted(sent, key=lambda item: item[1] + chance.uniform(0.0, 9.9))

    def result(order: list[tuple[int, float]]) -> list[Measurement | Dropped]:
        assembler = Assembler(window=0.05, slop=slop, sources=3, most=1000, disorder=0.01)
        return run(assembler, order) + assembler.flush()

    assert result(shuffled) == result(sent)
    assert not any(isinstance(item, Dropped) for item in result(shuffled))


JOINT = Joint("a", gear_ratio=3.0, sign=-1.0, torque_scale=0.7, torque_offset=0.2)
DRAGGING = dataclasses.replace(JOINT, name="b", drag_torque=0.4, drag_damping=0.01)


def test_joints_read_one_by_one_are_at_the_pulleys_what_a_joint_state_is() -> None:
    values = (30.0, 20.0), (2.0, -1.0), (5.0, 6.0)
    together = measurement_from_joints(JOINT, DRAGGING, 7, ["a", "b"], *values)
    read = Measurement(7, *(value for pair in values for value in pair))

    assert JointReadings(JOINT, DRAGGING).at_pulleys(read) == together


def test_a_torque_by_itself_loses_the_drag_at_the_last_speed() -> None:
    joints = JointReadings(JOINT, DRAGGING)
    torques = Measurement(8, driver_torque=2.0, driven_torque=-1.0)

    assert measured(joints.at_pulleys(torques)) == {
        "driver_torque": JOINT.pulley_torque(2.0, 0.0)  # there is no drag to know
    }
    joints.at_pulleys(Measurement(9, driven_speed=20.0))
    assert measured(joints.at_pulleys(torques)) == {
        "driver_torque": JOINT.pulley_torque(2.0, 0.0),
        "driven_torque": DRAGGING.pulley_torque(-1.0, DRAGGING.pulley_speed(20.0)),
    }


def test_loads_are_forces_already() -> None:
    loads = Measurement(1, driver_hub_load=1.0, driven_hub_load=2.0, span_tension=3.0)

    assert JointReadings(JOINT, JOINT).at_pulleys(loads).loads == loads.loads
