"""Signs that a sensor, or what the estimator makes of it, is not to be believed.

A belt that slips is explained by the model, however badly it slips: pull and slip are then those of
gross slip, and measurements agree with each other. What is none of the belt's doing mostly shows in
one of four ways within a second; what does not, makes the estimator lost:

* measurements are turned away: infinite, out of range, statistically impossible;
* a sensor's readings are not those that the others let expect, sample after sample;
* the pulleys turn against each other;
* slip is against the power: the belt seems to be faster where it is pulled from.
"""

import math

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation.alarm_settings import AlarmSettings
from belt_ros.estimation.assumptions import SensorLimits
from belt_ros.estimation.condition import Evidence, judged
from belt_ros.estimation.estimate import BeltEstimate, Phase, Quantity, probability_below
from belt_ros.estimation.measurement import Measurement, Rejection, Sensor
from belt_ros.estimation.refusals import Refusals
from belt_ros.estimation.state import STATES, Index
from belt_ros.mechanics._compile import compiled

_Floats = NDArray[np.float64]
_Places = NDArray[np.int64]

_NAMES = {
    Index.DRIVER_SPEED: "driver speed",
    Index.DRIVEN_SPEED: "driven speed",
    Index.DRIVER_TORQUE: "driver torque",
    Index.DRIVEN_TORQUE: "driven torque",
    Index.TRAVEL: "positions",
}
_MEMORY = 0.5  # [s] ...
_FEWEST = 5.0  # ... and samples at the least: no single one makes a verdict
_CLIP = 10.828  # squared surprise that one in a thousand exceeds
_IMPOSSIBLE = (Rejection.NOT_FINITE, Rejection.OUT_OF_RANGE, Rejection.GATED)
_FLICKER = 0.8  # of the greatest share refused: above it, one that was beyond it still is
_FADING = 0.25  # pace at which a sensor that is not seen is forgotten
_HALF = 0.5  # of a threshold: below it a sign is gone
_OPPOSED = 0.1  # speed of the slower pulley over the faster one's, if they turn against each other
_SUSTAINED = 0.1  # [s] for which slip may be against the power before that says anything
_KNOWN_SIGN = 3.0  # deviations of the torque from 0 at which its sign is known
_SECONDS = 1e-9


@compiled
def _forget_and_add(means: _Floats, seen: _Places, squared: _Floats, share: float) -> int:
    """Let forgetting means follow the squares of those that are seen; return where it is greatest.

    Those that are not seen go back to 1, what they should be, but slowly: positions that contradict
    the speeds are taken up anew, and then left out of every other step. NaN: never seen.
    """
    fading = _FADING * share
    for i in range(means.shape[0]):
        means[i] -= fading * (means[i] - 1.0)
    for i in range(seen.shape[0]):
        square = min(squared[i], _CLIP)
        if square >= 0.0:
            before = means[seen[i]]
            mean = 1.0 if math.isnan(before) else 1.0 + (before - 1.0) / (1.0 - fading)
            means[seen[i]] = mean + share * (square - mean)
    worst = 0
    for i in range(means.shape[0]):
        if means[i] > means[worst] or math.isnan(means[worst]):
            worst = i
    return worst


def _share(dt: float) -> float:
    """Weight of a sample `dt` [s] after the one before."""
    return min(-math.expm1(-dt / _MEMORY), 1.0 / _FEWEST)


def slip_along_power(estimate: BeltEstimate, beyond: Quantity) -> Quantity:
    """Return the slip beyond creep [-], positive where it is lost on the way that power takes.

    That is the only way in which a belt can slip. Where the torque is too small to tell the way,
    the excess is taken as such.
    """
    torque = estimate.transmitted_torque
    if abs(torque.value) < _KNOWN_SIGN * torque.stddev:
        return Quantity(abs(beyond.value), beyond.stddev)
    along = math.copysign(1.0, torque.value * estimate.driver_speed.value)
    return Quantity(along * beyond.value, beyond.stddev)


def _against_power(estimate: BeltEstimate, beyond: Quantity, settings: AlarmSettings) -> float:
    """Probability that the belt slips against the power, farther off creep than may be tolerated.

    Slip `beyond` creep that is against the power does not say so: a belt may creep less than is
    foretold, while creep develops or where it was taken to be nearer to its knee than it is.
    """
    excess = slip_along_power(estimate, beyond)
    if excess.value >= 0.0:
        return 0.0
    whole = Quantity(beyond.value + estimate.predicted_creep.value, beyond.stddev)
    slip = slip_along_power(estimate, whole)
    far = probability_below(excess, -settings.excess_slip_warning)
    return min(far, probability_below(slip, 0.0))


