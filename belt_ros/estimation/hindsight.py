"""What the smoother's beliefs say of the drive, each quantity with its standard deviation."""

from dataclasses import dataclass

import numpy as np

from belt_ros.estimation.description import BeliefReader, described
from belt_ros.estimation.estimate import Quantity
from belt_ros.estimation.gaussian_sum import normalised
from belt_ros.estimation.smoother import Smoothed
from belt_ros.estimation.state import Reading
from belt_ros.mechanics.drive import BeltDrive


@dataclass(frozen=True, slots=True)
class HindsightEstimate:
    """State of the drive at `stamp_ns`, given the measurements after it too; SI units.

    Quantities are those of the same name in `BeltEstimate`. `changing_probability` is that of
    tension or friction being in the middle of a change.
    """

    stamp_ns: int
    driver_speed: Quantity  # [rad/s]
    driven_speed: Quantity  # [rad/s]
    transmitted_torque: Quantity  # [N m] on the driven pulley
    slip: Quantity  # [-]
    predicted_creep: Quantity  # [-]
    excess_slip: Quantity  # [-]
    tight_tension: Quantity  # [N]
    slack_tension: Quantity  # [N]
    mean_tension: Quantity  # [N]
    friction_stiffness: Quantity  # kf [N/m2], log-normal, its value the median
    friction_coefficient: Quantity  # mu [-], log-normal, its value the median
    ratio_bias: Quantity  # [-]
    creep_model_error: Quantity  # [-]
    driven_transition_angle: Quantity  # [rad]
    driver_transition_angle: Quantity  # [rad]
    margin: Quantity  # [-]
    capacity_torque: Quantity  # [N m] on the driven pulley, at gross slip
    friction_stiffness_log_stddev: float  # [-]
    gross_slip_probability: float  # [-]
    changing_probability: float  # [-]


class HindsightReader:
    """Reads quantities off smoothed beliefs as the monitor reads them off the filter's.

    Parameters
    ----------
    drive : BeltDrive
    slowest : float
        Rim speed [m/s] below which slip is referred to it.
    """

    def __init__(self, drive: BeltDrive, slowest: float) -> None:
        self._reader = BeliefReader(drive)
        self._slowest = slowest

    def read(self, smoothed: Smoothed) -> HindsightEstimate:
        """Read all quantities, by unscented transform of every member."""
        belief = smoothed.belief
        view = self._reader.view(belief, self._slowest)
        weights = normalised(np.array([member.log_weight for member in belief]))
        return HindsightEstimate(
            stamp_ns=smoothed.stamp_ns,
            capacity_torque=view.readings.quantity(Reading.CAPACITY),
            changing_probability=float(weights @ [member.changing for member in belief]),
            **described(view),
        )
