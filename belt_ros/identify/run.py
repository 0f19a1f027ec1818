"""From a bag to what it says of the belt."""

import dataclasses
import math
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from belt_ros.drive_inputs import InputSettings
from belt_ros.estimation import Measurement, Rejection
from belt_ros.estimation.measurement import check_measurement
from belt_ros.identify.advice import telling_load
from belt_ros.identify.blocks import Block, merged, steady_blocks
from belt_ros.identify.curve import Curve, curve_of
from belt_ros.identify.fit import Fit, Profile, fitted
from belt_ros.identify.model import BELT, SlipModel, slip_model
from belt_ros.identify.result import (
    QUANTITIES,
    Goodness,
    Identified,
    Interval,
    log_interval,
    plain_interval,
)
from belt_ros.replay.drive_bag import DriveBag
from belt_ros.replay.errors import BagError, DamagedInsideError
from belt_ros.settings import DriveSettings

_Floats = NDArray[np.float64]
_FEWEST_LOADS = 2
_SCATTERED = 1.5  # from which on the sensors' noise is taken to be larger than told
_FEW = 5  # blocks beside the first of their load, below which scatter says nothing
_LEAST_RANGE = 0.02  # of pull, in prior tensions
_NAMES = {
    "tension": "tension",
    "friction_stiffness": "kf",
    "friction_coefficient": "mu",
    "ratio_bias": "ratio bias",
}
_OTHERWISE = {
    "tension": "measure it: by a hub load, or the pitch of a plucked span",
    "friction_stiffness": "it hardly matters to slip on this drive",
    "friction_coefficient": "only its product with the tension shows, in the capacity",
    "ratio_bias": "calibrate it without load",
}


def identify(
    bag: str | Path,
    settings: DriveSettings,
    *,
    inputs: InputSettings | None = None,
    prefix: str = "",
    topic: str | None = None,
    wide: bool = False,
) -> Identified:
    """Fit kf, friction, tension and radius ratio of one belt to a bag with loads.

    Parameters
    ----------
    bag : path
        A rosbag2 directory, or a bare .mcap or .db3 file.
    settings : DriveSettings
        The drive, its sensors' noise, and the priors.
    inputs : InputSettings, optional
        How its measurements arrive; by default as joint states.
    prefix : str
        What the drive's topics begin with, where there are several drives: ``drive_name/``.
    topic : str, optional
        The topic of joint states, or the namespace of other topics, where there are several.
    wide : bool
        Start from wide priors instead of those of `settings`.

    Raises
    ------
    BagError
        If the bag cannot be read, or holds no steady loads to go by.
    """

    def read(*, salvage: bool) -> Identified:
        path = Path(bag)
        with DriveBag(
            path, settings, inputs, prefix=prefix, topic=topic, salvage=salvage
        ) as source:
            _check_joints(source, settings)
            contents = (sample.content for sample in source.samples())
            measurements = (one for one in contents if isinstance(one, Measurement))
            found = identify_measurements(measurements, settings, bag=path.name, wide=wide)
            notes = (source.note,) if source.note else ()
        return dataclasses.replace(found, warnings=(*notes, *found.warnings))

    try:
        return read(salvage=False)
    except DamagedInsideError:
        return read(salvage=True)


def identify_measurements(
    measurements: Iterable[Measurement],
    settings: DriveSettings,
    *,
    bag: str = "",
    wide: bool = False,
) -> Identified:
    """As `identify`, from measurements in the order of time; `bag` is a name for messages."""
    stamps: list[int] = []
    stream = _credible(measurements, settings, stamps)
    mass = settings.drive.belt.mass_per_length
    curve, blocks = curve_of(steady_blocks(stream, settings), settings.prior.tension, mass)
    _check(curve, settings, bag)
    model, fit = _fit(curve, settings, wide=wide)
    scatter = _scatter(model, fit, blocks, settings)
    if scatter > _SCATTERED:
        model, fit = _fit(curve.widened(scatter), settings, wide=wide)
    return _identified(model, fit, scatter, settings, bag, stamps[0])


def _check_joints(source: DriveBag, settings: DriveSettings) -> None:
    seen = source.joints_seen
    asked = settings.driver.name, settings.driven.name
    if seen and not set(asked) <= set(seen):
        raise BagError(
            f"{source.path}: the configuration asks for the joints {' and '.join(asked)}; the "
            f"messages carry {', '.join(seen)}. Set driver.joint and driven.joint."
        )


def _credible(
    measurements: Iterable[Measurement], settings: DriveSettings, stamps: list[int]
) -> Iterator[Measurement]:
    """Pass on what sensors can say; the first stamp goes to `stamps`."""
    for measurement in measurements:
        if check_measurement(measurement, settings.limits) is Rejection.NONE:
            if not stamps:
                stamps.append(measurement.stamp_ns)
            yield measurement


def _check(curve: Curve, settings: DriveSettings, bag: str) -> None:
    loads = len(curve.pull)
    spread = float(np.ptp(curve.pull)) if loads else 0.0
    if loads < _FEWEST_LOADS or spread < _LEAST_RANGE * settings.prior.tension:
        raise BagError(
            f"{bag or 'the measurements'}: {loads} steady loads, {spread:.3g} N of pull apart; "
            "identification needs at least two, each held for 2 s or more while the drive turns, "
            "with the torque of one pulley measured"
        )