class SensorWatch:
    """Collects such signs, of one drive."""

    def __init__(self) -> None:
        self._misfits = np.full(STATES, math.nan)  # by the state that is read
        self._worst = Index.DRIVER_SPEED
        self._worst_misfit = 1.0
        self._refusals = Refusals()
        self._many_refused = False
        self._refused_sensor: Sensor | None = None
        self._opposed = False
        self._contrary = Evidence.GONE
        self._contrary_for = 0.0  # [s] for which it may have been
        self._stamp_ns: int | None = None  # of what was accepted last

    @property
    def refused(self) -> float:
        """Share of the last measurements that were turned away as impossible."""
        return self._refusals.share

    def contradicts(self, *, doubted: bool) -> bool:
        """Whether the belt seems to slip against the power, which no belt can.

        For a sample or two it may seem so while the load or the rotation changes fast, so it has to
        last, unless sensors are `doubted` already.
        """
        lasts = doubted or self._contrary_for >= _SUSTAINED
        return lasts and self._contrary is Evidence.MET

    def see(self, seen: _Places, surprises: _Floats, dt: float) -> None:
        """Take in the surprises of a measurement, `dt` [s] after the one before.

        Parameters
        ----------
        seen : ndarray of int
            States that were read (k,), in the order of `state.Index`.
        surprises : ndarray
            Squares of their innovations (k,), each over its own variance.
        dt : float
        """
        share = _share(max(dt, 0.0))
        self._worst = Index(_forget_and_add(self._misfits, seen, surprises, share))
        worst = float(self._misfits[self._worst])
        self._worst_misfit = 1.0 if math.isnan(worst) else worst

    def accept(
        self, estimate: BeltEstimate, beyond: Quantity, settings: AlarmSettings, pooled: int = 1
    ) -> None:
        """Take in what came of so many measurements, and the slip `beyond` creep and winding up."""
        before, self._stamp_ns = self._stamp_ns, estimate.stamp_ns
        self._count(estimate.stamp_ns, settings, pooled, refused=False)
        moving = estimate.phase not in (Phase.STANDSTILL, Phase.UNKNOWN)
        self._opposed = moving and _opposed(estimate)
        contrary = Evidence.GONE
        if moving and (against := _against_power(estimate, beyond, settings)) > 0.0:
            contrary = judged(against, settings.confidence, settings.clear_confidence)
        dt = 0.0 if before is None else max(estimate.stamp_ns - before, 0) * _SECONDS
        self._contrary_for = 0.0 if contrary is Evidence.GONE else self._contrary_for + dt
        passing = contrary is Evidence.UNDECIDED and self._contrary_for < _SUSTAINED
        self._contrary = Evidence.GONE if passing else contrary

    def refuse(
        self,
        reason: Rejection,
        measurement: Measurement | None,
        limits: SensorLimits,
        settings: AlarmSettings,
    ) -> int | None:
        """Take in that a measurement was turned away; return its stamp [ns] if that is credible."""
        newest_ns = self._refusals.newest_ns
        if reason not in _IMPOSSIBLE or measurement is None or newest_ns is None:
            return None
        since = (measurement.stamp_ns - newest_ns) * _SECONDS
        if not 0.0 < since <= limits.greatest_gap:
            return None
        self._count(measurement.stamp_ns, settings, measurement.pooled, refused=True)
        self._refused_sensor = impossible_reading(measurement, limits)
        return measurement.stamp_ns

    def _count(self, stamp_ns: int, settings: AlarmSettings, number: int, *, refused: bool) -> None:
        self._refusals.count(stamp_ns, number, refused=refused)
        many = settings.implausible_rejections
        self._many_refused = self.refused >= (_FLICKER * many if self._many_refused else many)

    def evidence(self, settings: AlarmSettings) -> Evidence:
        """Return whether a sensor is implausible now."""
        if self._many_refused:
            return Evidence.MET
        misfit = self.misfit_evidence(settings)
        some_refused = self.refused >= _HALF * settings.implausible_rejections
        return Evidence.UNDECIDED if some_refused and misfit is Evidence.GONE else misfit

    def misfit_evidence(self, settings: AlarmSettings) -> Evidence:
        """Return the same by what was taken in, rather than by what was turned away."""
        misfit = settings.implausible_misfit
        if self._opposed or self._contrary is Evidence.MET or self._worst_misfit >= misfit:
            return Evidence.MET
        return Evidence.UNDECIDED if self._worst_misfit >= _HALF * misfit else self._contrary

    def reason(self, settings: AlarmSettings) -> str:
        """Say in words what is implausible, and what to look at."""
        if self._opposed:
            return (
                "the pulleys seem to turn against each other: check the sign of their sensors "
                "(driver.sign, driven.sign)"
            )
        if self.refused >= _HALF * settings.implausible_rejections:
            at = "" if self._refused_sensor is None else f", {_words(self._refused_sensor)}"
            return (
                f"{100.0 * self.refused:.0f} % of the measurements are impossible{at}: check the "
                "sensors, their wiring and units"
            )
        if self._worst_misfit >= _HALF * settings.implausible_misfit:
            sensor = _NAMES[self._worst]
            return (
                f"what is measured does not fit together, which shows in the {sensor}: check for "
                "a sensor that is stuck, late or of the wrong sign or scale"
            )
        if self._contrary is not Evidence.GONE:
            return (
                "the belt seems to slip against the power it transmits: check for a speed sensor "
                "that is stuck, and the signs of the torques"
            )
        return "its readings fit again"


def _opposed(estimate: BeltEstimate) -> bool:
    """Whether the pulleys surely turn against each other."""
    driver, driven = estimate.driver_speed, estimate.driven_speed
    if driver.value * driven.value >= 0.0:
        return False
    slower = min(abs(driver.value), abs(driven.value))
    faster = max(abs(driver.value), abs(driven.value))
    return slower > _OPPOSED * faster


def impossible_reading(measurement: Measurement, limits: SensorLimits) -> Sensor | None:
    """Return the first reading that is infinite or out of range, or a speed if both are missing."""
    m = measurement
    largest = (
        *(limits.greatest_speed,) * 2,
        *(limits.greatest_torque,) * 2,
        *(math.inf,) * 2,
        *(limits.greatest_load,) * 3,
    )
    readings = (*m.speeds, *m.torques, *m.positions, *m.loads)
    for sensor, reading, limit in zip(Sensor, readings, largest, strict=True):
        if math.isinf(reading) or abs(reading) > limit:
            return sensor
    return Sensor.DRIVER_SPEED if all(map(math.isnan, m.speeds)) else None


def _words(sensor: Sensor) -> str:
    return sensor.name.lower().replace("_", " ")
