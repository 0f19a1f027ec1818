"""While creep develops, a simulated belt slips no farther from equilibrium than is stated."""

import dataclasses
import math

import numpy as np
import pytest

from belt_ros.estimation.process import UndevelopedCreep, prior_state
from belt_ros.estimation.state import Index, slip_per_pull
from belt_ros.mechanics import Tensioning, torque_capacity
from belt_ros.mechanics.constants import drive_constants
from belt_ros.mechanics.finite_element_mesh import Discretisation
from belt_ros.rig import Truth, simulate_finite_elements
from belt_ros.rig.scenario import scenario_from_mapping
from belt_ros.settings import DriveSettings

RATE = 400.0  # [Hz]
SPEED = 120.0  # [rad/s]
BEGIN, END = 0.9, 1.3  # [s] of the load's rise
SOFTER_THAN_THE_BELT, STIFF = 2e5, 2e8  # kf [N/m2]


def smooth(begin: float, end: float, before: float, after: float) -> list[list[float]]:
    share = np.linspace(0.0, 1.0, 41)
    done = share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
    times = begin + (end - begin) * share
    return np.stack([times, before + (after - before) * done], axis=-1).tolist()


def loaded_smoothly(settings: DriveSettings, share: float) -> list[Truth]:
    """Samples of a simulated drive, loaded to a share of its capacity."""
    capacity = float(torque_capacity(settings.drive, settings.prior.tension, SPEED))
    values = {
        "duration": END,
        "sample_rate": RATE,
        "speed": smooth(0.0, 0.8, 0.0, SPEED),
        "load": [[0.0, 0.0], *smooth(BEGIN, END, 0.0, share * capacity)],
    }
    mesh = Discretisation(24, penalty_ratio=4.0, axial_damping=1.4)
    script = scenario_from_mapping(values, settings)
    return [sample.truth for sample in simulate_finite_elements(settings, script, mesh)]


def settings_with(settings: DriveSettings, stiffness: float) -> DriveSettings:
    drive = settings.drive
    return dataclasses.replace(
        settings,
        prior=dataclasses.replace(settings.prior, friction_stiffness=stiffness),
        drive=dataclasses.replace(
            drive,
            tensioning=Tensioning.FIXED_CENTRES,
            driven=dataclasses.replace(drive.driven, friction_stiffness=stiffness),
            driver=dataclasses.replace(drive.driver, friction_stiffness=stiffness),
        ),
    )


@pytest.mark.parametrize(
    ("stiffness", "least"), [(SOFTER_THAN_THE_BELT, 0.3), (STIFF, 0.1)]
)  # of a stiff contact, less is undeveloped than may be
def test_slip_is_no_farther_from_equilibrium_than_is_stated(
    settings: DriveSettings, stiffness: float, least: float
) -> None:
    told = settings_with(settings, stiffness)
    c = drive_constants(told.drive)
    state, _ = prior_state(told.prior, told.drive)
    state[Index.LOG_TENSION] = math.log(told.prior.tension)
    creep = UndevelopedCreep(c)
    creep.start(0.0)
    before = 0.0
    beside, stated = [], []
    for number, truth in enumerate(loaded_smoothly(told, 0.6)):
        pull = truth.transmitted_torque / c.driven_radius
        rim = c.driver_radius * truth.driver_speed
        state[[Index.DRIVER_SPEED, Index.DRIVEN_SPEED]] = truth.driver_speed, truth.driven_speed
        state[Index.PULL] = pull
        _, deviation, _ = creep.advance(pull, slip_per_pull(c, state), rim, 1.0 / RATE)
        if number > BEGIN * RATE:
            winding = c.span_compliance * (pull - before) * RATE / rim
            beside.append(truth.slip - truth.predicted_creep - winding)
            stated.append(deviation)
        before = pull
    rms = math.sqrt(np.mean(np.square(beside)) / np.mean(np.square(stated)))
    assert least < rms < 1.0
