"""Loops of any pulleys, drawn at random or made by hand, shared by the tests of loops."""

import functools
import math
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from drawing import spread
from hypothesis import assume, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from belt_ros.mechanics import Belt, DriveError, Kinematics, Pulley
from belt_ros.mechanics.layout import Disc, Side, trace
from belt_ros.mechanics.loop import (
    BeltLoop,
    FixedCentres,
    HeldSpan,
    HubLoad,
    LoopPulley,
    loop_pulleys,
)
from belt_ros.mechanics.loop_equilibrium import LoopEquilibrium, loop_margin, solve_loop

REPEATABLE = settings(derandomize=True, deadline=None, max_examples=100)
NAMES = "abcdef"
PULLS = st.sampled_from([-1.0, -0.3, 0.0, 0.3, 1.0])
LOADS = st.floats(0.01, 0.97) | st.floats(0.9, 0.97)  # shares of the capacity


class Case(NamedTuple):
    """A loop, the state asked of it, and where it came from."""

    loop: BeltLoop
    torque: NDArray[np.float64]
    held: float
    speed: float

    def solve(self) -> LoopEquilibrium:
        return solve_loop(self.loop, self.torque, self.held, self.speed)


@functools.cache
def tensionings(names: tuple[str, ...]) -> st.SearchStrategy[Any]:
    name = st.sampled_from(names)
    return st.one_of(
        st.builds(FixedCentres),
        st.builds(HeldSpan, name),
        st.builds(HubLoad, name, st.floats(-0.6, 0.6)),
    )


def scale_of(margin: Any) -> float:
    """By how much all torques may grow."""
    return 1.0 / (1.0 - float(margin)) if float(margin) < 1.0 else math.inf


@st.composite
def given_wraps(draw: st.DrawFn, axial: float) -> tuple[LoopPulley, ...]:
    """Pulleys with random wraps and spans, without a layout that has them."""
    soft = draw(st.booleans())  # so that the belt re-sticks
    grips, frictions = ((0.3, 0.7), (0.9, 1.6)) if soft else ((0.1, 40.0), (0.2, 1.5))
    wraps = (2.5, 5.0) if soft else (0.3, 5.0)

    def pulley() -> Pulley:
        radius = draw(spread(0.02, 0.3))
        stiffness = axial * (draw(spread(*grips)) / radius) ** 2
        return Pulley(radius, draw(st.floats(*wraps)), draw(st.floats(*frictions)), stiffness)

    names = NAMES[: draw(st.integers(3, 6))]
    return tuple(LoopPulley(name, pulley(), draw(spread(0.05, 2.0))) for name in names)


@st.composite
def cases(
    draw: st.DrawFn,
    *,
    massless: bool = False,
    tensioning: Any = None,
    kinematics: Kinematics | None = None,
) -> Case:
    """A random loop of 3 to 6 pulleys, loaded up to a share of its capacity."""
    axial = draw(spread(3e3, 3e6))
    tension = axial * draw(spread(1e-4, 3e-2))
    pulleys = draw(given_wraps(axial))
    driver = draw(st.sampled_from(pulleys))
    speed = draw(spread(0.1, 500.0)) * draw(st.sampled_from([1.0, -1.0]))
    lift = 0.0 if massless else draw(spread(1e-3, 0.8)) * tension
    loop = BeltLoop(
        Belt(axial, lift / (speed * driver.pulley.radius) ** 2),
        pulleys,
        driver.name,
        kinematics or draw(st.sampled_from(Kinematics)),
        tensioning or draw(tensionings(tuple(p.name for p in pulleys))),
    )
    held = tension
    if isinstance(loop.tensioning, HubLoad):
        wrap = loop.pulleys[loop.index(loop.tensioning.on)].pulley.wrap_angle
        held = 2.0 * tension * math.sin(0.5 * wrap) * math.cos(loop.tensioning.angle)
    torque = np.array([draw(PULLS) * tension * p.pulley.radius for p in pulleys])
    torque[pulleys.index(driver)] = 0.0
    scale = scale_of(loop_margin(loop, torque, held, speed))
    load = draw(LOADS)
    return Case(loop, torque * min(scale * load, 3.0), held, speed)


def solved(case: Case) -> LoopEquilibrium:
    """Solution; discards the rare loops that would have to turn backwards."""
    try:
        return case.solve()
    except DriveError as error:
        assume("turn backwards" not in str(error))
        raise


def serpentine(**changed: Any) -> BeltLoop:
    """A crank, an idler on the belt's back, an alternator and a small pump."""
    layout = trace(
        [
            Disc(0.0, 0.0, 0.09),
            Disc(0.25, 0.03, 0.03, Side.CLOCKWISE),
            Disc(0.4, 0.2, 0.04),
            Disc(0.05, 0.35, 0.05),
        ]
    )
    names = ("crank", "idler", "alternator", "pump")
    pulleys = loop_pulleys(layout, names, [0.8, 0.5, 0.8, 0.2], 4e7)
    return replace(BeltLoop(Belt(6e4, 0.08), pulleys, "crank"), **changed)
