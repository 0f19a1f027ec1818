"""Measure the speed of the mechanics, and write benchmarks/results/mechanics.md."""

import argparse
import os
import platform
from datetime import datetime, timezone
from importlib.metadata import version
from pathlib import Path

from rich.progress import track

from benchmarks.mechanics import arcs, store
from benchmarks.mechanics.arc_cases import confirmed_arcs
from benchmarks.mechanics.drive_run import DriveRun, paper_drive
from benchmarks.mechanics.exudyn_drive import ExudynMissingError, load_exudyn, run_exudyn
from benchmarks.mechanics.exudyn_model import Choices
from benchmarks.mechanics.own_drive import run_own
from benchmarks.mechanics.report import arcs_section, drive_table

RESULT = Path(__file__).resolve().parents[1] / "results" / "mechanics.md"
STIFFNESSES = (2e8, 8.1e7)  # [N/m2]
OWN_ELEMENTS = (240, 480, 600)
EXUDYN_ELEMENTS = 240
EXUDYN_CHOICES = {
    "Exudyn, quick": Choices(contact_stiffness=2e8),
    "Exudyn, exact": Choices(contact_stiffness=1e9),
}
ABOUT_THE_DRIVE = """
## The paper's drive against Exudyn

The same drive and history for both: Table 1, kf as stated, spans 2 pi R, 434 N installed, centres
fixed; 120 rad/s and 45 N m rise together within 0.2 s and stay until 0.5 s. Error: friction along
each arc, averaged over the last 0.05 s in bins about an element long, against the EPP equilibrium
at the run's own tensions; rms over the arc, of its peak. One thread each. Times faster: ratio of
processor times, to the quick and to the exact Exudyn run.

Exudyn: Cable2D (ANCF) with ObjectContactFrictionCircleCable2D, two contact segments an element,
tangential spring kf times segment length; the fast build; TrapezoidalIndex2, sparse solver,
modified Newton to 1e-6, 3 discontinuous iterations to 1e-3, much as in its own belt drive; step
1e-4 s; EI 1e-3 N m2. Half or twice the step, full Newton, or more or fewer discontinuous
iterations took as long or longer. Contact stiffness 2e8 N/m2 is quick, 1e9 N/m2 exact. Its time is
that of its solvers alone.
"""


def made_with(*packages: str) -> str:
    """Return date, versions and machine class."""
    versions = ", ".join(f"{name} {version(name)}" for name in packages)
    return (
        f"{datetime.now(timezone.utc):%Y-%m-%d}, Python {platform.python_version()}, {versions}, "
        f"{os.cpu_count()} cores of {platform.machine()}"
    )


def own_runs() -> list[DriveRun]:
    """Run the own simulator, compiled beforehand."""
    run_own(STIFFNESSES[0], 60)
    return [run_own(kf, elements) for kf in STIFFNESSES for elements in OWN_ELEMENTS]


def exudyn_runs() -> list[DriveRun]:
    """Run Exudyn."""
    cases = [(kf, name) for kf in STIFFNESSES for name in EXUDYN_CHOICES]
    return [
        run_exudyn(kf, EXUDYN_ELEMENTS, EXUDYN_CHOICES[name])._replace(solver=name)
        for kf, name in track(cases, description="Exudyn")
    ]


def drive_section(*, with_exudyn: bool) -> list[str]:
    """Measure the own simulator, and Exudyn beside it if asked; else show what was measured."""
    own = own_runs()
    if with_exudyn:
        made = made_with("exudyn", "numpy", "numba")
        runs = sorted(exudyn_runs() + own, key=lambda run: -run.friction_stiffness)
        store.save(store.Session(made, runs))
    lines = ABOUT_THE_DRIVE.splitlines()
    if session := store.load():
        lines += ["", *drive_table(session.runs), "", f"Measured together: {session.made}."]
    if not with_exudyn:
        lines += ["", "The own simulator again, this time:", "", *drive_table(own)]
    return lines


def main() -> None:
    """Run and write."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.mechanics", description=__doc__)
    parser.add_argument("--exudyn", action="store_true", help="run Exudyn too, several minutes")
    options = parser.parse_args()
    if options.exudyn:
        try:
            load_exudyn()
        except ExudynMissingError as error:
            parser.exit(1, f"{error}\n")
    cases = confirmed_arcs()
    text = [
        "# Speed of the mechanics",
        "",
        *arcs_section(
            cases,
            arcs.arc_speed(cases),
            arcs.compare_arcs(cases),
            arcs.throughput(paper_drive(STIFFNESSES[0])),
        ),
        *drive_section(with_exudyn=options.exudyn),
        "",
        f"{made_with('numpy', 'scipy', 'numba')}. `python -m benchmarks.mechanics`",
    ]
    RESULT.write_text("\n".join(text) + "\n", encoding="utf-8")
    print("\n".join(text))


if __name__ == "__main__":
    main()
