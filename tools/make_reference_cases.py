#!/usr/bin/env python3
"""Write `tests/data/epp_reference.csv`: single pulleys solved without a line of belt_ros.

Each case is solved twice from the paper's own equations (Kim, Leamy and Ferri 2011):

* by integrating from the inlet and shooting for the outlet tension, which is what is written;
* as the boundary value problem of Eqs. 47-54, with `scipy.integrate.solve_bvp`.

A case is written only where both agree to 1e-8 in u'(0) and in the transition angle. Arcs that
re-stick have a third zone, which Eqs. 47-54 do not know: there the same is asked of two
integrations with different methods.
"""

import argparse
import csv
import math
import os
import sys

import numpy as np
from reference_arcs import Arc, Case, NotConfirmedError, integrate_arc, shoot
from reference_bvp import solve_as_bvp

SEED = 20110803
RESTICK_CASES = 15
# Role, range of a = mu/b, zones, how many cases.
KINDS = (
    (1, (0.03, 1.0), 1, 5),
    (1, (0.03, 1.0), 2, 11),
    (1, (1.0, 3.0), 1, 6),
    (1, (1.0, 3.0), 2, 9),
    (-1, (0.03, 1.0), 1, 4),
    (-1, (0.03, 1.0), 2, 12),
    (-1, (1.0, 3.0), 1, 4),
    (-1, (1.0, 3.0), 2, 9),
)
CONFIRMED = 1e-8
OUTPUT = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "tests", "data")

COLUMNS = (
    "arc_role",
    "pulley_radius_m",
    "wrap_angle_rad",
    "friction_coefficient",
    "friction_stiffness_n_m2",
    "axial_stiffness_n",
    "belt_mass_kg_m",
    "belt_speed_m_s",
    "tension_in_n",
    "tension_out_n",
    "zones",
    "slide_from_rad",
    "restick_from_rad",
    "inlet_gradient",
    "limit_growth",
    "deviation",
)


def confirm(case: Case, gradient: float, arc: Arc) -> float:
    """Solve a case in the other way; return the largest relative deviation."""
    if arc.zones == 3:
        again, second = shoot(case, "LSODA")
        theta = second.slide_from
        if second.zones != 3:
            raise NotConfirmedError("different zones")
        deviations = [abs(second.restick_from / arc.restick_from - 1.0)]
    else:
        rough = Arc(arc.ratio, arc.zones, min(0.98 * arc.slide_from, case.wrap), math.nan)
        again, theta = solve_as_bvp(case, 1.05 * gradient, rough if arc.zones == 2 else arc)
        deviations = []
    deviations += [abs(again / gradient - 1.0), abs(theta / arc.slide_from - 1.0)]
    if not max(deviations) < CONFIRMED:
        raise NotConfirmedError(f"deviation {max(deviations):.1e}")
    return max(deviations)


def _rounded(value: float, digits: int = 4) -> float:
    return float(f"{value:.{digits}g}")


def draw(rng: np.random.Generator, sigma: int, growth: tuple[float, float]) -> Case:
    """Draw a case with a = mu/b in the range `growth`, all but the outlet tension."""

    def spread(low: float, high: float) -> float:
        return float(math.exp(rng.uniform(math.log(low), math.log(high))))

    axial = spread(3e3, 3e6)
    tension = axial * spread(1e-4, 8e-2)
    heavy = rng.random() < 0.5
    lift = tension * (rng.uniform(0.2, 0.8) if heavy else spread(1e-4, 1e-1))
    speed = spread(1.0, 40.0)
    radius, mu = spread(0.02, 0.6), rng.uniform(0.2, 1.4)
    b = mu / spread(*growth)
    return Case(
        sigma=sigma,
        radius=_rounded(radius),
        wrap=_rounded(rng.uniform(1.0, 5.5)),
        friction=_rounded(mu),
        stiffness=_rounded((b / radius) ** 2 * (axial - lift)),
        axial=_rounded(axial),
        mass=_rounded(lift / speed**2),
        speed=_rounded(speed),
        tension_in=_rounded(tension),
    )


def load(case: Case, ratio: float) -> Case:
    """Return the case with the outlet tension, to eight digits, that belongs to W there."""
    tension = _rounded(case.tension_at(ratio), 8)
    return Case(**{**case.__dict__, "tension_out": tension})


def row(case: Case, gradient: float, arc: Arc, deviation: float) -> list[str]:
    """Format one case as `COLUMNS`."""
    slope = case.sigma * gradient * case.inlet / case.axial_net
    given = (
        case.radius,
        case.wrap,
        case.friction,
        case.stiffness,
        case.axial,
        case.mass,
        case.speed,
        case.tension_in,
        case.tension_out,
    )
    solved = (arc.slide_from, arc.restick_from, slope, case.friction / case.b)
    return [
        "driven" if case.sigma > 0 else "driver",
        *(f"{value:.12g}" for value in given),
        str(arc.zones),
        *(f"{value:.12g}" for value in solved),
        f"{deviation:.1e}",
    ]


def plain_cases(rng: np.random.Generator) -> list[list[str]]:
    """Arcs of one and two zones: both roles, the limit outgrowing the spring or not."""
    rows: list[list[str]] = []
    dropped = 0
    for sigma, growth, zones, wanted in KINDS:
        kept = 0
        while kept < wanted:
            case = draw(rng, sigma, growth)
            share = rng.uniform(0.02, 0.97 if zones == 2 else 0.7)
            case = load(case, math.exp(sigma * share * case.friction * case.wrap))
            if not case.tension_out > case.lift:
                continue
            try:
                gradient, arc = shoot(case)
                if arc.zones != zones:
                    continue
                rows.append(row(case, gradient, arc, confirm(case, gradient, arc)))
            except NotConfirmedError as error:
                dropped += 1
                print(f"left out: {error}", file=sys.stderr)
            else:
                kept += 1
    print(f"{len(rows)} arcs of one and two zones, {dropped} left out")
    return rows


def restick_cases(rng: np.random.Generator) -> list[list[str]]:
    """Driven arcs of three zones."""
    rows: list[list[str]] = []
    while len(rows) < RESTICK_CASES:
        case = draw(rng, 1, (1.05, 4.0))
        growth = case.friction / case.b
        onset = growth**2 + growth * math.sqrt(max(growth**2 - 1.0, 0.0))
        try:
            trial = integrate_arc(case, onset * math.exp(rng.uniform(0.02, 1.5)))
            if trial.zones != 3 or trial.restick_from < 1.02 * trial.slide_from:
                continue
            case = load(case, trial.ratio)
            gradient, arc = shoot(case)
            rows.append(row(case, gradient, arc, confirm(case, gradient, arc)))
        except NotConfirmedError as error:
            print(f"left out: {error}", file=sys.stderr)
    print(f"{len(rows)} arcs that re-stick")
    return rows


def main() -> None:
    """Write the file."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--output", default=os.path.join(OUTPUT, "epp_reference.csv"))
    output = parser.parse_args().output
    rng = np.random.default_rng(SEED)
    rows = plain_cases(rng) + restick_cases(rng)
    with open(output, "w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows(rows)


if __name__ == "__main__":
    main()
