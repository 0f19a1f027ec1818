"""What `draw_all` writes, and that the page in docs says the same."""

import json
import re
import subprocess
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest

from belt_ros.figures import NAMES, FigureError, draw_all, simulation, tables

DOCS = Path(__file__).resolve().parents[2] / "docs"
PAGE = (DOCS / "figures.md").read_text(encoding="utf-8")
SIMULATED = ("14", "15", "16", "table2", "inertia", "kf_min", "torque", "measured")
MEASURED = simulation.from_document(json.loads((DOCS / "figures/finite_element.json").read_text()))

TABLES: dict[str, Callable[[], str]] = {
    "table_1.md": tables.table_1,
    "table_2.md": partial(tables.table_2, MEASURED),
    "driven_speed.md": partial(tables.driven_speeds, MEASURED),
    "figure_10.md": tables.limits,
    "inertia.md": partial(tables.inertia, MEASURED),
    "kf_min.md": partial(tables.softer_contact, MEASURED),
    "kf_min_against_load.md": tables.least_stiffness_against_load,
    "torque_balance.md": partial(tables.torque_balance, MEASURED),
}


def is_png(path: Path) -> bool:
    return path.read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"


@pytest.fixture(scope="module")
def quick(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Everything that needs no simulation."""
    out = tmp_path_factory.mktemp("figures") / "made"
    return draw_all(out, [name for name in NAMES if name not in SIMULATED])


def test_every_figure_is_made(quick: list[Path]) -> None:
    assert {path.name for path in quick} >= {f"figure_{n:02d}.png" for n in range(5, 14)}
    for path in quick:
        assert path.stat().st_size > 100
        if path.suffix == ".png":
            assert is_png(path)
            assert 10_000 < path.stat().st_size < 120_000


def test_same_picture_is_drawn_twice(quick: list[Path], tmp_path: Path) -> None:
    (again, _) = draw_all(tmp_path, ["10"])
    (first,) = (path for path in quick if path.name == again.name)
    assert again.read_bytes() == first.read_bytes()


@pytest.mark.slow
def test_what_is_simulated_is_drawn_and_tells_its_progress(tmp_path: Path) -> None:
    told: list[tuple[float, float]] = []
    written = draw_all(
        tmp_path, ["15", "kf_min", "15"], lambda done, total: told.append((done, total))
    )
    assert [path.name for path in written] == [
        "figure_15.png",
        "kf_min.png",
        "kf_min.md",
        "kf_min_against_load.md",
    ]
    assert all(is_png(path) for path in written[:2])
    done = [one for one, _ in told]
    assert done == sorted(done)
    assert told[-1] == (24.0, 24.0)


def test_name_of_nothing_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FigureError, match=r"no figure '17'; there are 5, 6, .*table2"):
        draw_all(tmp_path / "none", ["17"])
    assert not (tmp_path / "none").exists()


def test_drawing_leaves_the_users_plotting_alone() -> None:
    code = (
        "import sys, tempfile, pathlib, matplotlib as mpl\n"
        "before = mpl.rcParams.copy()\n"
        "from belt_ros.figures import draw_all\n"
        "draw_all(pathlib.Path(tempfile.mkdtemp()), ['11'])\n"
        "assert 'matplotlib.pyplot' not in sys.modules\n"
        "assert mpl.rcParams.copy() == before\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True, cwd=DOCS.parent)


# --- The page --------------------------------------------------------------------------------


@pytest.mark.parametrize("name", TABLES)
def test_tables_in_docs_are_the_generated_ones(name: str) -> None:
    inside = PAGE.split(f"<!-- {name} -->\n")[1].split(f"<!-- /{name} -->")[0]
    table = TABLES[name]()
    assert inside == table
    assert (DOCS / "figures" / name).read_text(encoding="utf-8") == table


def test_page_shows_every_picture_and_table_there_is() -> None:
    shown = set(re.findall(r"\(figures/([a-z_0-9]+\.png)\)", PAGE))
    assert shown == {path.name for path in (DOCS / "figures").glob("*.png")}
    assert shown >= {f"figure_{n:02d}.png" for n in range(5, 17)}
    assert set(re.findall(r"<!-- ([a-z_0-9]+\.md) -->", PAGE)) == set(TABLES)
    assert {path.name for path in (DOCS / "figures").glob("*.md")} == set(TABLES)


def test_pictures_in_docs_are_small() -> None:
    for path in (DOCS / "figures").glob("*.png"):
        assert is_png(path)
        assert 10_000 < path.stat().st_size < 120_000, path.name
