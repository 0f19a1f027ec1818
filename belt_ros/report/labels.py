"""What quantities are called in a report, and in which unit they are shown."""

import math
from dataclasses import dataclass

from belt_ros.estimation.estimate import Quantity, log_spread
from belt_ros.report.rounding import SPACE, plain, with_error

_WIDE = 0.3  # relative error from which a factor says it better


@dataclass(frozen=True)
class Label:
    """How a quantity is shown."""

    text: str
    unit: str
    factor: float = 1.0  # from SI to `unit`
    by_ratio: bool = False  # log-normal: its value is the median, and its error a factor

    def shown(self, value: float | None, stddev: float | None) -> str:
        """Return value and standard deviation [SI] with the unit."""
        if self.by_ratio and value and stddev and value > 0.0 and stddev > _WIDE * value:
            ratio = math.exp(log_spread(Quantity(value, stddev)))
            text = f"{plain(value * self.factor, 2)} ×/÷ {plain(ratio, 2)}"
            return f"{text}{SPACE}{self.unit}" if self.unit else text
        return self.difference(value, stddev)

    def difference(self, value: float | None, stddev: float | None) -> str:
        """Return a change and its standard deviation [SI] with the unit."""
        return with_error(value, stddev, self.unit, self.factor)


LABELS = {
    "slip": Label("slip", "%", 100.0),
    "predicted_creep": Label("creep the model predicts", "%", 100.0),
    "excess_slip": Label("slip beyond creep", "%", 100.0),
    "tight_tension": Label("tight span", "N"),
    "slack_tension": Label("slack span", "N"),
    "mean_tension": Label("tension, mean of both spans", "N"),
    "friction_stiffness": Label("friction stiffness kf", "MN/m²", 1e-6, by_ratio=True),
    "friction_coefficient": Label("friction coefficient µ", ""),
    "margin": Label("margin", "%", 100.0),
    "transmitted_torque": Label("torque", "N m"),
    "capacity_torque": Label("torque at which the belt slips", "N m"),
    "accumulated_slip": Label("rim travel lost", "m"),
    "ratio_bias": Label("error of the radius ratio", "10⁻⁶", 1e6),
}

CONDITIONS = (
    "no condition",
    "low margin",
    "slip beyond creep",
    "gross slip",
    "traction lost",
    "tension lost",
    "friction lost",
    "no data",
    "sensor implausible",
    "estimator lost",
)
SEVERITIES = ("normal", "warning", "alarm", "trip")


def severity_name(number: int) -> str:
    """Return the name of a severity, also of one that is newer than this program."""
    return SEVERITIES[number] if number < len(SEVERITIES) else f"severity {number}"


def condition_name(number: int) -> str:
    """Return the name of an alarm's condition, also of one that is newer than this program."""
    return CONDITIONS[number] if number < len(CONDITIONS) else f"condition {number}"
