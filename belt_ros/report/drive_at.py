"""The drive as it was found, and its curve of slip over load with a 95 % band."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.special import ndtri

from belt_ros.mechanics import (
    Belt,
    BeltDrive,
    DriveError,
    Kinematics,
    Pulley,
    Tensioning,
    torque_capacity,
    torque_from_slip,
)
from belt_ros.report.envelopes import SIGMAS_95
from belt_ros.report.result_directory import ReportError
from belt_ros.report.table_scan import Batch, Floats

_DRAWS = 25  # equally probable values of traction, and as many of kf
_POINTS = 90
_LEVELS = (2.5, 50.0, 97.5)
_GREATEST_LOG_ERROR = 1.5


@dataclass(frozen=True)
class Known:
    """What is known of a belt at one moment; SI, standard deviations beside their values."""

    tension: float  # mean of both spans
    slack: float
    torque: float
    driver_speed: float
    stiffness: float
    stiffness_log_stddev: float
    friction: float
    capacity: float
    capacity_stddev: float

    @property
    def capacity_log_stddev(self) -> float:
        """Standard deviation of ln(capacity); a capacity is positive."""
        relative = self.capacity_stddev / self.capacity
        return min(math.sqrt(math.log1p(relative**2)), _GREATEST_LOG_ERROR)

    @property
    def capacity_interval(self) -> tuple[float, float]:
        """95 % interval of the capacity [N m]."""
        factor = math.exp(SIGMAS_95 * self.capacity_log_stddev)
        return self.capacity / factor, self.capacity * factor

    @classmethod
    def from_row(cls, row: Mapping[str, float]) -> "Known":
        """Take it from a row of a table of states."""
        return cls(
            tension=row["mean_tension"],
            slack=row["slack_tension"],
            torque=row["transmitted_torque"],
            driver_speed=row["driver_speed"],
            stiffness=row["friction_stiffness"],
            stiffness_log_stddev=row["friction_stiffness_log_stddev"],
            friction=row["friction_coefficient"],
            capacity=row["capacity_torque"],
            capacity_stddev=row["capacity_torque_stddev"],
        )


KNOWN_COLUMNS = (
    "mean_tension",
    "slack_tension",
    "transmitted_torque",
    "driver_speed",
    "friction_stiffness",
    "friction_stiffness_log_stddev",
    "friction_coefficient",
    "capacity_torque",
    "capacity_torque_stddev",
)


class RowTally:
    """Picks the row that is nearest to one time.

    Parameters
    ----------
    time : float
        [s]
    """

    columns: Sequence[str] = KNOWN_COLUMNS

    def __init__(self, time: float) -> None:
        self._time = time
        self._nearest = math.inf
        self._row: dict[str, float] = {}

    def add(self, batch: Batch) -> None:
        """Take in the next rows."""
        away = np.abs(batch.elapsed - self._time)
        place = int(np.argmin(away))
        if away[place] < self._nearest:
            self._nearest = float(away[place])
            self._row = {name: float(batch.columns[name][place]) for name in self.columns}

    def known(self) -> Known:
        """Return what was known then."""
        return Known.from_row(self._row)


@dataclass(frozen=True)
class LoadCurve:
    """Slip over load; where the belt cannot carry a load, slip is infinite."""

    torque: Floats  # [N m] on the driven pulley
    slip: Floats  # [-] median
    low: Floats  # [-] 95 % interval
    high: Floats


def drive_from_config(config: Mapping[str, Any]) -> BeltDrive:
    """Return the drive that a summary's configuration describes.

    Raises
    ------
    ReportError
        If it describes none.
    """
    try:
        found = dict(config["drive"])
        return BeltDrive(
            belt=Belt(**found["belt"]),
            driven=Pulley(**found["driven"]),
            driver=Pulley(**found["driver"]),
            span_length=found["span_length"],
            kinematics=Kinematics(found["kinematics"]),
            tensioning=Tensioning(found["tensioning"]),
        )
    except (DriveError, KeyError, TypeError, ValueError) as error:
        raise ReportError(f"the summary's configuration describes no drive: {error}") from error


def with_friction(drive: BeltDrive, friction: float, stiffness: float) -> BeltDrive:
    """Return the drive with mu and kf of the driven pulley, the driver's in proportion."""
    mu = friction / drive.driven.friction_coefficient
    kf = stiffness / drive.driven.friction_stiffness
    driven, driver = (
        replace(
            pulley,
            friction_coefficient=pulley.friction_coefficient * mu,
            friction_stiffness=pulley.friction_stiffness * kf,
        )
        for pulley in (drive.driven, drive.driver)
    )
    return replace(drive, driven=driven, driver=driver)


def _held_tension(drive: BeltDrive, known: Known) -> float:
    """Return what the tensioning holds [N], at which the mean tension is what it was found to be.

    Between fixed centres the load's part of the mean tension, a few per cent, is left in.
    """
    rim_speed = known.driver_speed * drive.driver.radius
    if drive.tensioning is Tensioning.CONSTANT_SLACK:
        return known.slack
    if drive.tensioning is Tensioning.CONSTANT_HUB_LOAD:
        return known.tension - drive.belt.mass_per_length * rim_speed**2
    return known.tension


def load_curve(drive: BeltDrive, known: Known, greatest_torque: float) -> LoadCurve:
    """Return slip over load for a belt as it is known.

    The curve ends at the capacity that was estimated. Its band is that of the capacity and of kf,
    taken as independent: their errors compensate in part, so the band is rather too wide.

    Parameters
    ----------
    drive : BeltDrive
    known : Known
    greatest_torque : float
        Up to which load [N m].

    Raises
    ------
    DriveError
        If no steady state is possible.
    """
    found = with_friction(drive, known.friction, known.stiffness)
    held, speed = _held_tension(found, known), abs(known.driver_speed)
    centre = known.capacity / float(torque_capacity(found, held, speed))
    z = ndtri((np.arange(_DRAWS) + 0.5) / _DRAWS)
    spread = known.capacity_log_stddev
    tensions = held * centre * np.exp(spread * z)
    lift = drive.belt.mass_per_length * (speed * drive.driver.radius) ** 2
    tensions = np.maximum(tensions, 1.05 * lift)
    if not all(map(math.isfinite, (centre, spread, known.stiffness_log_stddev))):
        raise DriveError("tension and friction are not known")
    torques = np.linspace(0.0, greatest_torque, _POINTS)
    log_error = min(known.stiffness_log_stddev, _GREATEST_LOG_ERROR)
    draws = [
        _slips(with_friction(found, known.friction, kf), tensions, speed, torques)
        for kf in known.stiffness * np.exp(log_error * z)
    ]
    slips = np.concatenate(draws)
    low, _, high = np.percentile(slips, _LEVELS, axis=0, method="inverted_cdf")
    (median,) = _slips(found, np.array([held * centre]), speed, torques)
    return LoadCurve(torques, median, low, high)


def _slips(drive: BeltDrive, tensions: Floats, speed: float, torques: Floats) -> Floats:
    """Slips (tensions, torques); infinite beyond the capacity."""
    grid = np.concatenate([[0.0], np.geomspace(1e-5, 1.0, 120)])
    carried = torque_from_slip(drive, grid[None, :], tensions[:, None], speed)
    limits = torque_capacity(drive, tensions, speed)
    out = np.full((len(tensions), len(torques)), np.inf)
    for row, (curve, limit) in enumerate(zip(carried, limits, strict=True)):
        within = torques < limit
        out[row, within] = np.interp(torques[within], curve, grid)
    return out
