"""Slip beyond creep, without what the spans take up while they are stretched.

As a belt is loaded, its tight span grows longer and its slack span shorter; until then the driver
is ahead of the driven pulley by more than creep, and nothing slides. On a long elastic belt that is
centimetres, and at the start all that moves. It is the compliance of both spans times the change of
the effective pull, so over a short time it is known; over a moment it would be a noisy derivative.
"""

import math
from collections import deque
from typing import NamedTuple

from belt_ros.estimation.estimate import BeltEstimate, Quantity

_SECONDS = 1e-9
_WINDOW = 0.1  # [s]
_LONGEST = 1.0  # [s] between two estimates that are compared
_FOUND = 10.0  # times better known than a sample before: the pull was not known until now


class _Point(NamedTuple):
    stamp_ns: int
    travel: float  # of the driver's rim beyond creep [m]
    path: float  # of the driver's rim, forwards [m]
    pull: float  # [N]
    deviation: float  # of the pull [N]


class WindUp:
    """Follow one drive's slip.

    Parameters
    ----------
    compliance : float
        Rim travel between the pulleys per effective pull [m/N].
    driver_radius, driven_radius : float
        [m]
    slowest : float
        Rim speed [m/s] below which slip is referred to it; may change.
    """

    def __init__(
        self, compliance: float, driver_radius: float, driven_radius: float, slowest: float
    ) -> None:
        self._compliance = compliance
        self._driver_radius = driver_radius
        self._driven_radius = driven_radius
        self.slowest = slowest
        self._points: deque[_Point] = deque()
        self._speed = 0.0

    def slip(self, estimate: BeltEstimate) -> Quantity:
        """Take in the next estimate; return the slip beyond creep and winding up [-]."""
        rim = estimate.driver_speed.value * self._driver_radius
        forwards = max(abs(rim), self.slowest)
        speed = estimate.excess_slip.value * math.copysign(forwards, rim)
        first = self._advance(estimate, speed, forwards)
        last = self._points[-1]
        path = last.path - first.path
        if path <= 0.0:
            return estimate.excess_slip
        stretched = self._compliance * (last.pull - first.pull)
        along = math.copysign(1.0, rim) * (last.travel - first.travel - stretched)
        unknown = self._compliance * math.hypot(first.deviation, last.deviation) / path
        return Quantity(along / path, math.hypot(estimate.excess_slip.stddev, unknown))

    def _advance(self, estimate: BeltEstimate, speed: float, forwards: float) -> _Point:
        """Add a point; return that from which the present window begins."""
        points, stamp_ns = self._points, estimate.stamp_ns
        torque = estimate.transmitted_torque
        travel = path = 0.0
        pull, deviation = torque.value / self._driven_radius, torque.stddev / self._driven_radius
        if points and points[-1].deviation > _FOUND * deviation:
            points.clear()
        if points:
            dt = (stamp_ns - points[-1].stamp_ns) * _SECONDS
            if 0.0 < dt <= _LONGEST:
                travel = points[-1].travel + 0.5 * dt * (self._speed + speed)
                path = points[-1].path + dt * forwards
            else:
                points.clear()
        self._speed = speed
        points.append(_Point(stamp_ns, travel, path, pull, deviation))
        while len(points) > 2 and (stamp_ns - points[1].stamp_ns) * _SECONDS >= _WINDOW:
            points.popleft()
        return points[0]
