"""Pieces of a run, half a second or longer, in which load and speed were as good as steady.

Of each, one point of the curve of slip against load. Creep is that of equilibrium once the belt on
the arcs has been replaced since the load changed, so a piece lasts several arc lengths of belt
travel, and those beside a sudden change of load are left out.
"""

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation import Measurement
from belt_ros.mechanics.constants import drive_constants
from belt_ros.settings import DriveSettings

_Floats = NDArray[np.float64]
_SECONDS = 1e-9
_SHORTEST, _LONGEST = 0.5, 60.0  # [s]
_TRAVEL = 4.0  # arc lengths of belt
_FEWEST, _MOST = 8, 50_000  # samples
_CHANGE = 0.1  # of pull from one block to the next, in prior tensions
_WINDING_MISSED = 0.5  # of the slip by which spans wind up, taken as uncertain
_HIDDEN = 1.0 / 3.0  # scatter over stated noise below which the noise does not average out
_TURNING = 5.0  # standstill speeds


class Block(NamedTuple):
    """One point of the curve of slip against load."""

    slip: float  # 1 - (R1 omega1)/(R2 omega2) by the radii as told [-]
    slip_stddev: float
    pull: float  # w_H - w_L along the rotation: positive where the driver drives [N]
    pull_stddev: float
    speed: float  # of the belt [m/s]


class _Piece(NamedTuple):
    """A block, and what its neighbours are compared by."""

    block: Block
    begin: float  # [s]
    end: float
    turning: float  # +1 or -1


def steady_blocks(measurements: Iterable[Measurement], settings: DriveSettings) -> Iterator[Block]:
    """Yield the steady pieces of a run, in order; memory stays flat.

    Measurements without both speeds and at least one torque are left out.
    """
    before: _Piece | None = None
    present: _Piece | None = None
    for piece in _pieces(measurements, settings):
        if piece is None:
            before = present = None
            continue
        if before is not None and present is not None:
            settled = _settled(before, present, piece, settings)
            if settled is not None:
                yield settled
        before, present = present, piece


def _pieces(
    measurements: Iterable[Measurement], settings: DriveSettings
) -> Iterator[_Piece | None]:
    """Yield pieces; None where the chain breaks: at gaps, jumps of time, stops and reversals."""
    drive, limits = settings.drive, settings.limits
    arc = max(one.radius * one.wrap_angle for one in (drive.driver, drive.driven))
    slowest = _TURNING * limits.standstill_speed
    rows: list[tuple[float, ...]] = []
    travel = 0.0
    origin_ns: int | None = None
    for measurement in measurements:
        if not _usable(measurement):
            continue
        origin_ns = measurement.stamp_ns if origin_ns is None else origin_ns
        row = _row(measurement, origin_ns)
        rim = drive.driver.radius * row[1]
        if rows:
            dt = row[0] - rows[-1][0]
            broken = not 0.0 < dt <= limits.greatest_gap or row[1] * rows[-1][1] <= 0.0
            if broken or row[0] - rows[0][0] > _LONGEST:
                rows, travel = [], 0.0
                yield None
            else:
                travel += abs(rim) * dt
        if abs(rim) < slowest or drive.driven.radius * abs(row[2]) < slowest:
            if rows:
                yield None
            rows, travel = [], 0.0
            continue
        rows.append(row)
        long_enough = row[0] - rows[0][0] >= _SHORTEST and travel >= _TRAVEL * arc
        if (long_enough and len(rows) >= _FEWEST) or len(rows) >= _MOST:
            yield _piece(np.array(rows), settings)
            rows, travel = [row], 0.0


def _usable(measurement: Measurement) -> bool:
    speeds = all(math.isfinite(speed) for speed in measurement.speeds)
    return speeds and any(math.isfinite(torque) for torque in measurement.torques)


def _row(measurement: Measurement, origin_ns: int) -> tuple[float, ...]:
    """Time [s], speeds, torques, positions."""
    time = (measurement.stamp_ns - origin_ns) * _SECONDS
    return (time, *measurement.speeds, *measurement.torques, *measurement.positions)


def _piece(rows: _Floats, settings: DriveSettings) -> _Piece:
    times, driver = rows.T[:2]
    drive = settings.drive
    turning = math.copysign(1.0, float(driver[0]))
    slip, slip_variance = _slip(rows, settings)
    pulls = [pull for pull in _pulls(rows, settings) if math.isfinite(pull[0])]
    weights = np.array([1.0 / variance for _, variance in pulls])
    pull = float(weights @ [value for value, _ in pulls] / np.sum(weights))
    block = Block(
        slip,
        math.sqrt(slip_variance),
        turning * pull,
        float(np.sum(weights)) ** -0.5,
        drive.driver.radius * abs(float(np.mean(driver))),
    )
    return _Piece(block, float(times[0]), float(times[-1]), turning)


