"""How good the data were, as tables: counts and times, the fit of each sensor, gaps."""

import math
from collections.abc import Iterator

from belt_ros.estimation.estimate import Consistency
from belt_ros.report.headline import moment
from belt_ros.report.markup import Html, join, section, table, tag
from belt_ros.report.rounding import SPACE, duration, plain
from belt_ros.report.sensor_fit import SensorFit
from belt_ros.report.study import Study

_FITS = {
    "unknown": "too little to tell",
    "consistent": "fit",
    "overconfident": "fit worse than stated: do not trust the errors",
    "underconfident": "fit better than stated",
}


def quality_section(study: Study) -> Html:
    """Return the part of the page about data quality."""
    counts = table("Data quality", ("", "value"), _counts(study))
    return section("quality", "Data quality", counts, _sensors(study), _gaps(study))


def _counts(study: Study) -> Iterator[tuple[object, object]]:
    summary, quality = study.summary, study.quality
    observed = summary.number("duration") - summary.number("unobserved")
    messages = summary.count("messages")
    yield "topic", summary.text("topic")
    yield "messages", f"{messages:,}"
    yield "messages used", f"{summary.count('accepted'):,}"
    if observed > 0.0:
        yield "messages a second, gaps left out", f"{plain(messages / observed)} Hz"
    yield "estimates", f"{quality.rows:,}"
    if quality.period:
        yield "median time between estimates", f"{plain(1e3 * quality.period)} ms"
    for reason, number in summary.group("rejected").numbers().items():
        if number:
            yield f"rejected: {reason.replace('_', ' ')}", f"{round(number):,}"
    if not any(summary.group("rejected").numbers().values()):
        yield "rejected", "none"
    limit = summary.group("config").group("limits").number("greatest_gap")
    yield f"gaps longer than {plain(limit, 3)} s", f"{quality.gaps:,}"
    yield "time without data", duration(summary.number("unobserved"))
    yield "time jumped back", f"{summary.count('resets'):,}"
    for kind, seconds in quality.fit_seconds.items():
        if seconds > 0.0:
            yield f"sensors and model: {_FITS[kind]}", duration(seconds)
    yield "worst misfit (innovation squared; 1 is right)", plain(quality.worst_fit, 3)


def _sensors(study: Study) -> Html:
    if not study.sensor_fits:
        return Html("")
    text = (
        "Squared errors of each sensor over those that its stated noise lets expect, in some ten "
        "seconds: 1 is right. Overconfident: errors are larger than stated; underconfident: "
        "smaller, which does no harm. Noise shows in the sensor that is noisy, but a wrong scale "
        "of a torque shows in the speeds."
    )
    headings = ("sensor", "most of the time", "overconfident", "median", "greatest")
    found = table("Fit by sensor", headings, map(_sensor, study.sensor_fits))
    return join((tag("h3", "Fit by sensor"), tag("p", text, class_="hint"), found))


def _sensor(fit: SensorFit) -> tuple[object, ...]:
    if math.isnan(fit.median):
        return fit.sensor, _FITS["unknown"], "", "", ""
    verdict = fit.verdict.name.lower()
    shown = tag("strong", verdict) if fit.verdict is Consistency.OVERCONFIDENT else verdict
    greatest = f"{plain(fit.greatest, 3)} at {moment(fit.time)}"
    return fit.sensor, shown, _share(fit.worse), plain(fit.median, 3), greatest


def _share(share: float) -> str:
    if share == 0.0:
        return "never"
    return f"{plain(100.0 * share, 2)}{SPACE}% of the time"


def _gaps(study: Study) -> Html:
    if not study.quality.longest:
        return Html("")
    rows = ((moment(gap.start), duration(gap.length)) for gap in study.quality.longest)
    return table("Longest gaps", ("from", "length"), rows)
