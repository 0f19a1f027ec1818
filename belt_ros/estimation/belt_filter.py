"""The belt's filter: prior, noise, drift and measurements turned into mean and covariance.

A Gaussian sum of unscented filters over (ln tension, ln kf), see `gaussian_sum`, each in one of two
modes: traction is settled, or it is changing. Time comes in as the stamps of the measurements;
there is no clock here.
"""

import math

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation.assumptions import Drift, Prior, SensorNoise
from belt_ros.estimation.bank import UnscentedBank
from belt_ros.estimation.estimate import LostTraction
from belt_ros.estimation.gaussian_sum import (
    Component,
    mixture_moments,
    narrowed,
    normalised,
    reduced,
)
from belt_ros.estimation.load import LoadWander
from belt_ros.estimation.measurement import Measurement
from belt_ros.estimation.process import (
    CreepChange,
    Process,
    UndevelopedCreep,
    drift_processes,
    drift_wander,
    prior_state,
)
from belt_ros.estimation.readings import Readings
from belt_ros.estimation.recent import RecentSteps, Recorder, Step
from belt_ros.estimation.sensing import NO_LOADS, Sensed, Sensing
from belt_ros.estimation.smoother import Members, Moved
from belt_ros.estimation.state import STATES, Index
from belt_ros.estimation.traction import Reference, lost_traction
from belt_ros.mechanics.constants import drive_constants
from belt_ros.mechanics.drive import BeltDrive

