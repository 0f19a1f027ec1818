"""What was measured, as Markdown."""

from benchmarks.mechanics.arc_cases import ArcCases
from benchmarks.mechanics.arcs import ArcSpeed, Comparison, Throughput
from benchmarks.mechanics.drive_run import DriveRun, misfit

EXUDYN = "Exudyn"


def arcs_section(
    cases: ArcCases, speed: ArcSpeed, comparisons: list[Comparison], rates: Throughput
) -> list[str]:
    """Return the section on arcs."""
    bounded = int((~cases.resticks).sum())
    shares = ", ".join(f"{name} {share:.1%}" for name, share in rates.shares.items())
    return [
        "## One arc against `scipy.integrate.solve_bvp`",
        "",
        f"{bounded} arcs of {cases.source}, of one and two zones, as the boundary value problem of",
        "Eqs. 47-54. For `solve_bvp` it is scaled so that every u'(0) can be resolved, starts with",
        "friction 5 % and the transition 2 % off, and gets for each arc and accuracy the tolerance",
        "and mesh that reach it soonest. Accuracy: relative error in u'(0); the last row is about",
        "what the closed form reaches. Ratio: processor time of `solve_bvp` over that of the",
        "vectorised `solve_arc`, arc by arc, both on one core.",
        "",
        "| accuracy asked | arcs that reach it | worst error of solve_bvp | of solve_arc "
        "| ratio of total times | median ratio | least ratio |",
        "| ---: | ---: | ---: | ---: | ---: | ---: | ---: |",
        *(
            f"| {c.accuracy:.0e} | {c.solved} | {c.error:.1e} | {speed.error:.1e} | "
            f"{c.ratio:,.0f} | {c.median_ratio:,.0f} | {c.least_ratio:,.0f} |"
            for c in comparisons
        ),
        "",
        "Mean arc, for scale: `solve_bvp` "
        + ", ".join(f"{c.milliseconds:.1f} ms at {c.accuracy:.0e}" for c in comparisons)
        + f"; all {cases.gradient.size} cases, re-stick included, by the vectorised `solve_arc` "
        f"{speed.vectorised:.0f} ns; by the compiled `arc_state` called from Python arc by arc "
        f"{speed.compiled:.0f} ns; "
        f"by `solve_arc` with one arc a call {1e-3 * speed.single_call:.0f} us.",
        "",
        "## Many at once, one core",
        "",
        "| what | a second | target |",
        "| --- | ---: | ---: |",
        f"| arcs, `solve_arc` | {rates.arcs:,.0f} | 1,000,000 |",
        f"| steady states, `solve_equilibrium` | {rates.equilibria:,.0f} | |",
        "",
        f"Arcs: {shares}; loads from 0.1 % to 99.99 % of the traction limit. Steady states: up to "
        "99.9 % of the capacity, both senses of torque and rotation. Medians of repeats.",
    ]


def drive_table(runs: list[DriveRun]) -> list[str]:
    """Return runs as a table, each own run beside Exudyn's of the same friction stiffness."""
    lines = [
        "| solver | elements | kf [N/m2] | T_L, T_H [N] | driven [rad/s] | friction: rms error "
        "driven | driver | both | processor time [s] | wall [s] | times faster than Exudyn |",
        "| --- " + "| ---: " * 10 + "|",
    ]
    for run in runs:
        error = misfit(run)
        lines.append(
            f"| {run.solver} | {run.elements} | {run.friction_stiffness:.2g} | "
            f"{run.slack_tension:.1f}, {run.tight_tension:.1f} | {run.driven_speed:.3f} | "
            f"{error.driven:.1%} | {error.driver:.1%} | {error.both:.1%} | "
            f"{run.seconds.processor:.2f} | {run.seconds.wall:.2f} | {_ratios(run, runs)} |"
        )
    return lines


def _ratios(run: DriveRun, runs: list[DriveRun]) -> str:
    """Return the processor times of Exudyn's runs over that of an own one."""
    if run.solver.startswith(EXUDYN):
        return ""
    return ", ".join(
        f"{peer.seconds.processor / run.seconds.processor:.0f}"
        for peer in runs
        if peer.solver.startswith(EXUDYN) and peer.friction_stiffness == run.friction_stiffness
    )
