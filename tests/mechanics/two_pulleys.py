"""The paper's drive and random ones, shared by the tests of their steady state."""

import math
from typing import Any

from drawing import spread
from hypothesis import settings
from hypothesis import strategies as st

from belt_ros.mechanics import (
    Belt,
    BeltDrive,
    DriveError,
    Kinematics,
    Pulley,
    Tensioning,
    solve_equilibrium,
    torque_capacity,
)

REPEATABLE = settings(derandomize=True, deadline=None, max_examples=200)
PAPER_MASS = 0.1036


def paper_drive(stiffness: float, mass: float = 0.0, **changed: Any) -> BeltDrive:
    """Table 1."""
    pulley = Pulley(0.08125, math.pi, 1.2, stiffness)
    return BeltDrive(Belt(80068.0, mass), pulley, pulley, **changed)


@st.composite
def drives(
    draw: st.DrawFn, *, massless: bool = False, equal: bool = False
) -> tuple[BeltDrive, float, float]:
    """A drive, the tension it holds [N] and a driver speed [rad/s] at which the belt stays on."""
    axial = draw(spread(3e3, 3e6))
    tension = axial * draw(spread(1e-4, 3e-2))
    friction = draw(st.floats(0.1, 1.5))

    def pulley(friction: float) -> Pulley:
        radius = draw(spread(0.02, 0.5))
        b = draw(spread(0.05, 50.0))
        return Pulley(radius, draw(st.floats(0.5, 6.0)), friction, axial * (b / radius) ** 2)

    driven = pulley(friction)
    driver = driven if equal else pulley(friction * draw(st.floats(0.5, 2.0)))
    speed = draw(spread(0.1, 500.0)) * draw(st.sampled_from([1.0, -1.0]))
    lift = 0.0 if massless else draw(st.floats(0.0, 0.8)) * tension
    drive = BeltDrive(
        Belt(axial, lift / (speed * driver.radius) ** 2),
        driven,
        driver,
        kinematics=draw(st.sampled_from(Kinematics)),
        tensioning=draw(st.sampled_from(Tensioning)),
    )
    return drive, tension, speed


def capacity_at(drive: BeltDrive, held: float, speed: float, torque: float) -> float:
    """Torque capacity in the direction in which a torque of that sign carries the power."""
    return float(torque_capacity(drive, held, speed, torque * speed < 0.0))


def slip_at(drive: BeltDrive, torque: float, held: float, speed: float) -> float:
    """Slip; minus infinity where a load that drives would have to push the belt back."""
    try:
        return float(solve_equilibrium(drive, torque, held, speed).slip)
    except DriveError as error:
        if "slip beyond 100 %" in str(error) and torque * speed < 0.0:
            return -math.inf
        raise