_Floats = NDArray[np.float64]
_BELT = slice(Index.LOG_TENSION, Index.TRAVEL)
SPLIT_AXES = (Index.LOG_TENSION, Index.LOG_STIFFNESS)
_WIDTHS = (0.45, 0.6)  # of a member to begin with, in prior standard deviations
_FRICTION_WIDTH = 0.2  # of a member in ln mu, once that has become uncertain ...
_MOST_BY_FRICTION = 32  # ... while there are no more members than this
MERGE_AXES = (*SPLIT_AXES, Index.LOG_FRICTION)
_REDUCE_EVERY = 10  # updates
_BRANCH_EVERY = 1.0  # [s]
_BRANCHES = 6  # members that change modes then, for all of their mode
_CHANGE_END_RATE = 0.5  # at which a change of traction ends [1/s]
_READ_ABOVE = 1e-4  # weight below which a member no longer shows in what is read off
_SURPRISE = 9.0  # innovation squared per degree of freedom at which the load must have jumped
_CONTRADICTION = 50.0  # squared innovation of the travel above which positions are left out
_WILD = 25.0  # squared innovation of a load, for every member, that is not believed ...
_REFUSED_AT_MOST = 3  # ... in a row
_JUMPING = np.ones(2)  # activity of the load
_SLOW = 0.1  # rim speed [m/s] below which the slip's wander no longer shrinks with it
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
    x, covariance : ndarray
        State (12,) in the order of `state.Index`, and its covariance (12, 12).
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
        self.retune(noise, drift)
        self._undeveloped = UndevelopedCreep(self.constants)
        self._load = LoadWander()
        self._recent = RecentSteps()
        self._bank = UnscentedBank(self.constants, self.prior_mean)
        self._changing = np.zeros(0, dtype=np.int64)
        self._log_weights = np.zeros(0)
        self._squared = np.zeros(0)
        self.surprises = np.zeros(0)
        self.seen = np.zeros(0, dtype=np.int64)
        self._loads_refused = 0
        self._updates = 0
        self._since_branch = 0.0
        self.x = self.prior_mean
        self.covariance = np.diag(self.prior_stddev**2)

    def retune(self, noise: SensorNoise, drift: Drift) -> None:
        """Go on with other noise and drift."""
        self.drift = drift
        self._sensing.retune(noise)
        self._wander = drift_wander(drift, self.prior_stddev, self._tension_scale, self.constants)

    @property
    def members(self) -> int:
        """Number of Gaussians alive."""
        return len(self._bank)

    def start(self, measurement: Measurement, belief: list[Component] | None = None) -> None:
        """Begin at the speeds and torques of `measurement`.

        What the belt is begins as `belief` has it, a Gaussian sum over the state, or at the prior.
        """
        whole = Component(0.0, self.prior_mean.copy(), np.diag(self.prior_stddev**2))
        self._cut()
        self._updates, self._since_branch = 0, 0.0
        self._begin_motion(measurement, self._narrowed(belief or [whole]))
        if self._recent.recorder is not None:
            self._recent.recorder.start(measurement.stamp_ns)

    def adopt_belief(self, belief: list[Component]) -> None:
        """Go on from another belief over the state, such as after maintenance."""
        self._cut()
        self._adopt(self._narrowed(belief))
        self._summarise()
        if self._recent.recorder is not None and self.stamp_ns is not None:
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

    def resume(self, measurement: Measurement) -> None:
        """Restart the motion at `measurement`, keeping what is known of the belt, aged by the gap.

        For a gap in the data, or a motion that the filter can no longer follow.
        """
        assert self.stamp_ns is not None, "start() comes before resume()"
        self._recent.settle()
        gap = max(measurement.stamp_ns - self.stamp_ns, 0) * _SECONDS
        renewed = [self._renewed(process) for process in self._gap_processes(gap)]
        if self._recent.recorder is not None:
            stamp_ns = measurement.stamp_ns
            self._recent.recorder.fade(stamp_ns, self._members(), (renewed[0], renewed[1]))
        self._bank.fade((renewed[0], renewed[1]), self._changing)
        self._begin_motion(measurement, self.belief())

    def _gap_processes(self, gap: float) -> tuple[Process, Process]:
        undeveloped = 1.0, float(self.prior_stddev[Index.UNDEVELOPED]), 0.0
        return drift_processes(self._wander, self.constants, _JUMPING, undeveloped, gap)

    def _renewed(self, process: Process) -> Process:
        """Let all that moves begin anew at its prior."""
        memory, variance = process.memory.copy(), process.variance_before.copy()
        moving = np.ones(STATES, dtype=np.bool_)
        moving[_BELT] = False
        memory[moving] = 0.0
        variance[moving] = self.prior_stddev[moving] ** 2
        return Process(memory, variance, process.variance_after)

    def _begin_motion(self, measurement: Measurement, components: list[Component]) -> None:
        self._sensing.start()
        sensed = self._sensing.sense(measurement, 0.0)
        for component in components:
            for at in range(2):  # the speeds
                component.mean[at] = sensed.z[at]
                component.covariance[at, :] = component.covariance[:, at] = 0.0
                component.covariance[at, at] = sensed.variance[at]
        self._adopt(components)
        self._bank.update(sensed.z[2:], sensed.variance[2:], sensed.places[2:])
        self.stamp_ns = measurement.stamp_ns
        self._load.start()
        self._summarise()
        self._take_in_loads(sensed)
        self._summarise()
        self._undeveloped.start(float(self.x[Index.PULL]))

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
        activity = self._follow_load(sensed, dt)
        self._rewind(activity)
        undeveloped = self._follow_creep(dt)
        step = self._stepped(measurement.stamp_ns, dt, sensed, undeveloped, activity)
        if self._travel_contradicts():
            contradiction = self.surprises[-1]
            sensed = self._without_travel(sensed)
            self._bank.x, self._bank.P = step.before.means, step.before.covariances
            step = self._stepped(measurement.stamp_ns, dt, sensed, undeveloped, activity)
            self.seen = np.append(self.seen, Index.TRAVEL)  # for who judges the sensors
            self.surprises = np.append(self.surprises, contradiction)
        self._recent.append(step)
        if self._sensing.counts_travel and not counted:
            self._begin_travel(measurement.stamp_ns, sensed)
        self._sensed = sensed
        self.stamp_ns = measurement.stamp_ns
        self._since_branch += dt
        return float(np.min(self._squared)) / len(sensed.z)

    def _stepped(
        self,
        stamp_ns: int,
        dt: float,
        sensed: Sensed,
        undeveloped: CreepChange,
        activity: _Floats,
    ) -> Step:
        step = self._moved(stamp_ns, dt, sensed, undeveloped, activity)
        if np.min(self._squared) > _SURPRISE * len(sensed.z):
            # The load has jumped. Taken in as if it had not, it would be blamed on the belt.
            self._bank.x, self._bank.P = step.before.means, step.before.covariances
            activity = np.maximum(activity, _JUMPING)
            step = self._moved(stamp_ns, dt, sensed, undeveloped, activity)
        return step

    def _moved(
        self,
        stamp_ns: int,
        dt: float,
        sensed: Sensed,
        undeveloped: CreepChange,
        activity: _Floats,
    ) -> Step:
        """Move every member by `dt`, as its mode has it, and compare it with what was sensed."""
        before = self._members()
        processes = drift_processes(self._wander, self.constants, activity, undeveloped, dt)
        crosses = self._bank.predict(
            dt, processes, self._changing, crosses=self._recent.recorder is not None
        )
        self._squared, self.surprises = self._bank.innovations_squared(
            self._weights, sensed.z, sensed.variance, sensed.places
        )
        self.seen = sensed.places
        moved = Moved(self._bank.x, self._bank.P, crosses)
        calm = float(activity[0]), float(activity[1])
        return Step(stamp_ns, dt, before, sensed, undeveloped, activity, calm, processes, moved)

    def _rewind(self, activity: _Floats) -> None:
        """Repeat the last steps with the load's present activity, if it was taken for calmer.

        That a load has begun to move shows some steps later; until then, the belt is blamed.
        """
        again = self._recent.taken_too_calm(np.minimum(activity, 1.0))
        if not again:
            return
        members = again[0].before
        self._log_weights, self._changing = members.log_weights, members.changing
        self._bank.x, self._bank.P = members.means, members.covariances
        self._weights = normalised(self._log_weights)
        for step in again:
            moving = np.maximum(step.activity, np.minimum(activity, 1.0))
            repeated = self._moved(step.stamp_ns, step.dt, step.sensed, step.undeveloped, moving)
            self._recent.append(repeated._replace(taken_in=step.taken_in))
            if step.taken_in:
                self._take_in(step.sensed)
        self._summarise()

    def _travel_contradicts(self) -> bool:
        """Whether positions say what speeds cannot be reconciled with: a jump, or a wrong sign."""
        return self.seen[-1] == Index.TRAVEL and float(self.surprises[-1]) > _CONTRADICTION

    def _without_travel(self, sensed: Sensed) -> Sensed:
        """Leave positions out, and count travel anew from the next measurement on."""
        self._sensing.lose_travel()
        return sensed._replace(
            z=sensed.z[:-1], variance=sensed.variance[:-1], places=sensed.places[:-1]
        )

    def _drop_broken(self) -> None:
        """Drop members that are not finite: the last guard, against readings beyond all reason."""
        sound = np.isfinite(self._log_weights)
        sound &= np.all(np.isfinite(self._bank.x), axis=1)
        sound &= np.all(np.isfinite(self._bank.P), axis=(1, 2))
        if not np.any(sound):
            raise FloatingPointError("no member of the filter is finite any more")
        self._bank.x, self._bank.P = self._bank.x[sound], self._bank.P[sound]
        self._log_weights, self._changing = self._log_weights[sound], self._changing[sound]

    def _begin_travel(self, stamp_ns: int, sensed: Sensed) -> None:
        """Count rim travel from here; steps before cannot be repeated with it."""
        c, r = self.constants, sensed.variances
        self._recent.settle()
        memory, variance = np.ones(STATES), np.zeros(STATES)
        memory[Index.TRAVEL] = 0.0
        variance[Index.TRAVEL] = c.driver_radius**2 * r[4] + c.driven_radius**2 * r[5]
        anew = Process(memory, variance, np.zeros(STATES))
        if self._recent.recorder is not None:
            self._recent.recorder.fade(stamp_ns, self._members(), (anew, anew))
        self._bank.fade((anew, anew), self._changing)

    def _follow_load(self, sensed: Sensed, dt: float) -> _Floats:
        """Wander of both torques, relative to the greatest."""
        c, v, r = self.constants, sensed.values, sensed.variances
        ahead = c.driver_radius * v[0] - c.driven_radius * v[1]
        noise = c.driver_radius**2 * r[0] + c.driven_radius**2 * r[1]
        speed = max(c.driver_radius * abs(float(self.x[Index.DRIVER_SPEED])), _SLOW)
        strain = speed * self._wander.torque / (c.driver_radius * c.axial_stiffness)
        return self._load.follow(
            np.array((v[2], v[3], ahead)),
            np.array((r[2], r[3], noise)),
            np.array((self._wander.torque, self._wander.torque, strain)),
            np.array((0.0, 0.0, self._wander.creep * abs(ahead))),
            dt,
        )

    def _follow_creep(self, dt: float) -> CreepChange:
        speed = abs(float(self.x[Index.DRIVER_SPEED])) * self.constants.driver_radius
        return self._undeveloped.advance(float(self.x[Index.PULL]), speed, dt)

    def update(self) -> tuple[float, int]:
        """Take in the measurement that the filter was advanced to by `predict`.

        Returns
        -------
        tuple of float and int
            Normalised innovation squared, averaged over the members, and its degrees of freedom.
        """
        squared = float(self._weights @ self._squared)
        self._take_in(self._sensed)
        self._recent.take_in()
        self._updates += 1
        if self._updates % _REDUCE_EVERY == 0:
            self._reduce()
        self._summarise()
        return squared, len(self._sensed.z)

    def _take_in(self, sensed: Sensed) -> None:
        self._bank.update(sensed.z, sensed.variance, sensed.places)
        self._weigh(self._squared)
        self._take_in_loads(sensed)

    def _take_in_loads(self, sensed: Sensed) -> None:
        """Take in hub loads and span tension, which depend on the state by the mechanics."""
        if sensed.loads is NO_LOADS:
            return
        for load in np.flatnonzero(~np.isnan(sensed.loads)).tolist():
            before = self._bank.x, self._bank.P
            innovation, variance = self._bank.observe_load(
                load, float(sensed.loads[load]), float(sensed.load_variances[load])
            )
            if np.min(innovation**2 / variance) > _WILD and self._loads_refused < _REFUSED_AT_MOST:
                self._bank.x, self._bank.P = before
                self._loads_refused += 1
                self._sensing.ask_for_loads()
                continue
            self._loads_refused = 0
            self._weigh(innovation**2 / float(self._weights @ variance))

    def _weigh(self, squared: _Floats) -> None:
        self._log_weights = self._log_weights - 0.5 * squared
        self._log_weights -= np.max(self._log_weights)
        self._weights = normalised(self._log_weights)

    def _reduce(self) -> None:
        """Drop and merge members; now and then let some begin, or end, a change of traction.

        A member in which traction is changing gives every loss of it a hypothesis to be explained
        by, before slower quantities are bent to explain it.
        """
        components = narrowed(
            reduced(self.belief(), MERGE_AXES),
            (Index.LOG_FRICTION,),
            (_FRICTION_WIDTH,),
            _MOST_BY_FRICTION,
        )
        best = max(components, key=lambda component: component.log_weight)
        alone = all(component.changing is best.changing for component in components)
        if alone or self._since_branch >= _BRANCH_EVERY:
            begun = self.drift.tension_changes * self._since_branch
            ended = _CHANGE_END_RATE * self._since_branch
            leaving = math.log(-math.expm1(-(ended if best.changing else begun)))
            branches = self._branches(components, changing=best.changing, log_share=leaving)
            came_from = [component.changing for component in components]
            came_from += [best.changing] * len(branches)
            for component in components:
                component.log_weight -= ended if component.changing else begun
            components += branches
            self._recent.switch(components, came_from)
            self._since_branch = 0.0
        self._adopt(components)

    @staticmethod
    def _branches(
        components: list[Component], *, changing: bool, log_share: float
    ) -> list[Component]:
        """Return the share of a mode that changes into the other, at its heaviest members."""
        mode = sorted(
            (c for c in components if c.changing is changing), key=lambda c: -c.log_weight
        )
        weights = [c.log_weight for c in mode]
        heaviest = np.logaddexp.reduce(weights[:_BRANCHES])
        scale = log_share + float(np.logaddexp.reduce(weights) - heaviest)
        return [
            Component(c.log_weight + scale, c.mean, c.covariance, not changing)
            for c in mode[:_BRANCHES]
        ]

    def readings(self, slowest: float) -> Readings:
        """Read off what `state.Reading` lists, by unscented transform of every member that counts.

        `slowest` is the rim speed [m/s] below which slip is referred to it.
        """
        shown = np.flatnonzero(self._weights >= _READ_ABOVE)
        weights = self._weights[shown]
        return Readings(weights / np.sum(weights), *self._bank.read(shown, slowest))

    def lost_traction(self, reference: Reference) -> LostTraction:
        """Probabilities that traction has been lost since a reference, and to what."""
        return lost_traction(self._weights, self._bank.x, self._bank.P, reference)

    def belief(self) -> list[Component]:
        """Return what is known, as a Gaussian sum over the state."""
        return [
            Component(float(log_weight), x.copy(), covariance.copy(), bool(changing))
            for log_weight, x, covariance, changing in zip(
                self._log_weights, self._bank.x, self._bank.P, self._changing, strict=True
            )
        ]

    def _members(self) -> Members:
        return Members(self._log_weights, self._changing, self._bank.x, self._bank.P)

    def _adopt(self, components: list[Component]) -> None:
        """Make `components` the members."""
        self._bank.x = np.stack([component.mean for component in components])
        self._bank.P = np.stack([component.covariance for component in components])
        self._changing = np.array([component.changing for component in components], dtype=np.int64)
        self._log_weights = np.array([component.log_weight for component in components])

    def _summarise(self) -> None:
        """Set `x` and `covariance` to those of the sum.

        Raises
        ------
        FloatingPointError
            If no member is finite any more.
        """
        if not math.isfinite(float(np.sum(self._log_weights) + np.sum(self._bank.x))):
            self._drop_broken()
        self._weights = normalised(self._log_weights)
        self.x, self.covariance = mixture_moments(self._weights, self._bank.x, self._bank.P)
