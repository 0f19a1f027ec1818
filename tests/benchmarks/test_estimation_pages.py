"""What is written of campaigns: verdicts, pictures, the page."""

import pytest

from benchmarks.estimation import page, store
from benchmarks.estimation.campaigns import CAMPAIGNS
from benchmarks.estimation.cells import all_cells
from benchmarks.estimation.cost import ALIVE, FILTER, FORM, SETTLED, STEP, Cost
from benchmarks.estimation.cost_report import cost_sections
from benchmarks.estimation.grid_report import grid_files, grid_sections
from benchmarks.estimation.judged import QUANTITIES, Row

COUNT = len(QUANTITIES)


def rows_of_right_intervals(outside: float = 0.05) -> list[Row]:
    """Twenty runs a cell, of which a share lies outside."""
    rows = []
    for cell in all_cells():
        for seed in range(20):
            error = 3.0 if seed < round(20 * outside) else 0.5
            values = (error,) * COUNT
            rows.append(
                Row("own", cell.name, seed, 1.0, 10.0, "code", values, (1.0,) * COUNT, nees=1.0)
            )
    return rows


def test_the_grid_says_what_is_reached_and_what_is_not() -> None:
    good = "\n".join(grid_sections(rows_of_right_intervals(0.05)))
    assert "100% of the cells, least 95.0% | yes |" in good
    assert "**no**" not in good
    bad = "\n".join(grid_sections(rows_of_right_intervals(0.15)))
    assert "0% of the cells, least 85.0% | **no** |" in bad


def test_the_grid_has_a_line_a_cell_and_two_pictures() -> None:
    files = grid_files(rows_of_right_intervals())
    text = files["estimation_grid_cells.csv"]
    assert isinstance(text, str)
    assert len(text.splitlines()) == 1 + len(all_cells())
    assert {name for name in files if name.endswith(".png")} == {
        "estimation_coverage.png",
        "estimation_nees.png",
    }


def test_pictures_of_campaigns_are_shown_on_the_page() -> None:
    text = page.PAGE.read_text(encoding="utf-8")
    pictures = sorted(path.name for path in page.IMAGES.glob("estimation_*.png"))
    assert len(pictures) >= 3
    assert [name for name in pictures if f"](images/{name})" not in text] == []


def cost(method: str, part: str, own: float, seed: int = 0) -> Cost:
    return Cost(method, f"paper, {part}", seed, "code", own, own, 100.0, 1)


def test_cost_is_judged_by_the_ratio_of_what_was_timed_together() -> None:
    rows = [
        cost(STEP, SETTLED, 90.0),
        cost(STEP, ALIVE, 600.0),
        cost(FILTER, SETTLED, 110.0),
        cost(FILTER, SETTLED, 90.0, 1),
        cost(FILTER, SETTLED, 95.0, 2),
    ]
    text = cost_sections(rows)
    assert sum("0.90 on the costliest drive | yes" in line for line in text) == 2  # median, mean
    assert sum("6.00 on the costliest drive | **no**" in line for line in text) == 1
    assert sum("0.95 on the costliest drive | yes" in line for line in text) == 1


def test_costs_survive_the_file(tmp_path) -> None:
    rows = [cost(STEP, SETTLED, 90.5), cost(FILTER, ALIVE, 1234.0)]
    store.append(tmp_path / "cost.csv", rows, FORM)
    assert store.load(tmp_path / "cost.csv", FORM) == rows


def test_a_part_of_a_page_is_renewed_and_the_rest_stays() -> None:
    document = "before\n<!-- a.md -->\nold\n<!-- /a.md -->\nafter\n"
    new = page.renewed(document, "a.md", "new\n")
    assert new == "before\n<!-- a.md -->\nnew\n<!-- /a.md -->\nafter\n"
    assert page.renewed(new, "a.md", "new") == new
    with pytest.raises(ValueError, match="once each"):
        page.renewed(document, "b.md", "new")


def test_the_page_says_what_the_results_say() -> None:
    text = page.PAGE.read_text(encoding="utf-8")
    for each in CAMPAIGNS:
        name = f"estimation_{each.name}.md"
        results = store.RESULTS / name
        if results.is_file():
            body = results.read_text(encoding="utf-8").split("\n", 2)[2].strip()
            part = text.split(f"<!-- {name} -->")[1].split(f"<!-- /{name} -->")[0].strip()
            assert part.endswith(body)


def test_every_picture_of_the_page_is_there() -> None:
    text = page.PAGE.read_text(encoding="utf-8")
    shown = [part.split(")")[0] for part in text.split("](images/")[1:]]
    assert all((page.IMAGES / name).is_file() for name in shown)


def test_every_campaign_has_its_part_of_the_page() -> None:
    text = page.PAGE.read_text(encoding="utf-8")
    for each in CAMPAIGNS:
        page.renewed(text, f"estimation_{each.name}.md", "")
