"""The figures of replaying as a page: what was to be reached, and where the time goes."""

from collections.abc import Sequence

from benchmarks.estimation.report import made_with, table, verdicts
from benchmarks.replay import measure
from benchmarks.replay.measure import Figure

FASTEST = 10_000.0  # samples a second
TWO_CORES = 1.8  # times as fast as one
FLAT = 1.1  # times the memory of a bag ten times shorter
_MICROSECONDS = 1e6
_LIBRARIES = ("numpy", "numba", "filterpy", "rosbags", "pyarrow")
_Cases = dict[str, dict[str, float]]


def page(rows: Sequence[Figure]) -> str:
    """Return the page."""
    cases: _Cases = {}
    for row in rows:
        cases.setdefault(row.case, {})[row.what] = row.value
    parts = [
        "# Replaying bags",
        "",
        "The paper's drive, joint states in a compressed MCAP bag, measured as the median of some "
        "turns of one process (processor time), as wall time of `belt fleet`, and as peak memory "
        "of one process. At 1000 Hz the estimator pools what comes within 10 ms.",
        "",
        *verdicts([*_speed_verdicts(cases), *_other_verdicts(cases)]),
        "",
        *_where_time_goes(cases),
        "",
        *_others(cases),
        "",
        made_with("", rows, "replay", _LIBRARIES),
    ]
    return "\n".join(parts) + "\n"


def _speeds(cases: _Cases) -> _Cases:
    named = {f"{rate:g} Hz": measure.speed_case(rate) for rate in measure.RATES}
    return {name: cases[case] for name, case in named.items() if case in cases}


def _speed_verdicts(cases: _Cases) -> list[tuple[str, str, bool]]:
    lines = []
    for name, took in _speeds(cases).items():
        for what in (measure.PLAIN, measure.SMOOTHED):
            rate = _MICROSECONDS / took[what]
            target = f"{name}, {what}: {FASTEST:.0f} samples/s in one core"
            lines.append((target, f"{rate:.0f}", rate >= FASTEST))
    return lines


def _other_verdicts(cases: _Cases) -> list[tuple[str, str, bool]]:
    lines = []
    if measure.CORES in cases:
        took = cases[measure.CORES]
        ratio = took[measure.ONE] / took[measure.TWO]
        target = f"{measure.BAGS} bags on two cores: {TWO_CORES} times as fast as on one"
        lines.append((target, f"{ratio:.2f}", ratio >= TWO_CORES))
    if measure.MEMORY in cases:
        took = cases[measure.MEMORY]
        ratio = took[measure.LONG] / took[measure.SHORT]
        target = f"a bag {measure.LONGER} times as long: at most {FLAT} times the memory"
        lines.append((target, f"{ratio:.2f}", ratio <= FLAT))
    return lines


def _where_time_goes(cases: _Cases) -> list[str]:
    speeds = _speeds(cases)
    whats = (measure.READING, *measure.PARTS, measure.PLAIN, measure.SMOOTHED)
    head = ["part"]
    for name in speeds:
        head += [f"{name} [us/sample]", "of all", "times the bag alone"]
    lines = []
    for what in whats:
        line = [what]
        for took in speeds.values():
            share = took[what] / took[measure.SMOOTHED]
            ratio = took[what] / took[measure.READING]
            line += [f"{took[what]:.1f}", f"{share:.0%}", f"{ratio:.1f}"]
        lines.append(line)
    return table(head, lines) if speeds else []


def _others(cases: _Cases) -> list[str]:
    found = [(case, took) for case, took in cases.items() if not case.endswith("[us/sample]")]
    lines = [[case, what, f"{value:.1f}"] for case, took in found for what, value in took.items()]
    return table(["case", "what", "measured"], lines, texts=2) if lines else []
