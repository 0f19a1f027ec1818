"""Draw what is asked for into a directory: pictures, tables and the measured numbers."""

import json
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import NamedTuple

from matplotlib.figure import Figure

from belt_ros.figures import (
    angles,
    evidence,
    finite_element,
    friction_and_tension,
    simulation,
    stability,
    stiffness,
    style,
    tables,
)
from belt_ros.figures.simulation import CASES, PAPERS, SOFT_CONTACTS, Simulated

Progress = Callable[[float, float], None]
Made = Figure | str
_Runs = dict[str, Simulated]


class FigureError(ValueError):
    """A figure or table that there is not."""


class _Item(NamedTuple):
    """A file, how it is made, and the simulations that it needs."""

    file: str
    make: Callable[[_Runs], Made]
    cases: tuple[str, ...] = ()


def _alone(file: str, make: Callable[[], Made]) -> _Item:
    """Return an item that needs no simulation."""
    return _Item(file, lambda _: make())


def _compared(number: int, case: str) -> _Item:
    return _Item(f"figure_{number}.png", lambda runs: finite_element.draw(runs[case]), (case,))


def _table(
    file: str, make: Callable[[dict[str, simulation.Measured]], str], cases: tuple[str, ...]
) -> _Item:
    def made(runs: _Runs) -> str:
        measured = {name: runs[name].measured for name in cases}
        # as on file, so that a table drawn from the file is the same to its last digit
        return make(simulation.from_document(simulation.to_document(measured)))

    return _Item(file, made, cases)


def _document(measured: dict[str, simulation.Measured]) -> str:
    return json.dumps(simulation.to_document(measured), indent=2) + "\n"


_SOFT = "below kf_min"
_ITEMS: dict[str, tuple[_Item, ...]] = {
    "5": (_alone("figure_05.png", stability.draw),),
    "6": (_alone("figure_06.png", partial(friction_and_tension.draw_friction, "Coulomb")),),
    "7": (_alone("figure_07.png", partial(friction_and_tension.draw_friction, "EPP")),),
    "8": (_alone("figure_08.png", partial(friction_and_tension.draw_tension, "Coulomb")),),
    "9": (_alone("figure_09.png", partial(friction_and_tension.draw_tension, "EPP")),),
    "10": (_alone("figure_10.png", angles.draw), _alone("figure_10.md", tables.limits)),
    "11": (_alone("figure_11.png", stiffness.draw_initial_tension),),
    "12": (_alone("figure_12.png", stiffness.draw_inlet_gradient),),
    "13": (_alone("figure_13.png", stiffness.draw_inlet_gradient_detail),),
    "14": (_compared(14, PAPERS[0]),),
    "15": (_compared(15, PAPERS[1]),),
    "16": (_compared(16, PAPERS[2]),),
    "table1": (_alone("table_1.md", tables.table_1),),
    "table2": (
        _table("table_2.md", tables.table_2, PAPERS),
        _table("driven_speed.md", tables.driven_speeds, PAPERS + SOFT_CONTACTS),
    ),
    "inertia": (
        _Item(
            "inertia.png",
            lambda runs: evidence.draw_inertia(*(runs[name] for name in PAPERS)),
            PAPERS,
        ),
        _table("inertia.md", tables.inertia, PAPERS),
    ),
    "kf_min": (
        _Item("kf_min.png", lambda runs: evidence.draw_softer_contact(runs[_SOFT]), (_SOFT,)),
        _table("kf_min.md", tables.softer_contact, (_SOFT,)),
        _alone("kf_min_against_load.md", tables.least_stiffness_against_load),
    ),
    "torque": (_table("torque_balance.md", tables.torque_balance, PAPERS),),
    "measured": (_table("finite_element.json", _document, tuple(CASES)),),
}
NAMES = tuple(_ITEMS)
"""What `draw_all` can be asked for: figures by number, tables, evidence."""

_WORK_PER_RUN = 10.0  # a simulation takes about as long as so many pictures


def draw_all(
    out: Path, only: Sequence[str] | None = None, progress: Progress | None = None
) -> list[Path]:
    """Draw the paper's figures and tables, and the evidence where it is inconsistent.

    Parameters
    ----------
    out : Path
        Directory; made if it is not there. Files of the same names are replaced.
    only : sequence of str, optional
        Some of `NAMES`; everything if not given.
    progress : callable, optional
        Called with (done, total) work, in pictures.

    Returns
    -------
    list of Path
        The files written.

    Raises
    ------
    FigureError
        For a name that is not in `NAMES`.
    """
    items = [item for name in _checked(only) for item in _ITEMS[name]]
    needed = {case for item in items for case in item.cases}
    total = len(items) + _WORK_PER_RUN * len(needed)
    tell = progress or (lambda _done, _total: None)
    out.mkdir(parents=True, exist_ok=True)
    runs: _Runs = {}
    for name in (case for case in CASES if case in needed):
        before = _WORK_PER_RUN * len(runs)

        def forward(done: float, whole: float, before: float = before) -> None:
            tell(before + _WORK_PER_RUN * done / whole, total)

        runs[name] = simulation.run_case(CASES[name], forward)
    written = []
    with style.sheet():
        for count, item in enumerate(items, start=1):
            written.append(_write(out / item.file, item.make(runs)))
            tell(_WORK_PER_RUN * len(runs) + count, total)
    return written


def _checked(only: Sequence[str] | None) -> Sequence[str]:
    if not only:
        return NAMES
    for name in only:
        if name not in _ITEMS:
            raise FigureError(f"there is no figure {name!r}; there are {', '.join(NAMES)}")
    return tuple(dict.fromkeys(only))


def _write(path: Path, made: Made) -> Path:
    if isinstance(made, Figure):
        style.save(made, path)
    else:
        path.write_text(made, encoding="utf-8")
    return path
