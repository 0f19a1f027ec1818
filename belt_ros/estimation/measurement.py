"""What the sensors said at one instant, how far that is believed, and why it may be turned away."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation.assumptions import Joint, SensorLimits
from belt_ros.mechanics._compile import compiled

_Floats = NDArray[np.float64]
_LARGEST_COUNT = 2.0**40  # of turns, beyond which adding one loses a part in 4000 of it


class Rejection(IntEnum):
    """Why a measurement was not used; the numbers are those of belt_msgs/BeltState."""

    NONE = 0
    NOT_FINITE = 1
    OUT_OF_RANGE = 2
    STALE = 3
    OUT_OF_ORDER = 4
    GATED = 5
    INCOMPLETE = 6
    MALFORMED = 7


class Sensor(IntEnum):
    """Places in a row of measured values, `Measurement.values`."""

    DRIVER_SPEED = 0
    DRIVEN_SPEED = 1
    DRIVER_TORQUE = 2
    DRIVEN_TORQUE = 3
    DRIVER_POSITION = 4
    DRIVEN_POSITION = 5
    DRIVER_HUB_LOAD = 6
    DRIVEN_HUB_LOAD = 7
    SPAN_TENSION = 8


@dataclass(frozen=True, slots=True)
class Measurement:
    """One stamped set of what was measured at the pulleys. NaN: not measured.

    Attributes
    ----------
    stamp_ns : int
        Time of the measurement [ns], on the sensors' clock.
    driver_speed, driven_speed : float
        omega2, omega1 [rad/s].
    driver_torque, driven_torque : float
        Put on the pulley from outside (motor, load), in its positive direction, bearing drag taken
        off [N m].
    driver_position, driven_position : float
        Angles of the pulleys [rad]; they may wrap with the turns of their joints, see `unwrapped`.
    driver_hub_load, driven_hub_load : float
        Force of the running belt on the shaft [N], along the bisector of its two spans: the line of
        centres of a drive of two pulleys. Weight and preload of the bearing are tared.
    span_tension : float
        Effective tension w = T - m v^2 [N] of the span that leaves the driven pulley in positive
        rotation, tight where the driver pulls it forward; what a roller that bends the span carries
        (see `load_sensors`).
    samples : tuple of float
        Of how many samples each value is the mean, in the order of `Sensor`; empty: of one.
    bending : tuple of float
        Variance by which each mean may differ from the value at the stamp, since it bends within
        the time pooled, in the order of `Sensor`; empty: none.
    pooled : int
        How many measurements this one stands for, see `pooling`.
    change : float
        For how long traction may have changed before it, as fast as it ever does [s], by what
        `lull` knows; NaN: ever since the measurement before.
    """

    stamp_ns: int
    driver_speed: float = math.nan
    driven_speed: float = math.nan
    driver_torque: float = math.nan
    driven_torque: float = math.nan
    driver_position: float = math.nan
    driven_position: float = math.nan
    driver_hub_load: float = math.nan
    driven_hub_load: float = math.nan
    span_tension: float = math.nan
    samples: tuple[float, ...] = field(default=(), kw_only=True)
    bending: tuple[float, ...] = field(default=(), kw_only=True)
    pooled: int = field(default=1, kw_only=True)
    change: float = field(default=math.nan, kw_only=True)

    @property
    def speeds(self) -> tuple[float, float]:
        """Of driver and driven pulley [rad/s]."""
        return self.driver_speed, self.driven_speed

    @property
    def torques(self) -> tuple[float, float]:
        """On driver and driven pulley [N m]."""
        return self.driver_torque, self.driven_torque

    @property
    def positions(self) -> tuple[float, float]:
        """Of driver and driven pulley [rad]."""
        return self.driver_position, self.driven_position

    @property
    def loads(self) -> tuple[float, float, float]:
        """Hub loads of driver and driven pulley, span tension [N]."""
        return self.driver_hub_load, self.driven_hub_load, self.span_tension

    def values(self) -> _Floats:
        """Return all that was measured (9,), in the order of `Sensor`."""
        return np.array(self.speeds + self.torques + self.positions + self.loads)


@compiled
def sensor_variances(values: _Floats, noise: _Floats) -> _Floats:
    """Variances (9,) of measured `values` (9,); NaN where nothing was measured.

    Parameters
    ----------
    values : ndarray
        (9,) from `Measurement.values`.
    noise : ndarray
        (2, 9) from `SensorNoise.noise_rows`.
    """
    variances: _Floats = noise[0] * values * values + noise[1]
    return variances


@compiled
def unwrapped(previous: float, present: float, expected_increment: float, turn: float) -> float:
    """Return a position with the whole turns that its encoder does not count.

    Continuous joints report within +-pi, some encoders within 0 to 2 pi. The turns are added that
    bring the increment within half a turn of the one expected; where it already is, as of an
    encoder that counts on, the position stays. So the expectation, e.g. speed times time, must be
    right to half a turn of the joint: across a gap in which it may not be, start anew.

    Parameters
    ----------
    previous : float
        The position before, unwrapped [rad].
    present : float
        The position as reported [rad].
    expected_increment : float
        By how much it has probably moved since [rad].
    turn : float
        One turn of the joint, seen where the positions are: 2 pi at the joint, `Joint.turn` at the
        pulley [rad].

    Returns
    -------
    float
        `present` itself if anything is not finite, or so large that a turn is lost in rounding.
    """
    missing = (expected_increment - (present - previous)) / turn
    largest = max(abs(missing), abs(present / turn))
    if not largest < _LARGEST_COUNT:
        return present
    return present + turn * math.floor(missing + 0.5)


def check_measurement(measurement: Measurement, limits: SensorLimits) -> Rejection:
    """Return why `measurement` cannot be used by itself, or `Rejection.NONE`.

    Something must be there; whatever is NaN was not measured.
    """
    m = measurement
    if any(map(math.isinf, m.speeds + m.torques + m.positions + m.loads)):
        return Rejection.NOT_FINITE
    if all(map(math.isnan, m.speeds + m.torques + m.positions + m.loads)):
        return Rejection.NOT_FINITE
    limited = (
        (m.speeds, limits.greatest_speed),
        (m.torques, limits.greatest_torque),
        (m.loads, limits.greatest_load),
    )
    for values, greatest in limited:
        if any(abs(value) > greatest for value in values):
            return Rejection.OUT_OF_RANGE
    return Rejection.NONE


def of_others(driver: Joint, driven: Joint, names: Sequence[str]) -> bool:
    """Whether there are joints, and neither is one of the two."""
    return len(names) > 0 and driver.name not in names and driven.name not in names


def measurement_from_joints(
    driver: Joint,
    driven: Joint,
    stamp_ns: int,
    names: Sequence[str],
    velocities: Sequence[float],
    efforts: Sequence[float],
    positions: Sequence[float] = (),
) -> Measurement | Rejection | None:
    """Read the two pulleys out of a joint state (sensor_msgs/JointState, live or from a bag).

    A torque or position that the message does not carry is NaN. A message with only one of the two
    joints, or whose arrays do not match its names, gives the reason instead; one with neither is
    somebody else's, who shares the topic, and gives None.
    """
    count = len(names)
    if of_others(driver, driven, names):
        return None
    lengths = (len(velocities), len(efforts), len(positions))
    if count == 0 or any(length not in (0, count) for length in lengths):
        return Rejection.MALFORMED
    if len(velocities) == 0:
        return Rejection.INCOMPLETE
    try:
        at_driver = names.index(driver.name)
        at_driven = names.index(driven.name)
    except ValueError:
        return Rejection.INCOMPLETE
    driver_speed = driver.pulley_speed(float(velocities[at_driver]))
    driven_speed = driven.pulley_speed(float(velocities[at_driven]))
    driver_torque = driven_torque = driver_position = driven_position = math.nan
    if len(efforts) > 0:
        driver_torque = driver.pulley_torque(float(efforts[at_driver]), driver_speed)
        driven_torque = driven.pulley_torque(float(efforts[at_driven]), driven_speed)
    if len(positions) > 0:
        driver_position = driver.pulley_position(float(positions[at_driver]))
        driven_position = driven.pulley_position(float(positions[at_driven]))
    return Measurement(
        stamp_ns,
        driver_speed,
        driven_speed,
        driver_torque,
        driven_torque,
        driver_position,
        driven_position,
    )
