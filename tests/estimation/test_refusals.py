"""Some of what a sensor says is impossible: what is told of the sensor, and still of the belt."""

import dataclasses
import itertools
import math
from collections.abc import Iterable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from runs import scripted

from belt_ros.estimation import Condition, Measurement, Severity
from belt_ros.estimation.condition import ConditionAlarm, Delays, Evidence
from belt_ros.estimation.refusals import Refusals
from belt_ros.estimation.suspicion import Suspicion
from belt_ros.settings import DriveSettings

OVERLOAD = {
    "duration": 12.0,
    "sample_rate": 100.0,
    "seed": 1,
    "speed": 100.0,
    "load": [[0, 10], [1, 20], [5, 20], [6, 66]],  # slips from 6 s on
}
BAD_FROM = 3.0  # [s]
STEP_NS = 10_000_000


def infinite(measurement: Measurement) -> Measurement:
    return dataclasses.replace(measurement, driver_speed=math.inf)


def spiked(measurement: Measurement) -> Measurement:
    """Not beyond the range, but statistically impossible."""
    return dataclasses.replace(measurement, driver_speed=3.0 * measurement.driver_speed)


def raised(
    settings: DriveSettings, bad: Iterable[bool], alter=infinite
) -> dict[Condition, tuple[float, Severity]]:
    """Return when each condition was told first [s] and how badly at worst, with some bad input."""
    monitor = settings.monitor()
    told: dict[Condition, tuple[float, Severity]] = {}
    for (measurement, _), is_bad in zip(scripted(settings, **OVERLOAD), bad, strict=False):
        seconds = measurement.stamp_ns * 1e-9
        output = monitor.step(alter(measurement) if is_bad else measurement)
        for each in output.alarm.conditions if output.alarm else ():
            first, worst = told.get(each.condition, (seconds, each.severity))
            told[each.condition] = first, max(worst, each.severity)
    return told


def every(count: int) -> Iterable[bool]:
    return (k > BAD_FROM * 100 and k % count == 0 for k in itertools.count())


@pytest.mark.parametrize("alter", [infinite, spiked])
@pytest.mark.parametrize("count", [3, 4])
def test_a_belt_that_slips_is_told_of_though_some_messages_are_always_bad(
    settings: DriveSettings, count: int, alter
) -> None:
    """It waits for a suspicion that has just come up, as it does at one in four, but not longer."""
    told = raised(settings, every(count), alter)
    assert told[Condition.GROSS_SLIP][1] is Severity.TRIP
    assert told[Condition.GROSS_SLIP][0] < 6.3 + 2.2


@pytest.mark.parametrize("share", [0.3, 0.4, 0.5, 0.6])
def test_at_any_share_of_bad_messages_either_the_sensor_or_the_belt_is_told_of(
    settings: DriveSettings, share: float
) -> None:
    rng = np.random.default_rng(3)
    told = raised(settings, (k > 300 and rng.random() < share for k in itertools.count()))
    assert Condition.GROSS_SLIP in told or Condition.SENSOR_IMPLAUSIBLE in told


def test_every_other_message_bad_makes_the_sensor_implausible(settings: DriveSettings) -> None:
    """At half of them the share swings about its threshold, which is no reason to keep silent."""
    told = raised(settings, every(2))
    assert told[Condition.SENSOR_IMPLAUSIBLE][0] < BAD_FROM + 3.0


@pytest.mark.parametrize("period", [0.0, 0.01, 0.05])
@pytest.mark.parametrize("count", [10, 20])
def test_a_share_is_what_it_is_however_measurements_are_pooled(
    settings: DriveSettings, period: float, count: int
) -> None:
    limits = dataclasses.replace(settings.limits, pool_period=period)
    monitor = dataclasses.replace(settings, limits=limits).monitor()
    fast = {"duration": 3.0, "sample_rate": 1000.0, "seed": 1, "speed": 100.0, "load": 20.0}
    for k, (measurement, _) in enumerate(scripted(settings, **fast)):
        output = monitor.step(infinite(measurement) if k > 1000 and k % count == 0 else measurement)
        assert output.alarm is None or output.alarm.condition is Condition.NONE
    assert monitor.alarm.watch.refused == pytest.approx(1.0 / count, abs=0.03)


