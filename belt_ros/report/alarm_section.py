"""The alarms of a run as tables: what they amount to, and each of them."""

from collections.abc import Iterator

from belt_ros.report.alarm_totals import AlarmTotal
from belt_ros.report.headline import moment
from belt_ros.report.labels import condition_name, severity_name
from belt_ros.report.markup import Html, join, section, table, tag
from belt_ros.report.rounding import duration
from belt_ros.report.study import Study

_MOST_ALARMS = 200


def alarm_section(study: Study) -> Html:
    """Return the part of the page about alarms."""
    if not study.totals:
        return section("alarms", "Alarms", tag("p", "There was none."))
    return section("alarms", "Alarms", _totals(study), *_listed(study))


def _totals(study: Study) -> Html:
    headings = ("condition", "worst severity", "times raised", "in all", "longest")
    found = table("Alarms by condition", headings, map(_row, study.totals))
    times = study.summary.group("time_in_severity", optional=True).numbers()
    if not times:
        return found
    told = ", ".join(f"{name.replace('_', ' ')} {duration(time)}" for name, time in times.items())
    return join((found, tag("p", f"Time in each severity: {told}.", class_="hint")))


def _row(total: AlarmTotal) -> tuple[object, ...]:
    times = f"{total.times:,}"
    return total.condition, total.severity, times, duration(total.seconds), duration(total.longest)


def _listed(study: Study) -> Iterator[Html]:
    """Yield what the result bag tells of each alarm."""
    history = study.alarms
    if not history.raised:
        return
    rows = (
        (
            condition_name(interval.condition),
            severity_name(interval.severity),
            moment(interval.start),
            duration(interval.end - interval.start),
            interval.message,
        )
        for interval in history.raised[:_MOST_ALARMS]
    )
    headings = ("condition", "severity", "from", "for", "message")
    yield table("Alarms in the order of time", headings, rows)
    rest = len(history.raised) - _MOST_ALARMS
    if rest > 0:
        yield tag("p", f"{rest:,} more are in the result bag.", class_="hint")
    if not history.complete:
        yield tag("p", "Only the first alarms are in this list.")