def _slip(rows: _Floats, settings: DriveSettings) -> tuple[float, float]:
    """Slip and its variance, from speeds or from positions, whichever tell it better."""
    times, driver, driven = rows.T[:3]
    noise = settings.noise.noise_rows()
    ratio = settings.drive.driven.radius / settings.drive.driver.radius
    mean2, mean1 = float(np.mean(driver)), float(np.mean(driven))
    variance = sum(
        _mean_variance(speeds, noise[0, at] * mean**2 + noise[1, at]) / mean**2
        for at, (speeds, mean) in enumerate(((driver, mean2), (driven, mean1)))
    )
    kept = ratio * mean1 / mean2
    turns = settings.driver.turn, settings.driven.turn
    angles = [
        _turned(times, speeds, positions, turn)
        for speeds, positions, turn in zip((driver, driven), rows.T[5:7], turns, strict=True)
    ]
    if all(math.isfinite(angle) and angle != 0.0 for angle in angles):
        by_angle = sum(
            2.0 * noise[1, at] / angle**2 for at, angle in zip((4, 5), angles, strict=True)
        )
        if by_angle < variance:
            kept, variance = ratio * angles[1] / angles[0], by_angle
    return 1.0 - kept, kept**2 * variance


def _mean_variance(values: _Floats, stated: float) -> float:
    """Variance of a mean; noise that does not show, as that of rounding, does not average out."""
    trend = np.polynomial.Polynomial.fit(np.arange(len(values)), values, 1)
    scatter = float(np.var(values - trend(np.arange(len(values)))))
    return stated if scatter < _HIDDEN**2 * stated else stated / len(values)


def _turned(times: _Floats, speeds: _Floats, positions: _Floats, turn: float) -> float:
    """Angle turned [rad] by positions that may wrap; NaN if one is missing."""
    passed = np.diff(times) * 0.5 * (speeds[1:] + speeds[:-1])
    expected = np.concatenate([[0.0], np.cumsum(passed)])
    if not np.all(np.isfinite(positions)):
        return math.nan
    beside = np.unwrap(positions - expected, period=turn)
    return float(beside[-1] - beside[0] + expected[-1])


def _pulls(rows: _Floats, settings: DriveSettings) -> Iterator[tuple[float, float]]:
    """Mean pull [N] by the torque on each pulley and its inertia, and its variance."""
    times = rows[:, 0] - np.mean(rows[:, 0])
    spread = float(times @ times)
    noise = settings.noise.noise_rows()
    pulleys = (settings.drive.driver, 1.0), (settings.drive.driven, -1.0)
    for at, (pulley, sign) in enumerate(pulleys):
        torques = rows[:, 3 + at]
        torque = float(np.mean(torques))
        speeds = rows[:, 1 + at]
        acceleration = float(times @ speeds) / spread
        speed_variance = noise[0, at] * float(np.mean(speeds)) ** 2 + noise[1, at]
        torque_variance = (noise[0, 2 + at] * torque**2 + noise[1, 2 + at]) / len(torques)
        variance = torque_variance + pulley.inertia**2 * speed_variance / spread
        pull = sign * (torque - pulley.inertia * acceleration) / pulley.radius
        yield pull, variance / pulley.radius**2


def _settled(before: _Piece, piece: _Piece, after: _Piece, settings: DriveSettings) -> Block | None:
    """Return the middle one of three pieces; None if the load changes much.

    What a load that changes a little makes uncertain is added to its deviations.
    """
    block = piece.block
    steps = [after.block.pull - block.pull, block.pull - before.block.pull]
    if max(map(abs, steps)) > _CHANGE * settings.prior.tension:
        return None
    rate = sum(steps) / (0.5 * (after.end + after.begin - before.end - before.begin))
    constants = drive_constants(settings.drive)
    arc = max(
        constants.driver_radius * constants.driver_wrap,
        constants.driven_radius * constants.driven_wrap,
    )
    winding = rate * constants.span_compliance / block.speed
    behind = abs(rate) * arc / block.speed
    return block._replace(
        slip=block.slip - winding,
        slip_stddev=math.hypot(block.slip_stddev, _WINDING_MISSED * winding),
        pull_stddev=math.hypot(block.pull_stddev, behind),
    )


def merged(blocks: Sequence[Block], pull_step: float, lift_step: float, mass: float) -> list[int]:
    """Return for each block the number of its load: alike are those of one pull and one m v^2."""
    keys = [
        (round(block.pull / pull_step), round(mass * block.speed**2 / lift_step))
        for block in blocks
    ]
    numbers = {key: number for number, key in enumerate(sorted(set(keys)))}
    return [numbers[key] for key in keys]
