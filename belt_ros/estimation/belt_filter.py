"""The belt's filter: prior, noise, drift and measurements turned into mean and covariance.

A Gaussian sum of unscented filters over (ln tension, ln kf), see `gaussian_sum`, each in one of two
modes: traction is settled, or it is changing. Time comes in as the stamps of the measurements;
there is no clock here.
"""

import math

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation.ageing import aged
from belt_ros.estimation.assumptions import Drift, Prior, SensorNoise
from belt_ros.estimation.description import View
from belt_ros.estimation.estimate import LostTraction
from belt_ros.estimation.first_readings import FirstReadings
from belt_ros.estimation.foretold_slip import ForetoldSlip
from belt_ros.estimation.gaussian_sum import Component, narrowed
from belt_ros.estimation.load_cells import LoadCells
from belt_ros.estimation.load_following import LoadFollowing
from belt_ros.estimation.lull import Expected
from belt_ros.estimation.measurement import Measurement, Sensor
from belt_ros.estimation.modes import UNLIKELY, branched, due
from belt_ros.estimation.population import Population
from belt_ros.estimation.process import (
    CreepChange,
    UndevelopedCreep,
    drift_wander,
    gap_processes,
    prior_state,
    wear,
)
from belt_ros.estimation.readings import Readings
from belt_ros.estimation.recent import RecentSteps, Recorder
from belt_ros.estimation.sensing import Sensed, Sensing
from belt_ros.estimation.state import Index
from belt_ros.estimation.stepping import Stepping
from belt_ros.estimation.traction import Reference, lost_traction
from belt_ros.estimation.travel import travel_anew
from belt_ros.estimation.upkeep import MERGE_AXES, SPLIT_AXES, tended
from belt_ros.mechanics.constants import drive_constants
from belt_ros.mechanics.drive import BeltDrive

_Floats = NDArray[np.float64]
_WIDTHS = (0.45, 0.6)  # of a member to begin with, in prior standard deviations
_REDUCE_EVERY = 10  # updates ...
_REDUCE_AFTER = 0.2  # ... or so much time [s]
_READ_ABOVE = 1e-4  # weight below which a member no longer shows in what is read off
_CONTRADICTION = 50.0  # squared innovation of the travel above which positions are left out
_CALM = 0.02  # activity of the load below which it stays as it is
_SENSED = [Index.DRIVER_SPEED, Index.DRIVEN_SPEED, Index.DRIVER_TORQUE, Index.DRIVEN_TORQUE]
# Members of an enumeration are slow to look up.
_DRIVER_SPEED, _PULL, _TRAVEL = int(Index.DRIVER_SPEED), int(Index.PULL), int(Index.TRAVEL)
_TURN = 2.0 * math.pi
_SECONDS = 1e-9


