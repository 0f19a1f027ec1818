"""What a belief says of the drive, each quantity with its standard deviation."""

from typing import TypedDict

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation.bank import UnscentedBank
from belt_ros.estimation.estimate import Knowledge, Phase, Quantity, lognormal_quantity
from belt_ros.estimation.gaussian_sum import Component, mixture_moments, normalised
from belt_ros.estimation.knowledge import knowledge_of
from belt_ros.estimation.readings import Readings
from belt_ros.estimation.state import STATES, Index, Reading
from belt_ros.mechanics.constants import drive_constants
from belt_ros.mechanics.drive import BeltDrive

_Floats = NDArray[np.float64]
_GROSS_SLIP_MARGIN = 0.01


class View:
    """A belief, looked at: its states, and what is read off it.

    Parameters
    ----------
    weights, means, covariances : ndarray
        Of a Gaussian sum over the state: (k,), summing to one, (k, 12) and (k, 12, 12).
    moments : tuple of ndarray
        Mean (12,) and covariance (12, 12) of it all.
    readings : Readings
    """

    def __init__(
        self,
        weights: _Floats,
        means: _Floats,
        covariances: _Floats,
        moments: tuple[_Floats, _Floats],
        readings: Readings,
    ) -> None:
        self.readings = readings
        self._members = weights, means, covariances
        mean, covariance = moments
        deviations = np.sqrt(np.maximum(covariance.diagonal(), 0.0))
        self._states = [*map(Quantity, mean.tolist(), deviations.tolist())]

    def state(self, place: Index) -> Quantity:
        """Mean and standard deviation of one state."""
        return self._states[place]

    def knowledge(self, place: Index, prior: Quantity) -> Knowledge:
        """Return whether data have told one state, whose `prior` has this mean and deviation."""
        return knowledge_of(self._states[place], prior, int(place), *self._members)


class Description(TypedDict):
    """What every kind of estimate says; entries as in `BeltEstimate`."""

    driver_speed: Quantity
    driven_speed: Quantity
    transmitted_torque: Quantity
    slip: Quantity
    predicted_creep: Quantity
    excess_slip: Quantity
    tight_tension: Quantity
    slack_tension: Quantity
    mean_tension: Quantity
    friction_stiffness: Quantity
    friction_stiffness_log_stddev: float
    friction_coefficient: Quantity
    ratio_bias: Quantity
    creep_model_error: Quantity
    driven_transition_angle: Quantity
    driver_transition_angle: Quantity
    margin: Quantity
    gross_slip_probability: float


def described(view: View) -> Description:
    """Return all that a belief says of the drive at its instant."""
    state, read = view.state, view.readings.quantity
    log_stiffness = state(Index.LOG_STIFFNESS)
    return Description(
        driver_speed=state(Index.DRIVER_SPEED),
        driven_speed=state(Index.DRIVEN_SPEED),
        transmitted_torque=read(Reading.TRANSMITTED_TORQUE),
        slip=read(Reading.SLIP),
        predicted_creep=read(Reading.PREDICTED_CREEP),
        excess_slip=read(Reading.EXCESS_SLIP),
        tight_tension=read(Reading.TIGHT_TENSION),
        slack_tension=read(Reading.SLACK_TENSION),
        mean_tension=read(Reading.MEAN_TENSION),
        friction_stiffness=lognormal_quantity(*log_stiffness),
        friction_stiffness_log_stddev=log_stiffness.stddev,
        friction_coefficient=lognormal_quantity(*state(Index.LOG_FRICTION)),
        ratio_bias=state(Index.RATIO_BIAS),
        creep_model_error=state(Index.CREEP_ERROR),
        driven_transition_angle=read(Reading.DRIVEN_TRANSITION),
        driver_transition_angle=read(Reading.DRIVER_TRANSITION),
        margin=read(Reading.MARGIN),
        gross_slip_probability=view.readings.probability_below(Reading.MARGIN, _GROSS_SLIP_MARGIN),
    )


def phase_of(description: Description, drive: BeltDrive, standstill_speed: float) -> Phase:
    """Return the phase of operation; both rims slower than `standstill_speed` [m/s]: standing."""
    driver_rim = description["driver_speed"].value * drive.driver.radius
    driven_rim = description["driven_speed"].value * drive.driven.radius
    if max(abs(driver_rim), abs(driven_rim)) < standstill_speed:
        return Phase.STANDSTILL
    if description["gross_slip_probability"] > 0.5:
        return Phase.GROSS_SLIP
    driven_by_load = driver_rim * description["transmitted_torque"].value < 0.0
    if driven_by_load and description["slip"].value < 0.0:
        return Phase.REGENERATING
    return Phase.REVERSE if driver_rim < 0.0 else Phase.RUNNING


class BeliefReader:
    """Looks at a Gaussian sum over the state that no filter holds.

    Parameters
    ----------
    drive : BeltDrive
    """

    def __init__(self, drive: BeltDrive) -> None:
        self._bank = UnscentedBank(drive_constants(drive), np.zeros(STATES))

    def view(self, belief: list[Component], slowest: float) -> View:
        """Read all members, by unscented transform of each.

        `slowest` is the rim speed [m/s] below which slip is referred to it.
        """
        weights = normalised(np.array([member.log_weight for member in belief]))
        self._bank.x = np.stack([member.mean for member in belief])
        self._bank.P = np.stack([member.covariance for member in belief])
        members = weights, self._bank.x, self._bank.P
        rows = self._bank.read(np.arange(len(belief)), slowest)
        return View(*members, mixture_moments(*members), Readings(weights, *rows))
