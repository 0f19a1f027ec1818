"""Writes a report."""

from pathlib import Path

from belt_ros.appearing import appearing
from belt_ros.report.page import render
from belt_ros.report.result_directory import ReportError, open_results
from belt_ros.report.study import study


def write_report(results: Path, out: Path, baseline: Path | None = None) -> None:
    """Write the results of a replay as one HTML page that needs nothing but itself.

    The page appears complete or not at all; one that was there is replaced.

    Parameters
    ----------
    results : Path
        A result directory of `belt_ros.replay.replay`.
    out : Path
        The page.
    baseline : Path, optional
        Results of the same drive when it was commissioned.

    Raises
    ------
    ReportError
        If `results` or `baseline` is no result directory or is damaged, or `out` cannot be
        written.
    """
    found = open_results(results)
    page = render(study(found, None if baseline is None else open_results(baseline)))
    _replace(out, page)


def _replace(out: Path, page: str) -> None:
    if out.is_dir():
        raise ReportError(f"{out} is a directory; name a file for the report")
    try:
        with appearing(out) as part:
            part.write_text(page, encoding="utf-8")
    except OSError as error:
        raise ReportError(f"cannot write {out}: {error.strerror or error}") from error
