"""The example drive in the finite element simulator, and what is measured of it.

The closed form enters only at the end, fed with the tensions that a run arrived at, as in the
paper's section 6.
"""

import math
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from belt_ros.figures import example, paper
from belt_ros.mechanics import Role
from belt_ros.mechanics.finite_element import ArcDistribution, FiniteElementRun, History, simulate
from belt_ros.mechanics.finite_element_mesh import Discretisation

_Floats = NDArray[np.float64]
_ELEMENTS = 100  # on half a pulley, the paper's mesh
_DURATION, _RISE, _TAIL = 0.6, 0.25, 0.1  # [s]
_EDGE = 2  # bins at either end, in which the belt is met and left within one element
_SLIDING = 0.97  # of the Coulomb limit, above which a bin may hold the transition
LIFTS = np.linspace(0.0, 20.0, 81)  # m v^2 [N] tried on the friction profiles


class Case(NamedTuple):
    """A run."""

    friction_stiffness: float  # kf [N/m2]
    contact_stiffness: float | None = None  # of a node [N/m]; None: that of an element, EA/h


CASES = {
    "minimum": Case(2.8e7),
    "medium": Case(2e8),
    "stiff": Case(8.1e9),
    "soft contact, minimum": Case(2.8e7, paper.CONTACT_STIFFNESS),
    "soft contact, medium": Case(2e8, paper.CONTACT_STIFFNESS),
    "soft contact, stiff": Case(8.1e9, paper.CONTACT_STIFFNESS),
    "below kf_min": Case(1.4e7),
}
PAPERS = (
    "minimum",
    "medium",
    "stiff",
)  # the three kf of Table 2
SOFT_CONTACTS = tuple(f"soft contact, {name}" for name in PAPERS)


class Measured(NamedTuple):
    """Numbers of a run, means over its last 0.1 s."""

    friction_stiffness: float  # kf [N/m2]
    slack_tension: float  # T_L [N]
    tight_tension: float  # T_H [N]
    driven_speed: float  # omega1 [rad/s]
    driven_torque: float  # that the belt puts on the driven pulley [N m]
    driver_torque: float  # that the driver puts into the belt [N m]
    driven_transition: float  # where friction meets the Coulomb limit [rad]; the wrap if nowhere
    driver_transition: float
    driven_utilisation: float  # greatest share of the Coulomb limit on the driven arc [-]
    friction_rms: float  # deviation from the closed form with inertia [N/m], inner bins, both arcs
    friction_rms_without_inertia: float  # [N/m]
    friction_peak: float  # [N/m]
    best_inertia_force: float  # m v^2 [N] at which the closed form fits best
    closed_form_speed: float  # omega1 of equilibrium at these tensions, with inertia [rad/s]
    closed_form_transitions: tuple[float, float]  # driven, driver, with inertia [rad]


class Simulated(NamedTuple):
    """A run and its numbers."""

    run: FiniteElementRun
    measured: Measured


def run_case(case: Case, progress: Callable[[float, float], None] | None = None) -> Simulated:
    """Simulate 0.6 s of a case: the driver ramped up within 0.25 s, and the load with it.

    Parameters
    ----------
    case : Case
    progress : callable, optional
        Called with (done, total) simulated time [s].
    """
    share = np.linspace(0.0, 1.0, 41)
    smooth = np.append(share * share * (3.0 - 2.0 * share), 1.0)
    time = np.append(_RISE * share, _DURATION)
    run = simulate(
        example.drive(case.friction_stiffness),
        History(time, paper.DRIVER_SPEED * smooth, paper.TORQUE * smooth),
        example.INSTALLED_TENSION,
        _discretisation(case),
        average_over=_TAIL,
        progress=progress,
    )
    return Simulated(run, measure(case.friction_stiffness, run))


def _discretisation(case: Case) -> Discretisation:
    if case.contact_stiffness is None:
        return Discretisation(_ELEMENTS)
    element = math.pi * paper.RADIUS / _ELEMENTS
    ratio = case.contact_stiffness * element / paper.AXIAL_STIFFNESS
    return Discretisation(_ELEMENTS, penalty_ratio=ratio)


def arcs(run: FiniteElementRun) -> tuple[tuple[Role, ArcDistribution], ...]:
    """Return both arcs of a run with their roles, the driven one first."""
    return (Role.DRIVEN, run.driven_arc), (Role.DRIVER, run.driver_arc)