def _fit(curve: Curve, settings: DriveSettings, *, wide: bool) -> tuple[SlipModel, Fit]:
    model = slip_model(curve, settings.drive, settings.prior, settings.drift, wide=wide)
    return model, fitted(model)


def _scatter(model: SlipModel, fit: Fit, blocks: list[Block], settings: DriveSettings) -> float:
    """Deviation of blocks of one load from their mean, over what the sensors' noise makes."""
    step = max(float(np.max(np.abs(model.curve.pull))) / 40.0, 1e-3 * settings.prior.tension)
    lift = 0.02 * settings.prior.tension
    mass = max(settings.drive.belt.mass_per_length, 1e-12)
    numbers = np.array(merged(blocks, step, lift, mass))
    free = len(blocks) - len(set(numbers.tolist()))
    if free < _FEW:
        return 1.0
    table = np.array(blocks).T
    beside = SlipModel(Curve(*table), settings.drive, model.prior, 1e-9, 1.0)
    unknowns = beside.start
    unknowns[: len(BELT)] = fit.unknowns[: len(BELT)]
    residuals = beside.residuals(unknowns)[: len(blocks)]
    slopes = beside.noise_slopes(unknowns)
    deviations = np.hypot(1.0, slopes)
    squares = 0.0
    for number in set(numbers.tolist()):
        chosen = numbers == number
        weights = (deviations[chosen] * table[3][chosen]) ** -2.0
        pulls = residuals[chosen] * table[3][chosen]
        squares += float(weights @ (pulls - weights @ pulls / np.sum(weights)) ** 2)
    return math.sqrt(squares / free)


def _identified(
    model: SlipModel, fit: Fit, scatter: float, settings: DriveSettings, bag: str, begin_ns: int
) -> Identified:
    intervals = {name: _interval(model, fit, place) for place, name in enumerate(QUANTITIES)}
    stddev = np.sqrt(np.diagonal(fit.covariance))
    loads = model.loads
    goodness = Goodness(fit.squares, loads, float(chi2.sf(fit.squares, loads)), scatter)
    radius = settings.drive.driven.radius
    greatest = radius * float(np.max(np.abs(model.curve.pull)))
    capacity = _capacity(model, fit, radius)
    advice = _advice(intervals, capacity, model, fit, settings)
    return Identified(
        bag=bag,
        drive=settings.name,
        begin_ns=begin_ns,
        **intervals,
        capacity=capacity,
        correlation=fit.covariance / np.outer(stddev, stddev),
        goodness=goodness,
        curve=model.curve,
        greatest_torque=greatest,
        warnings=(*_misgivings(goodness), *advice),
    )


def _interval(model: SlipModel, fit: Fit, place: int) -> Interval:
    profile = Profile(model, fit, lambda belt: float(belt[place]))
    mean, stddev = float(model.prior.mean[place]), float(model.prior.stddev[place])
    low, high = (mean + stddev * end for end in profile.interval())
    value = mean + stddev * profile.best
    if QUANTITIES[place] == "ratio_bias":
        return plain_interval(value, (low, high), stddev, "-")
    unit = {"tension": "N", "friction_stiffness": "N/m2"}.get(QUANTITIES[place], "-")
    return log_interval(value, (low, high), (mean, stddev), unit)


def _capacity(model: SlipModel, fit: Fit, radius: float) -> Interval:
    """Torque on the driven pulley at gross slip."""
    prior = model.prior

    def log_capacity(belt: _Floats) -> float:
        return math.log(radius * model.capacity(prior.mean + prior.stddev * belt))

    profile = Profile(model, fit, log_capacity)
    step = np.eye(len(BELT))
    slopes = np.array([log_capacity(row) - log_capacity(-row) for row in step]) / 2.0
    spread = float(np.linalg.norm(slopes))
    before = log_capacity(np.zeros(len(BELT))), spread
    return log_interval(profile.best, profile.interval(), before, "N m")


def _misgivings(goodness: Goodness) -> Iterator[str]:
    if not goodness.fits:
        yield (
            f"the model does not fit: the sum of squares is {goodness.squares:.3g} where about "
            f"{goodness.loads} is expected (chance {goodness.probability:.2g}); radii, torque "
            "scale or priors may be wrong, or the belt changed meanwhile"
        )
    if goodness.scatter > _SCATTERED:
        yield (
            f"at one and the same load slip differs by {goodness.scatter:.2g} times the stated "
            "noise: the sensors are worse than noise.* says, or the belt changed during the bag; "
            "intervals are widened by that"
        )


def _advice(
    intervals: dict[str, Interval],
    capacity: Interval,
    model: SlipModel,
    fit: Fit,
    settings: DriveSettings,
) -> Iterator[str]:
    """Say of each quantity that the data do not tell what would."""
    for place, (name, interval) in enumerate(intervals.items()):
        if interval.told:
            continue
        pull = telling_load(model, fit, place, settings.prior.creep_error_stddev)
        what = (
            f"{_NAMES[name]}: the data do not tell, its interval is {interval.share:.0%} of the "
            "prior's"
        )
        if pull is None or name == "ratio_bias":
            yield f"{what}; {_OTHERWISE[name]}"
        else:
            torque = pull * settings.drive.driven.radius
            risk = ""
            if torque > capacity.low:
                risk = (
                    f", at which the belt may slip (capacity {capacity.low:.3g} to "
                    f"{capacity.high:.3g} N m), or {_OTHERWISE[name]}"
                )
            yield f"{what}; load the drive above {torque:.3g} N m{risk}"
