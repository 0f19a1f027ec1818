"""Arcs whose natural modes are sought, by hand and at random, shared by the tests of modes."""

import math
from typing import Any, NamedTuple

import numpy as np
import pytest
from drawing import spread
from hypothesis import settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from belt_ros.mechanics.arc import Role
from belt_ros.mechanics.stability import Modes, arc_modes

REPEATABLE = settings(derandomize=True, deadline=None, max_examples=100)
Complex = NDArray[np.complex128]


class Arc(NamedTuple):
    """Arguments of `arc_modes`, without the count."""

    role: Role = Role.DRIVEN
    radius: float = 0.08125
    wrap_angle: float = math.pi
    transition_angle: float = math.pi
    friction_coefficient: float = 1.2
    friction_stiffness: float = 8.1e7
    axial_stiffness: float = 80068.0
    mass_per_length: float = 0.1036
    speed: float = 9.75
    restick_angle: float = math.nan

    def modes(self, count: int = 3) -> Modes:
        return arc_modes(*self[:-1], count=count, restick_angle=self.restick_angle)

    @property
    def critical_speed(self) -> float:
        return math.sqrt(self.axial_stiffness / self.mass_per_length)

    @property
    def net(self) -> float:
        return self.axial_stiffness - self.mass_per_length * self.speed**2

    @property
    def zones(self) -> list[tuple[float, bool]]:
        """Length [m] of every zone and whether it slides."""
        end = self.wrap_angle if math.isnan(self.restick_angle) else self.restick_angle
        angles = (
            (self.transition_angle, False),
            (end - self.transition_angle, True),
            (self.wrap_angle - end, False),
        )
        return [(self.radius * angle, slides) for angle, slides in angles if angle > 0.0]

    def terms(self, omega: Any, slides: bool) -> tuple[Any, Any]:
        """First and zeroth coefficient of Eqs. 63-64, the second being -(EA - m v^2)."""
        m, v = self.mass_per_length, self.speed
        first, zeroth = 2j * omega * m * v, -m * omega**2
        if slides:
            friction = self.role * self.friction_coefficient / self.radius
            return first + friction * self.net, zeroth - 1j * omega * friction * m * v
        return first, zeroth + self.friction_stiffness


_COMPLIANT = Arc(friction_stiffness=2e6)  # near its capacity, it slides and re-sticks
ARCS = {
    "elastic": Arc(),
    "elastic, compliant": Arc(friction_stiffness=1e5, speed=400.0),
    "driven": Arc(transition_angle=2.158),
    "driver": Arc(role=Role.DRIVER, transition_angle=2.082),
    "driven, fast": Arc(transition_angle=1.0, speed=800.0),
    "driver, overdamped": Arc(role=Role.DRIVER, transition_angle=1.0, speed=700.0),
    "driver, near critical": Arc(role=Role.DRIVER, transition_angle=2.0, speed=870.0),
    "standstill": Arc(transition_angle=2.0, speed=0.0),
    "sliding all over": Arc(transition_angle=0.0, speed=100.0),
    "re-stuck": _COMPLIANT._replace(transition_angle=0.116178, restick_angle=1.846682),
    "re-stuck, fast": _COMPLIANT._replace(
        speed=400.0, transition_angle=0.122083, restick_angle=1.835723
    ),
}
every_arc = pytest.mark.parametrize("arc", ARCS.values(), ids=ARCS.keys())


@st.composite
def arcs(draw: st.DrawFn) -> Arc:
    """Arcs of any kind, stiffness and speed; a sliding zone of any length."""
    arc = Arc(
        role=draw(st.sampled_from(Role)),
        radius=draw(spread(0.02, 0.5)),
        wrap_angle=draw(st.floats(0.5, 6.0)),
        friction_coefficient=draw(st.floats(0.1, 1.5)),
        friction_stiffness=draw(spread(1e5, 1e11)),
        axial_stiffness=draw(spread(3e3, 3e6)),
        mass_per_length=draw(spread(1e-6, 3.0)),
    )
    ratio = draw(st.one_of(st.just(0.0), st.floats(0.0, 0.99), spread(1e-6, 1e-1)))
    part = draw(st.one_of(st.just(1.0), st.floats(0.0, 1.0)))
    arc = arc._replace(speed=ratio * arc.critical_speed, transition_angle=part * arc.wrap_angle)
    compliant = arc.friction_coefficient**2 > arc.friction_stiffness * arc.radius**2 / arc.net
    if arc.role is Role.DRIVEN and compliant and part < 1.0:
        again = draw(st.floats(0.01, 1.0))
        arc = arc._replace(
            restick_angle=arc.transition_angle + again * (1.0 - part) * arc.wrap_angle
        )
    return arc
