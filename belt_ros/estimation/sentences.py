"""What an operator is told: what has happened, and what to do, in one sentence or two."""

import math
from typing import NamedTuple

from belt_ros.estimation.alarm_settings import Condition
from belt_ros.estimation.estimate import BeltEstimate, Quantity


class Tension(NamedTuple):
    """The tension that the drive's tensioning holds [N]."""

    estimated: Quantity
    installed: float  # as told: by the prior, or at the last maintenance


def percent(value: float) -> str:
    """Return a share in per cent, whole from 10 % on."""
    shown = 100.0 * value
    return f"{shown:.0f} %" if abs(shown) >= 9.95 else f"{shown:.1f} %"


def whole_percent(value: float) -> str:
    """Return a share in whole per cent; none that is negative, as an estimate may be."""
    return f"{max(100.0 * value, 0.0):.0f} %"


def _known(tension: Tension) -> str:
    value, stddev = tension.estimated
    text = f"estimated {value:.0f} +/- {stddev:.0f} N"
    if math.isfinite(tension.installed):
        text += f", installed {tension.installed:.0f} N"
    return text


def sentence(
    drive: str,
    condition: Condition,
    estimate: BeltEstimate,
    tension: Tension,
    detail: str = "",
) -> str:
    """Return what to tell of a condition that holds.

    Parameters
    ----------
    drive : str
        Its name.
    condition : Condition
    estimate : BeltEstimate
    tension : Tension
    detail : str
        Of sensors: which, and what is wrong.
    """
    known = _known(tension)
    margin, slip = whole_percent(estimate.margin.value), percent(abs(estimate.slip.value))
    told = {
        Condition.NONE: f"no alarm condition ({known}).",
        Condition.LOW_MARGIN: f"{margin} margin left. Reduce load or re-tension: {known}.",
        Condition.EXCESS_SLIP: (
            f"{percent(abs(estimate.excess_slip.value))} slip beyond the expected creep. Reduce "
            f"load; check tension and pulley surfaces: {known}."
        ),
        Condition.GROSS_SLIP: (
            f"gross slip, {slip} of the driver's travel is lost. Stop or unload the drive, then "
            f"check tension and contamination: {known}."
        ),
        Condition.TRACTION_LOST: (
            f"traction lost, {margin} margin left. Check tension and pulley surfaces: {known}."
        ),
        Condition.TENSION_LOST: (
            f"tension lost, {margin} margin left. Re-tension, and check tensioner and shafts: "
            f"{known}."
        ),
        Condition.FRICTION_LOST: (
            f"friction lost, {margin} margin left. Check the pulleys for oil, water or dust, and "
            f"the belt for glazing: {known}."
        ),
        Condition.SENSOR_STALE: f"{detail}. The estimate is that of the last measurement.",
        Condition.SENSOR_IMPLAUSIBLE: f"{detail}. Alarms of the belt are held back.",
        Condition.ESTIMATOR_LOST: (
            "the measurements contradict the drive's description. Check radii, signs and torque "
            "scales, then reset; alarms of the belt are held back."
        ),
    }
    return f"{drive}: {told[condition]}"


def recovering(drive: str, condition: Condition, estimate: BeltEstimate) -> str:
    """Return what to tell of a condition that is gone, while its off-delay lasts."""
    return (
        f"{drive}: {_name(condition)} is easing, {whole_percent(estimate.margin.value)} margin and "
        f"{percent(abs(estimate.slip.value))} slip now; it clears if that lasts."
    )


def over(drive: str, condition: Condition) -> str:
    """Return what to tell of a condition that is over but has not been acknowledged."""
    return f"{drive}: {_name(condition)} is over. Find its cause, then acknowledge."


def unheard(drive: str, what: str) -> str:
    """Return what to tell before the first measurement."""
    return f"{drive}: {what}. Nothing is known of the belt yet."


def _name(condition: Condition) -> str:
    return condition.name.lower().replace("_", " ")
