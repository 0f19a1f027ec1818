"""What an estimate says of margin, slip and traction, judged by probability."""

from belt_ros.estimation.alarm_settings import AlarmSettings
from belt_ros.estimation.condition import Evidence, judged
from belt_ros.estimation.estimate import (
    BeltEstimate,
    Knowledge,
    LostTraction,
    Phase,
    Quantity,
    probability_below,
)
from belt_ros.estimation.overload import Capacity
from belt_ros.estimation.sensor_watch import slip_along_power

RESTING = (Phase.STANDSTILL, Phase.UNKNOWN)


def margin_evidence(
    estimate: BeltEstimate, capacity: Capacity | None, settings: AlarmSettings
) -> tuple[Evidence, Evidence]:
    """Judge the margin against the limits of alarm and warning.

    Without the capacity's distribution the margin is taken as normally distributed.
    """
    s = settings
    learned = estimate.tension_knowledge is Knowledge.LEARNED
    enough = s.learned_confidence if learned else s.confidence

    def below(limit: float) -> Evidence:
        return judged(_margin_below(estimate, limit, capacity), enough, s.clear_confidence)

    if below(max(s.margin_warning, s.margin_alarm)) is Evidence.GONE:  # then both are
        return Evidence.GONE, Evidence.GONE
    return below(s.margin_alarm), below(s.margin_warning)


def _margin_below(estimate: BeltEstimate, limit: float, capacity: Capacity | None) -> float:
    """Probability that the margin is below a limit."""
    if capacity is None or limit >= 1.0:
        return probability_below(estimate.margin, limit)
    return capacity.gross_slip_probability_at(estimate.transmitted_torque.value / (1.0 - limit))


def slip_evidence(
    estimate: BeltEstimate, beyond: Quantity, settings: AlarmSettings
) -> tuple[Evidence, Evidence, Evidence]:
    """Judge the slip beyond creep and winding up against the limits of trip, alarm and warning."""
    s = settings
    if estimate.phase in RESTING:
        return Evidence.GONE, Evidence.GONE, Evidence.GONE
    slip = slip_along_power(estimate, beyond)

    def above(limit: float) -> Evidence:
        return judged(1.0 - probability_below(slip, limit), s.confidence, s.clear_confidence)

    limits = s.excess_slip_trip, s.excess_slip_alarm, s.excess_slip_warning
    if above(min(limits)) is Evidence.GONE:  # then all are
        return Evidence.GONE, Evidence.GONE, Evidence.GONE
    trip, alarm, warning = map(above, limits)
    return trip, alarm, warning


def gross_slip_evidence(estimate: BeltEstimate, settings: AlarmSettings) -> Evidence:
    """Judge whether a pulley slides over its whole arc."""
    if estimate.phase in RESTING:
        return Evidence.GONE
    return judged(estimate.gross_slip_probability, settings.confidence, settings.clear_confidence)


def traction_evidence(lost: LostTraction, settings: AlarmSettings) -> Evidence:
    """Judge whether traction has been lost; where that is not known, it has not."""
    if not lost.traction >= 0.0:
        return Evidence.GONE
    return judged(lost.traction, settings.traction_confidence, settings.clear_confidence)
