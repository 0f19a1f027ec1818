"""Calibration of the radius ratio at no load.

An unloaded belt creeps by next to nothing, so the pulleys' speeds are as their radii, and what is
left between them is the error of the nominal ratio R1/R2. While the drive turns, steadily and with
next to no pull, speeds are averaged. The little that the pull still makes the belt creep is taken
off, and all of it counts as uncertain: whether it is load, or the offset of a torque sensor, cannot
be told.

Time is that of the measurements; there is no clock here.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation.assumptions import SensorNoise
from belt_ros.estimation.estimate import BeltEstimate, Quantity
from belt_ros.estimation.gaussian_sum import Component
from belt_ros.estimation.measurement import Measurement, sensor_variances
from belt_ros.estimation.speed_pairs import SpeedPairs
from belt_ros.estimation.state import Index
from belt_ros.mechanics.drive import BeltDrive

_Floats = NDArray[np.float64]
_SECONDS = 1e-9
_SETTLING = 5.0  # arc lengths of belt travel until the creep of an earlier load has left the arcs
_LARGEST_CREEP = 0.5  # of the accuracy
_LONGEST_GAP = 1.0  # [s] between samples
_BATCHES = 10
_STUDENT = 1.154  # 97.5 % quantile of Student's t with 9 degrees of freedom over the normal one
_FEWEST, _MOST = 50, 100_000  # samples
_SEEN = 1.0 / 3.0  # scatter over stated noise below which the noise does not average out
_FAR = 3.3  # deviations beyond which a belief is wrong rather than off


@dataclass(frozen=True, slots=True)
class CalibrationResult:
    """What came of a calibration; `ratio_bias` is None if nothing did, `message` says why.

    Torque offsets are what the sensors say at no load [N m], None where there are none.
    """

    message: str
    ratio_bias: Quantity | None = None  # [-]
    driver_torque_offset: Quantity | None = None
    driven_torque_offset: Quantity | None = None
    samples: int = 0


class Calibration:
    """One calibration, from `begin` to a result.

    Parameters
    ----------
    drive : BeltDrive
    noise : SensorNoise
    accuracy : float
        Standard deviation of the ratio bias that is wanted [-].
    duration : float
        For how long speeds are averaged [s]; again as long, and again, while that is not enough.
    patience : float
        After how long without enough usable samples, or without that accuracy, it is given up [s].
    slowest : float
        Rim speed [m/s] that counts as turning.
    """

    def __init__(
        self,
        drive: BeltDrive,
        noise: SensorNoise,
        accuracy: float = 5e-5,
        duration: float = 5.0,
        patience: float = 30.0,
        slowest: float = 0.1,
    ) -> None:
        self._drive = drive
        self._noise = noise.noise_rows()
        self._accuracy = accuracy
        self._duration = duration
        self._patience = patience
        self._slowest = slowest
        self._settling = _SETTLING * max(
            pulley.radius * pulley.wrap_angle for pulley in (drive.driver, drive.driven)
        )
        self._running = False

    @property
    def running(self) -> bool:
        """Whether samples are being taken."""
        return self._running

    @property
    def progress(self) -> float:
        """Share of the time for averaging that has been gathered, 0 to 1."""
        return min(self._averaged / self._duration, 1.0) if self._running else 0.0

    def begin(self, stamp_ns: int) -> None:
        """Begin anew, at the time of the last measurement [ns]."""
        self._running = True
        self._began_ns = self._heard_ns = self._last_ns = stamp_ns
        self._pairs = SpeedPairs()
        self._travel = 0.0  # of the belt without load [m]
        self._averaged = 0.0  # [s]
        self._due = self._duration  # when that is next judged [s]
        self._obstacle = "no measurement came"
        self._rows: list[tuple[float, ...]] = []

    def take(self, measurement: Measurement, estimate: BeltEstimate) -> CalibrationResult | None:
        """Take in a measurement and what the filter makes of it; return the result, if any.

        Does nothing unless it is running.
        """
        if not self._running:
            return None
        self._heard_ns = measurement.stamp_ns
        pair = self._pairs.take(measurement)
        if pair is not None:
            self._use(pair, estimate)
        elif (self._heard_ns - self._last_ns) * _SECONDS > _LONGEST_GAP:
            self._travel = 0.0
            self._obstacle = "a speed is not measured"
        full = len(self._rows) >= _MOST
        if self._averaged >= self._due or full:
            result = self._result()
            if result.ratio_bias is not None or full:
                self._running = False
                return result
            self._due += self._duration  # more of them may do
            self._obstacle = result.message
        if (self._heard_ns - self._began_ns) * _SECONDS >= self._patience:
            return self.give_up()
        return None

    def _use(self, pair: Measurement, estimate: BeltEstimate) -> None:
        """Take in a measurement of both speeds."""
        dt = (pair.stamp_ns - self._last_ns) * _SECONDS
        self._last_ns = pair.stamp_ns
        obstacle = self._obstacle_in(pair, estimate)
        if obstacle or not 0.0 < dt <= _LONGEST_GAP:
            self._travel = 0.0
            self._obstacle = obstacle or f"there was a gap of {dt:.3g} s in the measurements"
            return
        self._travel += abs(pair.driver_speed) * self._drive.driver.radius * dt
        if self._travel >= self._settling:
            self._averaged += dt
            self._rows.append(self._row(pair, estimate))

    def give_up(self) -> CalibrationResult:
        """End without a result, such as when no more measurements come."""
        self._running = False
        if self._due > self._duration:
            return CalibrationResult(self._obstacle, samples=len(self._rows))
        return CalibrationResult(
            f"ratio not calibrated: {self._averaged:.3g} s of {self._duration:.3g} s could be used "
            f"in {(self._heard_ns - self._began_ns) * _SECONDS:.3g} s; {self._obstacle}",
            samples=len(self._rows),
        )

    def _obstacle_in(self, measurement: Measurement, estimate: BeltEstimate) -> str:
        """Why a measurement cannot be used, or ""."""
        speeds = measurement.speeds
        rims = speeds[0] * self._drive.driver.radius, speeds[1] * self._drive.driven.radius
        rim = min(abs(rims[0]), abs(rims[1]))
        if rim < self._slowest or rims[0] * rims[1] < 0.0:
            return f"the drive stands (rim speed {rim:.3g} m/s, at least {self._slowest:g} m/s)"
        creep, torque = estimate.predicted_creep, estimate.transmitted_torque.value
        limit = _LARGEST_CREEP * self._accuracy
        off = math.hypot(*creep)
        if not off <= limit:
            return (
                f"the drive is loaded: {torque:.3g} N m, under which the belt creeps by "
                f"{creep.value:.2g} +/- {creep.stddev:.2g} (at most {limit:.2g})"
            )
        return ""

    def _row(self, measurement: Measurement, estimate: BeltEstimate) -> tuple[float, ...]:
        """Ratio bias, its variance, creep and its deviation, torques and their variances, samples.

        Variances are those of one sample; of how many the values are means, for ratio and torques.
        """
        variances = sensor_variances(measurement.values(), self._noise).tolist()
        driver, driven = measurement.speeds
        creep = estimate.predicted_creep
        nominal = self._drive.driver.radius * driver / (self._drive.driven.radius * driven)
        variance = variances[0] / driver**2 + variances[1] / driven**2
        bias = nominal * (1.0 - creep.value) - 1.0
        samples = measurement.samples[:4] or (1.0,) * 4
        counts = (min(samples[:2]), *samples[2:])
        return (bias, variance, *creep, *measurement.torques, *variances[2:4], *counts)

    def _result(self) -> CalibrationResult:
        rows = np.array(self._rows)
        count = len(rows)
        if count < _FEWEST:
            return CalibrationResult(
                f"ratio not calibrated: {count} samples in {self._averaged:.3g} s, at least "
                f"{_FEWEST} are needed",
                samples=count,
            )
        mean = _average(rows[:, 0], rows[:, 1], rows[:, 8])
        creep = math.hypot(float(np.mean(rows[:, 2])), float(np.mean(rows[:, 3])))
        bias = Quantity(mean.value, math.hypot(mean.stddev, creep))
        if not bias.stddev <= self._accuracy:
            return CalibrationResult(
                f"ratio not calibrated: {count} samples give {bias.value:.2g} +/- "
                f"{bias.stddev:.2g}, wanted is +/- {self._accuracy:.2g}; turn faster",
                samples=count,
            )
        driver, driven = (_torque_offset(*rows[:, [at, at + 2, at + 5]].T) for at in (4, 5))
        text = f"ratio bias is {bias.value:.2g} +/- {bias.stddev:.2g}, of {count} samples"
        for name, offset in (("driver", driver), ("driven", driven)):
            if offset is not None:
                text += f"; {name} torque at no load {offset.value:.2g} +/- {offset.stddev:.2g} N m"
        return CalibrationResult(text, bias, driver, driven, count)


def _average(values: _Floats, variances: _Floats, samples: _Floats) -> Quantity:
    """Mean and its standard deviation, from stated variances and from scatter, the greater counts.

    Scatter is that of batches, so noise may be correlated for as long as a batch. Noise that does
    not show in the samples, such as rounding of a constant speed, does not average out. Values are
    means of so many `samples`, variances those of one.
    """
    stated = math.sqrt(float(np.mean(variances)))
    pooled = math.sqrt(float(np.mean(variances / samples)))
    batches = [float(np.mean(batch)) for batch in np.array_split(values, _BATCHES)]
    scatter = _STUDENT * float(np.std(batches, ddof=1)) / math.sqrt(_BATCHES)
    hidden = float(np.std(values)) < _SEEN * pooled
    stated = stated if hidden else pooled / math.sqrt(len(values))
    return Quantity(float(np.mean(values)), max(stated, scatter))


def _torque_offset(torques: _Floats, variances: _Floats, samples: _Floats) -> Quantity | None:
    there = np.isfinite(torques)
    if np.count_nonzero(there) < _FEWEST:
        return None
    return _average(torques[there], variances[there], samples[there])


def with_ratio_bias(components: Sequence[Component], bias: Quantity) -> list[Component]:
    """Put a calibrated ratio bias in the place of what each member of a Gaussian sum believes.

    It is not another measurement: the filter has seen the samples that it was made of. What else a
    member holds it holds for each value of the bias as before, so it follows the bias (a kf that
    was learned together with a wrong ratio is put right), and is as uncertain as the bias makes it.
    A member whose bias is farther off than its own and the result's deviations allow has been wrong
    in other ways as well; its other states stay, and no longer go with the bias. Weights stay.
    """
    return [_with_ratio_bias(component, bias) for component in components]


def _with_ratio_bias(component: Component, bias: Quantity) -> Component:
    at = Index.RATIO_BIAS
    mean, covariance = component.mean.copy(), component.covariance.copy()
    before, variance = float(mean[at]), float(covariance[at, at])
    far = abs(bias.value - before) > _FAR * math.hypot(math.sqrt(variance), bias.stddev)
    gain = np.zeros_like(mean) if far or variance <= 0.0 else covariance[:, at] / variance
    gain[at] = 1.0
    if far:
        covariance[at, :] = covariance[:, at] = 0.0
    else:
        covariance += (bias.stddev**2 - variance) * np.outer(gain, gain)
    mean += (bias.value - before) * gain
    covariance[at, :] = covariance[:, at] = bias.stddev**2 * gain
    return Component(component.log_weight, mean, covariance, component.changing)
