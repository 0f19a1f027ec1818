"""Where a motion begins if sensors speak in turns."""

import math

from belt_ros.estimation import Measurement
from belt_ros.estimation.first_readings import FirstReadings

MS = 1_000_000  # [ns]


def test_a_measurement_with_both_speeds_is_taken_as_it_is() -> None:
    first = FirstReadings()
    assert first.gather(Measurement(0, driver_speed=1.0, driver_torque=9.0)) is None
    whole = Measurement(MS, 2.0, 3.0)
    assert first.gather(whole) is whole


def test_a_speed_waits_for_the_other_and_the_latest_readings_count() -> None:
    first = FirstReadings()
    assert first.gather(Measurement(0, driver_speed=1.0, driver_torque=5.0)) is None
    assert first.gather(Measurement(MS, driver_speed=1.5)) is None
    assert first.gather(Measurement(2 * MS, driven_torque=-4.0)) is None
    begun = first.gather(Measurement(3 * MS, driven_speed=2.5))
    assert begun is not None
    assert begun.stamp_ns == 3 * MS
    assert begun.speeds == (1.5, 2.5)
    assert begun.torques == (5.0, -4.0)
    assert math.isnan(begun.driver_position)


def test_what_was_read_long_before_or_is_stamped_later_does_not_count() -> None:
    for stamp_ns in (-501 * MS, MS):
        first = FirstReadings()
        assert first.gather(Measurement(stamp_ns, driver_speed=1.0)) is None
        assert first.gather(Measurement(0, driven_speed=2.0)) is None


def test_what_has_been_used_is_forgotten() -> None:
    first = FirstReadings()
    first.gather(Measurement(0, driver_speed=1.0))
    assert first.gather(Measurement(MS, driven_speed=2.0)) is not None
    assert first.gather(Measurement(2 * MS, driven_speed=2.0)) is None
