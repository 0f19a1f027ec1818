"""Signs that a sensor is not to be believed, in words."""

import dataclasses

import numpy as np
import pytest

from belt_ros.estimation import AlarmSettings, BeltEstimate, Measurement, Phase, Quantity
from belt_ros.estimation.condition import Evidence
from belt_ros.estimation.sensor_watch import SensorWatch
from belt_ros.estimation.state import Index
from belt_ros.settings import DriveSettings

STRICT = dataclasses.replace(AlarmSettings(), implausible_misfit=2.0)  # the least there is
SEEN = np.array([Index.DRIVER_SPEED, Index.DRIVEN_TORQUE])


def seeing(watch: SensorWatch, speed: float, torque: float) -> SensorWatch:
    """Two seconds of squared surprises."""
    for _ in range(200):
        watch.see(SEEN, np.array([speed, torque]), 0.01)
    return watch


def test_the_sensor_named_is_the_worst_of_those_that_are_read() -> None:
    watch = seeing(SensorWatch(), 0.1, 1.3)
    assert "shows in the driven torque" in watch.reason(STRICT)
    assert "shows in the driver speed" in seeing(watch, 9.0, 0.1).reason(STRICT)


def test_sensors_that_nobody_has_do_not_keep_the_condition_up() -> None:
    watch = seeing(SensorWatch(), 9.0, 0.1)
    assert watch.evidence(STRICT) is Evidence.MET
    assert seeing(watch, 0.3, 0.5).evidence(STRICT) is Evidence.GONE


def test_before_anything_is_seen_nothing_is_wrong() -> None:
    watch = SensorWatch()
    watch.see(np.array([], dtype=np.int64), np.array([]), 0.01)
    assert watch.evidence(AlarmSettings()) is Evidence.GONE
    assert watch.reason(AlarmSettings()) == "its readings fit again"


@pytest.fixture
def loaded(settings: DriveSettings) -> BeltEstimate:
    """Of a drive that carries 30 N m."""
    estimate = settings.monitor().step(Measurement(1, 100.0, 99.0, 30.0, -30.0)).estimate
    assert estimate is not None
    return dataclasses.replace(
        estimate, phase=Phase.RUNNING, transmitted_torque=Quantity(30.0, 0.1)
    )


@pytest.mark.parametrize(("creep", "against"), [(0.01, True), (0.06, False)])
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_belt_that_creeps_less_than_foretold_does_not_slip_against_the_power(
    loaded: BeltEstimate, creep: float, way: float, *, against: bool
) -> None:
    watch = SensorWatch()
    for sample in range(30):
        told = dataclasses.replace(
            loaded,
            stamp_ns=sample * 10_000_000,
            predicted_creep=Quantity(way * creep, 0.002),
            transmitted_torque=Quantity(way * 30.0, 0.1),
        )
        watch.accept(told, Quantity(way * -0.04, 0.003), AlarmSettings())
    assert watch.contradicts(doubted=False) is against
