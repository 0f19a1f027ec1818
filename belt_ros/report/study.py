"""All that a report tells, gathered from a result directory in one pass through each table."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from belt_ros.estimation import Quantity
from belt_ros.estimation.estimate import log_spread
from belt_ros.mechanics import BeltDrive, DriveError
from belt_ros.report.alarm_history import AlarmHistory, AlarmTally, raised_ns, read_changes
from belt_ros.report.alarm_totals import AlarmTotal, alarm_totals
from belt_ros.report.comparison import Compared, compare
from belt_ros.report.drive_at import Known, LoadCurve, RowTally, drive_from_config, load_curve
from belt_ros.report.envelopes import Curves, EnvelopeTally, Grid
from belt_ros.report.load_slip import Cells, CloudTally, SlipAtLoadTally, Window, common_step
from belt_ros.report.quality import QualityTally
from belt_ros.report.result_directory import ReportError, ResultDirectory, SummaryValues
from belt_ros.report.sensor_fit import FitTally, SensorFit, read_fits
from belt_ros.report.table_scan import Tally, extremes, row_count, scan

QUANTITIES = (
    "slip",
    "predicted_creep",
    "tight_tension",
    "slack_tension",
    "mean_tension",
    "friction_stiffness",
    "margin",
    "transmitted_torque",
    "capacity_torque",
)
ONLY_MOVING = ("slip", "predicted_creep")
_WELL_MOVING = 10.0  # times the standstill speed, as in the summary
_FINE_ALARMS = 20
_BELOW = 0.04  # of the picture below zero, at least
_KNEE = 0.95  # of the capacity: slip there sets the picture's height


@dataclass(frozen=True)
class ModelCurve:
    """Slip over load at one moment."""

    when: str
    known: Known
    curve: LoadCurve


@dataclass(frozen=True)
class LoadPicture:
    """Load against slip."""

    window: Window
    cells: Cells
    beyond: int  # measurements out of the picture
    moving: int  # all of those in which slip has a meaning
    curves: tuple[ModelCurve, ...]


@dataclass(frozen=True)
class Study:
    """All that a report tells."""

    results: ResultDirectory
    filtered: Curves
    smoothed: Curves | None
    alarms: AlarmHistory
    totals: tuple[AlarmTotal, ...]
    picture: LoadPicture
    quality: QualityTally
    sensor_fits: tuple[SensorFit, ...]
    baseline: ResultDirectory | None
    compared: tuple[Compared, ...]

    @property
    def summary(self) -> SummaryValues:
        """The summary of the replay."""
        return self.results.summary


def study(results: ResultDirectory, baseline: ResultDirectory | None) -> Study:
    """Gather a report.

    Raises
    ------
    ReportError
        If something in the results is damaged.
    """
    summary, config = results.summary, results.summary.group("config")
    drive = drive_from_config(config.raw())
    limits = config.group("limits")
    least_speed = _WELL_MOVING * limits.number("standstill_speed") / drive.driver.radius
    duration, gap = summary.number("duration"), limits.number("greatest_gap")
    smoothed, best = _with_hindsight(results, duration, gap, least_speed)
    greatest_torque = _greatest_torque(results, baseline)
    curves = _model_curves(drive, summary, best, greatest_torque)
    changes = read_changes(results.bag)
    window = _window(results, curves, greatest_torque)
    grid = Grid(row_count(results.table), duration, gap, raised_ns(changes, _FINE_ALARMS))
    envelopes = EnvelopeTally(grid, QUANTITIES, ONLY_MOVING, least_speed)
    cloud, at_load = CloudTally(window, least_speed), SlipAtLoadTally(greatest_torque)
    quality, alarms = QualityTally(gap), AlarmTally(changes)
    fits = FitTally(read_fits(results.bag))
    _scan(results, envelopes, cloud, at_load, quality, alarms, fits)
    compared = () if baseline is None else _compared(results, baseline, at_load, greatest_torque)
    history = alarms.history()
    picture = LoadPicture(window, cloud.cells(), cloud.beyond, cloud.moving, tuple(curves))
    return Study(
        results,
        envelopes.curves(),
        smoothed,
        history,
        alarm_totals(summary, history),
        picture,
        quality,
        fits.fits(),
        baseline,
        compared,
    )


def _scan(results: ResultDirectory, *tallies: Tally) -> None:
    scan(results.table, results.summary.count("start_ns"), *tallies)


def _with_hindsight(
    results: ResultDirectory, duration: float, gap: float, least_speed: float
) -> tuple[Curves | None, Known | None]:
    """Return the smoothed curves, and what was known when tension was known best."""
    table = results.smoothed
    if table is None or row_count(table) == 0:
        return None, None
    told = results.summary.group("smoothed", optional=True)
    best = told.group("best_known", optional=True).best_known("mean_tension")
    between = gap + (told.number("block") if told else 0.0)
    grid = Grid(row_count(table), duration, between)
    envelopes = EnvelopeTally(grid, QUANTITIES, ONLY_MOVING, least_speed)
    row = RowTally(best.time if best else duration)
    scan(table, results.summary.count("start_ns"), envelopes, row)
    return envelopes.curves(), row.known()


def _known_at_end(summary: SummaryValues) -> Known:
    final = summary.group("final")
    stiffness = final.quantity("friction_stiffness")
    capacity = final.quantity("capacity_torque")
    return Known(
        tension=final.quantity("mean_tension").value,
        slack=final.quantity("slack_tension").value,
        torque=final.quantity("transmitted_torque").value,
        driver_speed=final.quantity("driver_speed").value,
        stiffness=stiffness.value,
        stiffness_log_stddev=log_spread(Quantity(stiffness.value, stiffness.stddev)),
        friction=final.quantity("friction_coefficient").value,
        capacity=capacity.value,
        capacity_stddev=capacity.stddev,
    )


def _model_curves(
    drive: BeltDrive, summary: SummaryValues, best: Known | None, greatest_torque: float
) -> list[ModelCurve]:
    """Curves at the end and, with hindsight, when tension was known best; none that cannot be."""
    moments = [("at the end", _known_at_end(summary))]
    if best is not None:
        moments.append(("when tension was known best", best))
    found = (_model_curve(drive, when, known, greatest_torque) for when, known in moments)
    return [curve for curve in found if curve is not None]


def _model_curve(drive: BeltDrive, when: str, known: Known, greatest: float) -> ModelCurve | None:
    """Return the curve at one moment; a state that cannot be has none."""
    try:
        return ModelCurve(when, known, load_curve(drive, known, greatest))
    except (DriveError, ZeroDivisionError):
        return None


def _greatest_torque(results: ResultDirectory, baseline: ResultDirectory | None) -> float:
    """Return the load up to which pictures reach [N m]: what was carried, and the capacity."""
    runs = [results] if baseline is None else [results, baseline]
    carried = [abs(x) for run in runs for x in extremes(run.table, "transmitted_torque")]
    greatest = max((x for x in carried if math.isfinite(x)), default=0.0)
    capacity = results.summary.group("final").quantity("capacity_torque").value
    if math.isfinite(capacity) and capacity > 0.0:
        greatest = max(greatest, min(1.15 * capacity, 4.0 * greatest)) or capacity
    if greatest <= 0.0:
        raise ReportError(f"{results.table}: no load was ever known")
    return 1.05 * greatest


def _window(results: ResultDirectory, curves: Sequence[ModelCurve], greatest: float) -> Window:
    """Show creep well: gross slip, of which there may be a hundred times more, leaves the top."""
    summary = results.summary
    slip = summary.extreme("greatest_slip")
    seen = abs(slip.value) if slip else 0.0
    knees = []
    for found in curves:
        carried = found.curve.slip[found.curve.torque < _KNEE * found.known.capacity]
        if len(carried):
            knees.append(float(carried[-1]))
    high = min([1.1 * seen, *(2.5 * knee for knee in knees)]) if knees else 1.1 * seen
    high = max(high, 1e-4)
    least, _ = extremes(results.table, "transmitted_torque")
    low = max(-greatest, 1.1 * least) if least < -_BELOW * greatest else -_BELOW * greatest
    return Window(low, greatest, high * min(low / greatest, -_BELOW), high)


def _compared(
    results: ResultDirectory,
    baseline: ResultDirectory,
    at_load: SlipAtLoadTally,
    greatest_torque: float,
) -> tuple[Compared, ...]:
    before = SlipAtLoadTally(greatest_torque)
    _scan(baseline, before)
    step = common_step(at_load, before)
    slips = None if step is None else (at_load.at(step), before.at(step))
    return compare(results.summary, baseline.summary, slips)
