"""Pulley arcs to time: confirmed ones with known answers, and a broad random mixture."""

import csv
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchmarks.mechanics.boundary_value import ScaledArc

Floats = NDArray[np.float64]

ROOT = Path(__file__).resolve().parents[2]
SHARED = tuple(
    ROOT.parent / "shared" / "reference" / name
    for name in ("epp_single_pulley.csv", "epp_restick.csv")
)
OWN = (ROOT / "tests" / "data" / "epp_reference.csv",)
GRADIENTS = ("inlet_strain_gradient", "inlet_gradient")
RESTICKS = ("restick_angle_rad", "restick_from_rad")


class ArcCases(NamedTuple):
    """Arcs with known answers, (k,) each."""

    arguments: Floats  # (10, k), as `solve_arc` takes them
    gradient: Floats  # u'(0) [-]
    resticks: NDArray[np.bool_]  # three zones, which Eqs. 47-54 do not know
    source: str

    def scaled(self, index: int) -> tuple[ScaledArc, float]:
        """Return one arc as the boundary value problem takes it, and its h(0) = K u'(0) / w_in."""
        sigma, radius, wrap, mu, kf, ea, m, v, t_in, t_out = self.arguments[:, index]
        net = ea - m * v**2
        inlet = t_in - m * v**2
        ratio = 1.0 + net / ea * (t_out - t_in) / inlet
        arc = ScaledArc(sigma, mu, radius * np.sqrt(kf / net), wrap, ratio)
        return arc, self.gradient[index] * net / inlet


def confirmed_arcs() -> ArcCases:
    """Read the shared reference where it is present, else the project's own cases."""
    files = SHARED if all(path.is_file() for path in SHARED) else OWN
    arguments, gradient, resticks = [], [], []
    for path in files:
        with path.open(encoding="utf-8", newline="") as file:
            for row in csv.DictReader(file):
                role, *numbers = list(row.values())[:10]
                arguments.append([1.0 if role == "driven" else -1.0, *map(float, numbers)])
                gradient.append(float(next(row[name] for name in GRADIENTS if name in row)))
                restick = next((row[name] for name in RESTICKS if name in row), "nan")
                resticks.append(restick != "nan")
    source = " and ".join(f"`{path.name}`" for path in files)
    return ArcCases(np.array(arguments).T, np.array(gradient), np.array(resticks), source)


def mixed_arcs(count: int, seed: int = 2011) -> Floats:
    """Draw arguments (10, count) for `solve_arc`: all regimes, up to 0.01 % below the capacity."""
    random = np.random.default_rng(seed)

    def spread(low: float, high: float) -> Floats:
        return np.exp(random.uniform(np.log(low), np.log(high), count))

    sigma = random.choice([1.0, -1.0], count)
    axial = spread(3e3, 3e6)
    tension = axial * spread(1e-4, 8e-2)
    speed = spread(1.0, 40.0)
    mass = tension * random.uniform(0.0, 0.8, count) / speed**2
    net = axial - mass * speed**2
    radius, mu = spread(0.02, 0.6), random.uniform(0.2, 1.4, count)
    wrap = random.uniform(1.0, 5.5, count)
    stiffness = (mu / (radius * spread(0.03, 3.0))) ** 2 * net
    load = np.where(random.random(count) < 0.5, spread(1e-3, 0.9999), 1.0 - spread(1e-4, 0.5))
    inlet = tension - mass * speed**2
    outlet = tension + inlet * np.expm1(sigma * load * mu * wrap) * axial / net
    return np.stack(
        [sigma, radius, wrap, mu, stiffness, axial, mass, speed, tension, outlet],
    )
