"""The page of results, docs/estimator_results.md: prose by hand, tables copied by command."""

from pathlib import Path

DOCS = Path(__file__).resolve().parents[2] / "docs"
PAGE = DOCS / "estimator_results.md"
IMAGES = DOCS / "images"


def renewed(document: str, name: str, text: str) -> str:
    """Return `document` with what stands between `<!-- name -->` and `<!-- /name -->` renewed.

    Raises
    ------
    ValueError
        If these marks are not there, once each.
    """
    start, end = f"<!-- {name} -->", f"<!-- /{name} -->"
    if document.count(start) != 1 or document.count(end) != 1:
        raise ValueError(f"the page must have {start} and {end} once each")
    before, _, rest = document.partition(start)
    _, _, after = rest.partition(end)
    return f"{before}{start}\n{text.strip()}\n{end}{after}"


def renew(page: Path, name: str, text: str) -> None:
    """Renew one part of a page."""
    page.write_text(renewed(page.read_text(encoding="utf-8"), name, text), encoding="utf-8")
