"""A run against a commissioning baseline: what has changed, and whether the data can tell."""

import math
from collections.abc import Iterator
from dataclasses import dataclass

from belt_ros.estimation import Quantity
from belt_ros.estimation.estimate import log_spread
from belt_ros.replay.quantities import LOG_NORMAL, Extreme, FinalQuantity
from belt_ros.report.labels import LABELS
from belt_ros.report.load_slip import SlipAtLoad
from belt_ros.report.result_directory import SummaryValues

_SIGNIFICANT = 2.576  # standard deviations: chance alone does that in one case of a hundred
_PERHAPS = 1.960  # and that in one of twenty
_ALIKE = 1e-12


@dataclass(frozen=True)
class Compared:
    """A quantity in both runs. SI."""

    name: str
    note: str  # of which moment, or at which load
    before: Quantity
    now: Quantity

    @property
    def deviations(self) -> float:
        """Difference over its standard deviation, the errors of both being independent."""
        if self.name in LOG_NORMAL:
            change = math.log(self.now.value / self.before.value)
            error = math.hypot(log_spread(self.now), log_spread(self.before))
        else:
            change = self.now.value - self.before.value
            error = math.hypot(self.now.stddev, self.before.stddev)
        if abs(change) < _ALIKE * max(abs(self.now.value), _ALIKE):
            return 0.0
        return change / error if error > 0.0 else math.copysign(math.inf, change)

    @property
    def verdict(self) -> str:
        """Whether it has changed, in words."""
        if not math.isfinite(self.deviations):
            return "differs, errors not known"
        size = abs(self.deviations)
        direction = "higher" if self.deviations > 0.0 else "lower"
        told = f"{size:.1f} σ"
        if size > _SIGNIFICANT:
            return f"significantly {direction} ({told})"
        if size > _PERHAPS:
            return f"perhaps {direction} ({told})"
        return f"no difference that the data can tell ({told})"

    @property
    def significant(self) -> bool:
        """Whether chance alone would do it in less than one case of a hundred."""
        return abs(self.deviations) > _SIGNIFICANT

    @property
    def difference(self) -> str:
        """The difference with its error and unit."""
        change = self.now.value - self.before.value
        error = math.hypot(self.now.stddev, self.before.stddev)
        shown = LABELS[self.name].difference(change, error)
        return f"+{shown}" if change > 0.0 else shown


def compare(
    now: SummaryValues,
    before: SummaryValues,
    slips: tuple[SlipAtLoad, SlipAtLoad] | None,
) -> tuple[Compared, ...]:
    """Compare two runs.

    Parameters
    ----------
    now, before : SummaryValues
        Summaries of the run and of the baseline.
    slips : pair of SlipAtLoad, optional
        Slip of the run and of the baseline at one load.
    """
    return tuple(_compared(now, before, slips))


def _compared(
    now: SummaryValues, before: SummaryValues, slips: tuple[SlipAtLoad, SlipAtLoad] | None
) -> Iterator[Compared]:
    for name in ("mean_tension", "friction_stiffness", "friction_coefficient"):
        pair = _belt(name, now, before)
        if pair is not None:
            yield pair
    was, is_now = (_value(run.group("final").quantity("capacity_torque")) for run in (before, now))
    if math.isfinite(was.value) and math.isfinite(is_now.value):
        yield Compared("capacity_torque", "at the end", was, is_now)
    worst_before, worst_now = (run.extreme("worst_margin") for run in (before, now))
    if worst_before is not None and worst_now is not None:
        note = "at its worst; loads may differ"
        yield Compared("margin", note, _value(worst_before), _value(worst_now))
    if slips is not None:
        run, base = slips
        note = f"at {run.torque:.3g} N m"
        was, is_now = Quantity(base.slip, base.stddev), Quantity(run.slip, run.stddev)
        yield Compared("slip", note, was, is_now)


def _belt(name: str, now: SummaryValues, before: SummaryValues) -> Compared | None:
    """Compare a belt's property when it was known best, or at the end if that is not told."""
    was, is_now = (_best_known(name, run) for run in (before, now))
    note = "when known best"
    if was is None or is_now is None:
        was, is_now = (_value(run.group("final").quantity(name)) for run in (before, now))
        note = "at the end"
    if not (math.isfinite(was.value) and math.isfinite(is_now.value)):
        return None
    return Compared(name, note, was, is_now)


def _best_known(name: str, run: SummaryValues) -> Quantity | None:
    smoothed = run.group("smoothed", optional=True)
    found = smoothed.group("best_known", optional=True).best_known(name)
    return None if found is None else _value(found)


def _value(found: FinalQuantity | Extreme) -> Quantity:
    return Quantity(found.value, found.stddev)