def measure(friction_stiffness: float, run: FiniteElementRun) -> Measured:
    """Return the numbers of a run that arrived at its steady state."""
    last = run.time > run.time[-1] - _TAIL
    slack, tight, speed, received, given = (
        float(np.mean(series[last]))
        for series in (
            run.slack_tension,
            run.tight_tension,
            run.driven_speed,
            run.driven_torque,
            run.driver_torque,
        )
    )
    ends = friction_stiffness, slack, tight
    misfit = [friction_misfit(run, *ends, lift) for lift in LIFTS]
    closed = (
        float(example.solve(role, *ends, paper.MASS_PER_LENGTH).transition_angle)
        for role, _ in arcs(run)
    )
    return Measured(
        friction_stiffness=friction_stiffness,
        slack_tension=slack,
        tight_tension=tight,
        driven_speed=speed,
        driven_torque=received,
        driver_torque=given,
        driven_transition=_transition(run.driven_arc),
        driver_transition=_transition(run.driver_arc),
        driven_utilisation=float(np.max(_utilisation(run.driven_arc)[_EDGE:-_EDGE])),
        friction_rms=friction_misfit(run, *ends, paper.INERTIA_FORCE),
        friction_rms_without_inertia=friction_misfit(run, *ends, 0.0),
        friction_peak=max(float(np.max(np.abs(arc.friction))) for _, arc in arcs(run)),
        best_inertia_force=float(LIFTS[np.argmin(misfit)]),
        closed_form_speed=example.driven_speed(*ends, mass=paper.MASS_PER_LENGTH),
        closed_form_transitions=(next(closed), next(closed)),
    )


def residuals(
    role: Role,
    arc: ArcDistribution,
    friction_stiffness: float,
    slack: float,
    tight: float,
    inertia_force: float,
) -> _Floats:
    """Return the friction of a run less the closed form's [N/m], for m v^2 [N]."""
    mass = inertia_force / paper.BELT_SPEED**2
    closed = example.along(arc.angle, role, friction_stiffness, slack, tight, mass)
    return np.asarray(arc.friction - closed.friction)


def friction_misfit(
    run: FiniteElementRun,
    friction_stiffness: float,
    slack: float,
    tight: float,
    inertia_force: float,
) -> float:
    """Return the rms of `residuals` over both arcs [N/m], without two bins at either end."""
    ends = friction_stiffness, slack, tight, inertia_force
    inner = [residuals(role, arc, *ends)[_EDGE:-_EDGE] for role, arc in arcs(run)]
    return float(np.sqrt(np.mean(np.concatenate(inner) ** 2)))


def _utilisation(arc: ArcDistribution) -> _Floats:
    """Friction over the Coulomb limit [-]."""
    return np.asarray(np.abs(arc.friction) / (paper.FRICTION_COEFFICIENT * arc.normal))


def _transition(arc: ArcDistribution) -> float:
    """Angle [rad] at which friction meets the limit: ln of its share, extrapolated from creep."""
    share = _utilisation(arc)
    if np.max(share[:-_EDGE]) < _SLIDING:
        return paper.WRAP_ANGLE
    creeping = np.flatnonzero(share[:-_EDGE] < _SLIDING)[-3:]
    fit = np.polynomial.Polynomial.fit(np.log(share[creeping]), arc.angle[creeping], 2)
    return min(float(fit(0.0)), paper.WRAP_ANGLE)


def to_document(measured: Mapping[str, Measured]) -> dict[str, dict[str, Any]]:
    """Return numbers of runs, by name, as what JSON holds; seven digits are what repeats."""
    return {
        name: {
            field: [_rounded(value) for value in content]
            if isinstance(content, tuple)
            else _rounded(content)
            for field, content in numbers._asdict().items()
        }
        for name, numbers in measured.items()
    }


def _rounded(value: float) -> float:
    return float(f"{value:.7g}")


def from_document(document: dict[str, dict[str, Any]]) -> dict[str, Measured]:
    """Return the numbers of runs that `to_document` wrote."""
    return {
        name: Measured(
            **{**fields, "closed_form_transitions": tuple(fields["closed_form_transitions"])}
        )
        for name, fields in document.items()
    }
