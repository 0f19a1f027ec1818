"""What is held to be known of the belt: to start from, now, and while sensors do not fit."""

import math
from collections.abc import Sequence

import numpy as np

from belt_ros.estimation.ageing import MOTION, in_motion
from belt_ros.estimation.belt_filter import BeltFilter
from belt_ros.estimation.condensing import condensed, renewed
from belt_ros.estimation.description import BeliefReader, View
from belt_ros.estimation.doubt import Doubt, Turn, decided, either
from belt_ros.estimation.estimate import LostTraction
from belt_ros.estimation.gaussian_sum import Component, normalised
from belt_ros.estimation.installed import Installed
from belt_ros.estimation.measurement import Measurement
from belt_ros.estimation.misfit import Misfit
from belt_ros.estimation.state import Index
from belt_ros.estimation.traction import traction_reference
from belt_ros.estimation.upkeep import MERGE_AXES
from belt_ros.mechanics.drive import BeltDrive

_SECONDS = 1e-9
_MEASURED = 10.0  # [s] for which the tension counts as measured after a load has been
_IMPOSSIBLE = 1e-100  # plausibility of a belief that needs a creep error beyond all bounds


class Credence:
    """The filter's belief, doubted while its sensors do not fit.

    Parameters
    ----------
    belt_filter : BeltFilter
        Whose belief it is; it has to be started, and is started anew, by the owner.
    drive : BeltDrive
    installed : Installed
        With which traction is compared.

    Attributes
    ----------
    initial : list of Component or None
        To start from, instead of the prior.
    """

    def __init__(self, belt_filter: BeltFilter, drive: BeltDrive, installed: Installed) -> None:
        self.initial: list[Component] | None = None
        self._filter = belt_filter
        self._load_ns: int | None = None  # stamp of the last load that was measured
        self.compare_with(installed)
        self._reader = BeliefReader(drive)
        self.begin()

    def begin(self) -> None:
        """Start anew, at `initial`."""
        self._running = False
        if self._load_ns is not None:
            self._load_ns = None
            self.compare_with(self._installed)
        self._misfit = Misfit()
        self._doubt = Doubt()
        self._earlier: list[list[Component]] = []  # what was believed before a misfit, aged

    def compare_with(self, installed: Installed) -> None:
        """Compare traction with that of a belt as it was installed."""
        self._installed = installed
        self._reference = traction_reference(
            self._filter.constants,
            installed.log_tension,
            installed.log_friction,
            float(self._filter.prior_stddev[Index.LOG_FRICTION]),
            tension_measured=self._load_ns is not None,
        )

    def see(self, measurement: Measurement) -> None:
        """Note whether the tension is measured, which tells its loss from that of friction."""
        before, stamp_ns = self._load_ns, measurement.stamp_ns
        if not all(map(math.isnan, measurement.loads)):
            self._load_ns = stamp_ns
        elif before is not None and (stamp_ns - before) * _SECONDS > _MEASURED:
            self._load_ns = None
        if (before is None) is not (self._load_ns is None):
            self.compare_with(self._installed)

    @property
    def doubted(self) -> bool:
        """Whether sensors do not fit."""
        return self._misfit.lasts

    @property
    def recovers(self) -> bool:
        """Whether sensors that did not fit seem to do so again."""
        return self._misfit.recovers

    @property
    def known(self) -> list[Component] | None:
        """What is known, as a Gaussian sum over the state; None before anything is."""
        if not self._running:
            return self.initial
        belief = self._filter.belief()
        return self._either(belief) if self.doubted else belief

    def adopt(self, belief: list[Component], *, of_belt_only: bool = False) -> None:
        """Start, or go on, from another belief.

        `of_belt_only`: what moves is not part of it, and stays as it is.
        """
        f = self._filter
        mean, variance = f.prior_mean[MOTION], f.prior_stddev[MOTION] ** 2
        self.initial = [renewed(member, MOTION, mean, variance) for member in belief]
        self._doubt.forget()
        self._earlier = []
        if self._running:
            f.adopt_belief(in_motion(belief, f.x, f.covariance) if of_belt_only else belief)

    def judge(self, innovation: float, dt: float) -> None:
        """Take in an innovation squared per degree of freedom, `dt` [s] after the one before."""
        self._misfit.update(innovation, dt)

    def contradict(self) -> None:
        """Note that a sensor cannot be right, or that the motion had to be begun anew."""
        self._misfit.begin()

    def reconsider(self, stamp_ns: int) -> None:
        """Ask now and then, while sensors do not fit and once they do, what has been wrong."""
        f = self._filter
        turn = self._doubt.turn(stamp_ns, misfit=self.doubted)
        if turn is Turn.DECIDES:
            f.adopt_belief(decided(f.belief()))
        if turn in (Turn.NONE, Turn.DECIDES):
            return
        self._earlier = [
            condensed(decided(f.aged(before.belief, age)), MERGE_AXES)
            for before in self._doubt.before
            if (age := (stamp_ns - before.stamp_ns) * _SECONDS) >= 0.0
        ]
        if self._earlier and turn is Turn.BEGINS:
            f.conclude(in_motion(self._earlier[-1], f.x, f.covariance))
        elif self._earlier:
            present = condensed(decided(f.belief()), MERGE_AXES)
            f.adopt_belief(self._either(present), in_hindsight=True)

    def keep(self, stamp_ns: int, lost_traction: LostTraction) -> None:
        """Remember, once a second, what is known while sensors fit."""
        self._running = True
        self._doubt.keep(stamp_ns, self._filter.belief, lost_traction)

    def view(self, slowest: float) -> View:
        """Look at what is known; `slowest` [m/s] as in `BeliefReader.view`."""
        f = self._filter
        if self.doubted and self._earlier:
            return self._reader.view(self._either(decided(f.belief())), slowest)
        return f.view(slowest)

    def lost_traction(self) -> LostTraction:
        """Return whether traction has been lost; sensors that do not fit have no say in it."""
        if self.doubted and self._doubt.before:
            return self._doubt.before[-1].lost_traction
        return self._filter.lost_traction(self._reference)

    def _either(self, present: list[Component]) -> list[Component]:
        """Return what is known if sensors may have been wrong."""
        f = self._filter
        earlier = [in_motion(b, f.x, f.covariance) for b in self._earlier]
        return either(present, earlier, self._plausibility)

    def _plausibility(self, belief: Sequence[Component]) -> float:
        """How plausible a belief is by the creep error that it takes to explain the sensors."""
        spread = float(self._filter.prior_stddev[Index.CREEP_ERROR])
        weights = normalised(np.array([member.log_weight for member in belief]))
        off = np.array([member.mean[Index.CREEP_ERROR] for member in belief]) / spread
        return max(float(weights @ np.exp(-0.5 * off**2)), _IMPOSSIBLE)