def test_what_is_refused_is_forgotten_in_half_a_second() -> None:
    refusals = Refusals()
    for k in range(200):
        refusals.count(k * STEP_NS, refused=True)
    assert refusals.share == pytest.approx(1.0)
    for k in range(200, 250):
        refusals.count(k * STEP_NS, refused=False)
    assert refusals.share == pytest.approx(math.exp(-1.0), rel=0.03)


@given(st.integers(-10_000, 10_000_000_000), st.integers(0, 4))
def test_no_single_measurement_makes_a_verdict(after_ns: int, before: int) -> None:
    refusals = Refusals()
    for k in range(before):
        refusals.count(k * STEP_NS, refused=False)
    refusals.count(before * STEP_NS + after_ns, refused=True)
    assert refusals.share <= 0.2 + 1e-12


@given(st.lists(st.tuples(st.integers(-(10**9), 10**10), st.integers(1, 500), st.booleans())))
def test_a_share_stays_one_whatever_the_stamps_do(events) -> None:
    refusals, now = Refusals(), 0
    for step, number, refused in events:
        now += step
        refusals.count(now, number, refused=refused)
        assert 0.0 <= refusals.share <= 1.0


@pytest.mark.parametrize(("gap", "rate"), [(1.0, 100.0), (0.3, 100.0), (0.1, 100.0), (1.0, 4.0)])
def test_a_sensor_that_says_nothing_but_nonsense_is_named(
    settings: DriveSettings, gap: float, rate: float
) -> None:
    """However short the greatest gap: what is refused goes on counting while nothing is used."""
    limits = dataclasses.replace(settings.limits, greatest_gap=gap)
    monitor = dataclasses.replace(settings, limits=limits).monitor()
    told = []
    for k in range(400):
        speed = 100.0 if k < 300 else math.inf
        output = monitor.step(Measurement(round(k / rate * 1e9), speed, 99.5, 10.0, -10.0))
        told += [output.alarm.condition] if output.alarm else []
    assert told[-1] is Condition.SENSOR_IMPLAUSIBLE


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_sensor_that_fails_beside_a_flaky_one_is_still_not_taken_for_the_belt(
    settings: DriveSettings, seed: int
) -> None:
    monitor, rng = settings.monitor(), np.random.default_rng(seed)
    told: set[Condition] = set()
    for k in range(1100):
        failed = k > 800
        speed = 100.0 + (20.0 * math.sin(0.02 * (k - 800)) if failed else 0.0)
        a, b, c, d = (rng.normal(size=4) * (0.01, 0.01, 0.05, 0.05)).tolist()
        flaky = math.inf if k > 200 and rng.random() < 0.3 else 0.0
        driver = 0.0 if failed else speed + a
        output = monitor.step(
            Measurement(k * STEP_NS, driver, 0.995 * speed + b, 10.0 + c + flaky, -10.0 + d)
        )
        told |= {each.condition for each in output.alarm.conditions} if output.alarm else set()
    assert Condition.SENSOR_IMPLAUSIBLE in told
    assert Condition.GROSS_SLIP not in told


def test_a_suspicion_does_not_grow_old_while_nothing_is_observed() -> None:
    suspicion = Suspicion()
    waits = [suspicion.holds_back(dt, 2.0, 1.0, suspected=True) for dt in (0.0, 1.0, 0.9, 0.2)]
    assert waits == [True, True, True, False]
    assert not suspicion.holds_back(0.5, 2.0, 1.0, suspected=False)
    assert not suspicion.holds_back(0.1, 2.0, 1.0, suspected=True)  # the same one, still
    assert not suspicion.holds_back(1.1, 2.0, 1.0, suspected=False)
    assert suspicion.holds_back(0.1, 2.0, 1.0, suspected=True)


def test_what_is_pooled_is_no_step_back_in_time() -> None:
    """Refused messages are later than the mean of those pooled around them."""
    alarm = ConditionAlarm(Condition.SENSOR_IMPLAUSIBLE, (Severity.ALARM,))
    met, delays = (Evidence.MET,), Delays(0.2, 1.0)
    stamps = [stamp for k in range(40) for stamp in (10 * k, 10 * k - 5)]  # [ms]
    rose = [at for at in stamps if alarm.update(at * 1_000_000, met, delays, longest=1.0)]
    assert rose == [200]
