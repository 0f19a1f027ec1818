"""One step of the filter: members moved, compared with what was sensed, repeated if need be.

How lively the load is decides what a difference is blamed on. A jump shows at once, and its step is
repeated before anything is taken in. That a slow change has begun shows some steps later, and those
are taken back and repeated.
"""

import math

import numpy as np

from belt_ros.estimation.load import Activity
from belt_ros.estimation.load_cells import LoadCells
from belt_ros.estimation.population import Population
from belt_ros.estimation.process import CreepChange, Wander, drift_processes
from belt_ros.estimation.recent import RecentSteps, Step
from belt_ros.estimation.sensing import Sensed
from belt_ros.estimation.smoother import Moved
from belt_ros.mechanics.constants import DriveConstants

# Innovation squared at which the load must have jumped, by its degrees of freedom: about as
# improbable for one as for four.
_SURPRISE = (math.inf, 26.3, 30.1, 33.2, 36.0, 45.0)


class Stepping:
    """Move a population from measurement to measurement.

    Parameters
    ----------
    constants : DriveConstants
    population : Population
    recent : RecentSteps
        The steps that may have to be repeated.
    load_cells : LoadCells

    Attributes
    ----------
    wander : Wander
        To be set before the first step.
    surprises, seen : ndarray
        Of the last step: innovation squared over its variance, for each of the states seen.
    lead : float
        Of the last step, see `foretold_slip.lead_innovation`.
    """

    wander: Wander

    def __init__(
        self,
        constants: DriveConstants,
        population: Population,
        recent: RecentSteps,
        load_cells: LoadCells,
    ) -> None:
        self._constants = constants
        self._population = population
        self._recent = recent
        self._load_cells = load_cells
        self.surprises = np.zeros(0)
        self.seen = np.zeros(0, dtype=np.int64)
        self.lead = math.nan

    def step(
        self,
        stamp_ns: int,
        dt: float,
        sensed: Sensed,
        undeveloped: CreepChange,
        activity: Activity,
    ) -> Step:
        """Move every member by `dt` [s] and compare it with what was sensed at `stamp_ns` [ns].

        `activity` is that of the load, see `LoadWander.follow`.
        """
        step = self._moved(stamp_ns, dt, sensed, undeveloped, activity)
        if self._population.least > _SURPRISE[len(sensed.z)]:
            # The load has jumped. Taken in as if it had not, it would be blamed on the belt.
            self._population.go_back(step.before)
            step = self._moved(stamp_ns, dt, sensed, undeveloped, activity.jumping())
        return step

    def _moved(
        self,
        stamp_ns: int,
        dt: float,
        sensed: Sensed,
        undeveloped: CreepChange,
        activity: Activity,
    ) -> Step:
        """Move every member, as its mode has it, and compare it with what was sensed."""
        population = self._population
        before = population.members()
        change = dt if math.isnan(sensed.change) else sensed.change
        recorded = self._recent.recorder is not None
        added = self.wander, activity, undeveloped, change
        foretold = population.step(dt, added, sensed, crosses=recorded)
        self.seen, self.surprises, self.lead = sensed.places, foretold.surprises, foretold.lead
        moved = Moved(population.means, population.covariances, foretold.crosses)
        processes = (
            drift_processes(self.wander, self._constants, *added[1:3], dt, change)
            if recorded
            else None
        )
        return Step(stamp_ns, dt, before, sensed, undeveloped, activity, processes, moved)

    def take_in(self, sensed: Sensed) -> None:
        """Take in what the last step has compared the members with."""
        self._population.take_in(sensed)
        self._load_cells.take_in(self._population, sensed)

    def unread(self, step: Step) -> Step:
        """Move as in the last step, but as if nothing had been sensed at its end."""
        self._population.go_back(step.before)
        nothing = step.sensed.part(0, 0)
        return self._moved(step.stamp_ns, step.dt, nothing, step.undeveloped, step.activity)

    def rewind(self, activity: Activity) -> None:
        """Repeat the last steps with the load's present activity, if it was taken for calmer.

        That a load has begun to move shows some steps later; until then, the belt is blamed.
        """
        again = self._recent.taken_too_calm(activity)
        if not again:
            return
        self._population.go_back(again[0].before)
        for step in again:
            moving = step.activity.at_least(activity)
            repeated = self._moved(step.stamp_ns, step.dt, step.sensed, step.undeveloped, moving)
            self._recent.append(repeated._replace(taken_in=step.taken_in))
            if step.taken_in:
                self.take_in(step.sensed)
        self._population.summarise()
