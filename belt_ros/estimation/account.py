"""What is told of a drive, measurement after measurement."""

from dataclasses import replace

from belt_ros.estimation.assumptions import SensorLimits
from belt_ros.estimation.belt_filter import BeltFilter
from belt_ros.estimation.credence import Credence
from belt_ros.estimation.description import View, described, phase_of
from belt_ros.estimation.estimate import (
    UNKNOWN,
    BeltEstimate,
    Knowledge,
    Phase,
    Quantity,
    Reserve,
)
from belt_ros.estimation.health_record import HealthRecord
from belt_ros.estimation.holding import Pace
from belt_ros.estimation.lost_travel import LostTravel
from belt_ros.estimation.overload import Capacity
from belt_ros.estimation.state import Index, Reading
from belt_ros.mechanics.drive import BeltDrive

_SECONDS = 1e-9


class Account:
    """Turn what is known into estimates, and add up the travel that is lost meanwhile.

    Parameters
    ----------
    belt_filter : BeltFilter
    credence : Credence
        Of that filter.
    record : HealthRecord
    drive : BeltDrive

    Attributes
    ----------
    estimate : BeltEstimate or None
        The last one; None before the first.
    capacity : Capacity or None
        Distribution of the torque at gross slip, as of then.
    """

    estimate: BeltEstimate | None
    capacity: Capacity | None

    def __init__(
        self, belt_filter: BeltFilter, credence: Credence, record: HealthRecord, drive: BeltDrive
    ) -> None:
        self._filter = belt_filter
        self._credence = credence
        self._record = record
        self._drive = drive
        self.begin()

    def begin(self) -> None:
        """Tell anew."""
        self.estimate = self.capacity = None
        self._known: BeltEstimate | None = None  # when the filter was last moved
        self._pace = Pace()
        self._lost_travel = LostTravel()
        self._slip_speed = UNKNOWN

    def forget(self) -> None:
        """Describe anew next time, for something else is known now."""
        self._known = None

    def tell(self, stamp_ns: int, limits: SensorLimits, *, waits: bool) -> BeltEstimate:
        """Return what is known as of `stamp_ns` [ns].

        While measurements wait (`waits`), that is what was known when the filter was last moved.
        """
        f = self._filter
        assert f.stamp_ns is not None, "the filter has been started"
        age = max(stamp_ns - f.stamp_ns, 0) * _SECONDS
        if self._known is None or not waits:
            known = self._described(stamp_ns, limits)
            self._pace.see(known, f.stamp_ns)
            self._known = known
        else:
            known = replace(
                self._known,
                stamp_ns=stamp_ns,
                accumulated_slip=self._accumulate(stamp_ns, limits),
                health=self._record.brief,
            )
        self.estimate = self._pace.held(known, age, f.creep_wander) if age > 0.0 else known
        return self.estimate

    def _described(self, stamp_ns: int, limits: SensorLimits) -> BeltEstimate:
        """Read the estimate off what is known."""
        credence = self._credence
        view = credence.view(limits.standstill_speed)
        description = described(view)
        phase = phase_of(description, self._drive, limits.standstill_speed)
        self._slip_speed = view.readings.quantity(Reading.SLIP_SPEED)
        return BeltEstimate(
            stamp_ns=stamp_ns,
            phase=Phase.LOST if credence.doubted else phase,
            accumulated_slip=self._accumulate(stamp_ns, limits),
            tension_knowledge=self._knowledge(view, Index.LOG_TENSION),
            friction_stiffness_knowledge=self._knowledge(view, Index.LOG_STIFFNESS),
            friction_coefficient_knowledge=self._knowledge(view, Index.LOG_FRICTION),
            health=self._record.brief,
            reserve=self._reserve(view, limits.peak_load),
            lost_traction=credence.lost_traction(),
            **description,
        )

    def _reserve(self, view: View, peak_load: float) -> Reserve:
        capacity = self.capacity = view.readings.capacity(Reading.CAPACITY)
        at_peak = capacity.gross_slip_probability_at(peak_load) if peak_load > 0.0 else 0.0
        return Reserve(capacity.torque, at_peak)

    def _accumulate(self, stamp_ns: int, limits: SensorLimits) -> Quantity:
        """Add the travel lost since the last estimate [m]."""
        if self.estimate is not None:
            dt = (stamp_ns - self.estimate.stamp_ns) * _SECONDS
            if 0.0 < dt <= limits.greatest_gap:
                self._lost_travel.advance(self._slip_speed, dt)
        return self._lost_travel.total

    def _knowledge(self, view: View, place: Index) -> Knowledge:
        f = self._filter
        prior = Quantity(float(f.prior_mean[place]), float(f.prior_stddev[place]))
        return view.knowledge(place, prior)