class BeltFilter:
    """Bayesian filter of one belt drive.

    Parameters
    ----------
    drive : BeltDrive
        Geometry, belt and inertias; its kf and mu are used only as ratios between the pulleys.
    prior : Prior
    noise : SensorNoise
    drift : Drift
    turns : tuple of float
        One turn of either joint, seen at its pulley [rad].

    Attributes
    ----------
    prior_mean, prior_stddev : ndarray
        State (12,) before the first measurement, and its standard deviations.
    stamp_ns : int or None
        Stamp of the last measurement moved to [ns].
    surprises : ndarray
        Innovation squared over its variance, for each of the states in `seen`, of the last step.
    seen : ndarray
        States that the last measurement read.
    """

    def __init__(
        self,
        drive: BeltDrive,
        prior: Prior,
        noise: SensorNoise,
        drift: Drift,
        turns: tuple[float, float] = (_TURN, _TURN),
    ) -> None:
        self.stamp_ns: int | None = None
        self.constants = drive_constants(drive)
        self.prior_mean, self.prior_stddev = prior_state(prior, drive)
        self._tension_scale = prior.tension
        self._sensing = Sensing(self.constants, noise, turns)
        self._undeveloped = UndevelopedCreep(self.constants)
        self._load = LoadFollowing(self.constants)
        self._foretold = ForetoldSlip()
        self._load_cells = LoadCells(self._sensing)
        self._first = FirstReadings()
        self._recent = RecentSteps()
        self._population = Population(self.constants, self.prior_mean, self.prior_stddev)
        self._stepping = Stepping(self.constants, self._population, self._recent, self._load_cells)
        self.retune(noise, drift)
        self.surprises = np.zeros(0)
        self.seen = np.zeros(0, dtype=np.int64)
        self._updates = 0
        self._since_reduced = 0.0  # [s]
        self._since_branch = 0.0  # [s]
        self._activity = 1.0
        self._rested = 0.0  # [s] of the time since the last stamp, for which the belief has aged

    def retune(self, noise: SensorNoise, drift: Drift) -> None:
        """Go on with other noise and drift."""
        self.drift = drift
        self._sensing.retune(noise)
        self._wander = drift_wander(drift, self.prior_stddev, self._tension_scale)
        self._stepping.wander = self._wander

    @property
    def x(self) -> _Floats:
        """State (12,) in the order of `state.Index`: the mean."""
        return self._population.mean

    @property
    def covariance(self) -> _Floats:
        """Covariance of the state (12, 12)."""
        return self._population.covariance

    @property
    def members(self) -> int:
        """Number of Gaussians alive."""
        return len(self._population)

    @property
    def calm(self) -> bool:
        """Whether the load stays as it is, and so does traction, as far as can be told."""
        return self._activity < _CALM and self._population.changing <= UNLIKELY

    @property
    def creep_wander(self) -> float:
        """Wander of creep at a steady load, relative [1/sqrt(s)]."""
        return self._wander.creep

    @property
    def expected(self) -> Expected:
        """What speeds and torques are expected to be next, if nothing happens."""
        population = self._population
        return Expected(
            tuple(population.mean[_SENSED].tolist()),
            tuple(population.covariance[_SENSED, _SENSED].tolist()),
        )

    def start(self, measurement: Measurement, belief: list[Component] | None = None) -> bool:
        """Begin at the speeds and torques of `measurement`.

        What the belt is begins as `belief` has it, a Gaussian sum over the state, or at the prior.

        Returns
        -------
        bool
            False while a speed is unknown, from this measurement and those just before: nothing
            has begun yet.
        """
        first = self._first.gather(measurement)
        if first is None:
            return False
        whole = Component(0.0, self.prior_mean.copy(), np.diag(self.prior_stddev**2))
        self._cut()
        self._updates, self._since_reduced, self._since_branch = 0, 0.0, 0.0
        self._activity = 1.0
        self._begin_motion(first, self._narrowed(belief or [whole]))
        if self._recent.recorder is not None:
            self._recent.recorder.start(first.stamp_ns)
        return True

    def adopt_belief(self, belief: list[Component], *, in_hindsight: bool = False) -> None:
        """Go on from another belief over the state, such as after maintenance.

        `in_hindsight`: it is also what was known before, rather than the present belief.
        """
        if in_hindsight:
            self.conclude(belief)
        else:
            self._cut()
        self._population.adopt(self._narrowed(belief))
        self._population.summarise()
        if self._recent.recorder is not None and self.stamp_ns is not None:
            self._recent.recorder.start(self.stamp_ns)

    def aged(self, belief: list[Component], elapsed: float) -> list[Component]:
        """Return what has become of an earlier belief, `elapsed` [s] later; its motion stays."""
        processes = gap_processes(
            self._wander, self.constants, self.prior_stddev, elapsed, worn=elapsed
        )
        changes = self.drift.tension_changes * elapsed
        return aged(belief, processes, changes, self.prior_mean)

    def conclude(self, belief: list[Component]) -> None:
        """Let the recorder's chain of steps end at another belief than the present one."""
        self._recent.settle()
        if self._recent.recorder is not None and self.stamp_ns is not None:
            self._recent.recorder.cut(belief)
            self._recent.recorder.start(self.stamp_ns)

    def record(self, recorder: Recorder) -> None:
        """Tell `recorder` of all steps to come, some steps late."""
        self._cut()
        self._recent.recorder = recorder
        if self.stamp_ns is not None:
            recorder.start(self.stamp_ns)

    def finish(self) -> None:
        """Tell the recorder what it has not been told, after the last measurement."""
        self._cut()

    def _cut(self) -> None:
        """End the chain of steps at the present belief."""
        self._recent.settle()
        if self._recent.recorder is not None and self.members > 0:
            self._recent.recorder.cut(self.belief())

    def _narrowed(self, components: list[Component]) -> list[Component]:
        widths = [
            width * float(self.prior_stddev[axis])
            for axis, width in zip(SPLIT_AXES, _WIDTHS, strict=True)
        ]
        return narrowed(components, SPLIT_AXES, widths)

    def rest(self, elapsed: float) -> None:
        """Note that the belief is as of `elapsed` [s] later than it was, without any measurement.

        A gap then ages it by so much less.
        """
        self._rested += elapsed

    def keep_reading(self, measurement: Measurement) -> None:
        """Keep a measurement that may complete one from which the motion is begun anew."""
        self._first.keep(measurement)

    def resume(self, measurement: Measurement) -> bool:
        """Restart the motion at `measurement`, keeping what is known of the belt, aged by the gap.

        For a gap in the data, or a motion that the filter can no longer follow.

        Returns
        -------
        bool
            False while a speed is unknown, as in `start`: everything is as before.
        """
        assert self.stamp_ns is not None, "start() comes before resume()"
        first = self._first.gather(measurement)
        if first is None:
            return False
        self._recent.settle()
        gap = max((first.stamp_ns - self.stamp_ns) * _SECONDS - self._rested, 0.0)
        worn = wear(gap)
        processes = gap_processes(self._wander, self.constants, self.prior_stddev, gap, worn)
        self._since_branch += worn  # traction may have changed meanwhile
        if self._recent.recorder is not None:
            self._recent.recorder.fade(first.stamp_ns, self._population.members(), processes)
        self._population.fade(processes)
        self._begin_motion(first, self.belief())
        return True

    def _begin_motion(self, measurement: Measurement, components: list[Component]) -> None:
        self._sensing.start()
        sensed = self._sensing.sense(measurement, 0.0)
        for component in components:
            for at in range(2):  # the speeds
                component.mean[at] = sensed.z[at]
                component.covariance[at, :] = component.covariance[:, at] = 0.0
                component.covariance[at, at] = sensed.variance[at]
        self._population.adopt(components)
        self._population.update(sensed.part(2, None))
        self.stamp_ns = measurement.stamp_ns
        self._rested = 0.0
        self._load.start()
        self._foretold.start()
        self._population.summarise()
        self._load_cells.take_in(self._population, sensed)
        self._undeveloped.start(float(self.x[_PULL]))

    def predict(self, measurement: Measurement) -> float:
        """Advance to `measurement` without taking it in.

        Returns
        -------
        float
            Its normalised innovation squared per degree of freedom, for the member it suits best.
        """
        assert self.stamp_ns is not None, "start() comes before predict()"
        dt = (measurement.stamp_ns - self.stamp_ns) * _SECONDS
        counted = self._sensing.counts_travel
        sensed = self._sensing.sense(measurement, dt)
        activity = self._load.follow(
            sensed, self.x, self._wander, dt, unforeseen=self._foretold.failed
        )
        self._activity = activity.most
        self._stepping.rewind(activity)
        undeveloped = self._follow_creep(dt)
        step = self._stepping.step(measurement.stamp_ns, dt, sensed, undeveloped, activity)
        self.seen, self.surprises = self._stepping.seen, self._stepping.surprises
        if self._travel_contradicts():
            contradiction = self.surprises[-1]
            self._sensing.lose_travel()
            sensed = sensed.part(0, -1)
            self._population.go_back(step.before)
            step = self._stepping.step(measurement.stamp_ns, dt, sensed, undeveloped, activity)
            # for who judges the sensors
            self.seen = np.append(self._stepping.seen, _TRAVEL)
            self.surprises = np.append(self._stepping.surprises, contradiction)
        self._foretold.compare(self._stepping.lead, dt)
        self._recent.append(step)
        if self._sensing.counts_travel and not counted:
            self._begin_travel(measurement.stamp_ns, sensed)
        self._sensed = sensed
        self.stamp_ns = measurement.stamp_ns
        self._rested = 0.0
        self._since_branch += dt
        self._since_reduced += dt
        return self._population.least / max(len(sensed.z), 1)

    def _travel_contradicts(self) -> bool:
        """Whether positions say what speeds cannot be reconciled with: a jump, or a wrong sign."""
        told = self._sensing.counts_travel and self.seen.size > 0 and self.seen[-1] == _TRAVEL
        return bool(told and self.surprises[-1] > _CONTRADICTION)

    def _begin_travel(self, stamp_ns: int, sensed: Sensed) -> None:
        """Count rim travel from here; steps before cannot be repeated with it."""
        self._recent.settle()
        driver, driven = sensed.variances[Sensor.DRIVER_POSITION : Sensor.DRIVEN_POSITION + 1]
        anew = travel_anew(self.constants, (float(driver), float(driven)))
        if self._recent.recorder is not None:
            self._recent.recorder.fade(stamp_ns, self._population.members(), (anew, anew))
        self._population.fade((anew, anew))

    def _follow_creep(self, dt: float) -> CreepChange:
        speed = abs(float(self.x[_DRIVER_SPEED])) * self.constants.driver_radius
        pull, slip_per_pull = float(self.x[_PULL]), self._load.slip_per_pull
        return self._undeveloped.advance(pull, slip_per_pull, speed, dt)

    def disregard(self) -> None:
        """Stay where `predict` has led, but by nothing of its measurement, which is not believed.

        Not even by where that has made the model straight, see `torque_told`.
        """
        if (step := self._recent.take_back()) is not None:
            self._recent.append(self._stepping.unread(step))

    def update(self) -> tuple[float, int]:
        """Take in the measurement that the filter was advanced to by `predict`.

        Returns
        -------
        tuple of float and int
            Normalised innovation squared, averaged over the members, and its degrees of freedom.
        """
        squared = self._population.average
        self._stepping.take_in(self._sensed)
        self._recent.take_in()
        self._updates += 1
        if self._updates >= _REDUCE_EVERY or self._since_reduced >= _REDUCE_AFTER:
            self._reduce()
            self._population.summarise()
            self._updates, self._since_reduced = 0, 0.0
        return squared, len(self._sensed.z)

    def _reduce(self) -> None:
        """Drop and merge members, split those that have become wide; let some change modes."""
        components = tended(self.belief())
        if due(components, self._since_branch):
            begin_rate = self.drift.tension_changes
            components, came_from = branched(components, self._since_branch, begin_rate, MERGE_AXES)
            self._recent.switch(components, came_from)
            self._since_branch = 0.0
        self._population.adopt(components)

    def view(self, slowest: float) -> View:
        """Look at what is known; read off by unscented transform of every member that counts.

        `slowest` is the rim speed [m/s] below which slip is referred to it.
        """
        population = self._population
        shown = np.flatnonzero(population.weights >= _READ_ABOVE)
        weights = population.weights[shown]
        readings = Readings(weights / weights.sum(), *population.read(shown, slowest))
        members = population.weights, population.means, population.covariances
        return View(*members, (population.mean, population.covariance), readings)

    def lost_traction(self, reference: Reference) -> LostTraction:
        """Probabilities that traction has been lost since a reference, and to what."""
        population = self._population
        return lost_traction(
            population.weights, population.means, population.covariances, reference
        )

    def belief(self) -> list[Component]:
        """Return what is known, as a Gaussian sum over the state."""
        return self._population.components()
