"""A scenario run on the finite element simulator: a plant that is not the estimator's model.

Belt and contact are simulated node by node between fixed centres, with the driver's speed imposed;
sensors and truth are those of the rig. What the simulator does not know how to change while it runs
(tension, friction, errors of the model) has to stay as it is in the scenario.
"""

import dataclasses
from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from belt_ros.mechanics import BeltDrive, Tensioning
from belt_ros.mechanics.constants import drive_constants
from belt_ros.mechanics.finite_element import FiniteElementRun, History, simulate
from belt_ros.mechanics.finite_element_mesh import Discretisation
from belt_ros.mechanics.motion import Condition, Motion
from belt_ros.rig.plant import Command
from belt_ros.rig.running import RunningScenario
from belt_ros.rig.scenario import Scenario, ScenarioError
from belt_ros.rig.sensors import Sensors
from belt_ros.rig.simulate import RigSample
from belt_ros.rig.truth import Truth, read_truth
from belt_ros.settings import DriveSettings

_Floats = NDArray[np.float64]
_STEP = 5e-4  # [s], in which steps of the scenario become ramps
_STANDING = 1e-3  # [rad/s] over which a brake's torque turns round
# A belt loses energy: here 4 % of critical damping in axial waves as long as a span of the paper's
# drive. With the simulator's default, 0.8 %, friction of sliding arcs feeds such waves at soft
# contacts near the capacity, and slip is three times that of equilibrium.
_RUBBER = Discretisation(elements_per_half_pulley=50, penalty_ratio=4.0, axial_damping=1.4)


def simulate_finite_elements(
    settings: DriveSettings,
    scenario: Scenario,
    discretisation: Discretisation | None = None,
    start_ns: int = 0,
    progress: Callable[[float, float], None] | None = None,
) -> Iterator[RigSample]:
    """Run a scenario; the simulation is over when this returns, the samples come one by one.

    Parameters
    ----------
    settings : DriveSettings
        The drive, an open belt, and its joints.
    scenario : Scenario
        Its tension is that of installation; it must be constant, like mu and kf, and name no error
        of the model. Its motor plays no part: the driver's speed is imposed.
    discretisation : Discretisation, optional
        50 elements on half a pulley, and damped as rubber is, where not given.
    start_ns : int
        Stamp of the first sample [ns].
    progress : callable, optional
        Called with (done, total) simulated time [s].

    Raises
    ------
    ScenarioError
        If the scenario asks for what cannot change here.
    DriveError
        For a drive that the simulator refuses.
    """
    _check_constant(scenario)
    drive = _true_drive(settings.drive, scenario)
    history = _history(scenario)
    tension = scenario.profiles[Command.TENSION].values[0]
    run = simulate(
        drive,
        history,
        tension,
        discretisation or _RUBBER,
        sampling_interval=1.0 / scenario.sample_rate,
        progress=progress,
    )
    return _samples(settings, scenario, drive, run, start_ns)


def _check_constant(scenario: Scenario) -> None:
    for which in (Command.TENSION, Command.FRICTION_COEFFICIENT, Command.FRICTION_STIFFNESS):
        profile = scenario.profiles[which]
        if len(set(profile.values)) > 1:
            raise ScenarioError(
                f"{which.name.lower()} changes between {min(profile.values):g} and "
                f"{max(profile.values):g}; with finite elements the condition must be constant"
            )
    for field in ("ratio_bias", "creep_error", "creep_error_stddev", "undeveloped_creep"):
        value = getattr(scenario.model_error, field)
        if value != 0.0:
            raise ScenarioError(
                f"condition.{field} is {value:g}; finite elements have errors of their own, it "
                "must be 0"
            )


def _true_drive(drive: BeltDrive, scenario: Scenario) -> BeltDrive:
    """Return the drive with the scenario's friction, between fixed centres."""
    mu = scenario.profiles[Command.FRICTION_COEFFICIENT].values[0]
    kf = scenario.profiles[Command.FRICTION_STIFFNESS].values[0]
    ratios = (
        drive.driver.friction_coefficient / drive.driven.friction_coefficient,
        drive.driver.friction_stiffness / drive.driven.friction_stiffness,
    )
    return dataclasses.replace(
        drive,
        driven=dataclasses.replace(drive.driven, friction_coefficient=mu, friction_stiffness=kf),
        driver=dataclasses.replace(
            drive.driver, friction_coefficient=mu * ratios[0], friction_stiffness=kf * ratios[1]
        ),
    )


def _history(scenario: Scenario) -> History:
    """Return what the scenario imposes; a brake turns round with the driver."""
    steps = max(int(np.ceil(scenario.duration / _STEP)), 1)
    time = np.linspace(0.0, scenario.duration, steps + 1)
    commands = scenario.commands(time)
    speed, load = commands[:, Command.SPEED], commands[:, Command.LOAD]
    if scenario.load_brakes:
        load = load * np.clip(speed / _STANDING, -1.0, 1.0)
    return History(time, speed, load)


def _samples(
    settings: DriveSettings,
    scenario: Scenario,
    drive: BeltDrive,
    run: FiniteElementRun,
    start_ns: int,
) -> Iterator[RigSample]:
    _, random = np.random.default_rng(scenario.seed).spawn(2)
    sensors = Sensors(settings.driver, settings.driven, scenario.sensors, random)
    time = np.arange(scenario.samples) / scenario.sample_rate
    series = np.stack(
        [
            np.interp(time, run.time, values)
            for values in (
                run.driver_speed,
                run.driven_speed,
                run.driver_torque + drive.driver.inertia * _slope(run.time, run.driver_speed),
                -np.interp(run.time, *_history(scenario).arrays[::2]),
                run.driven_torque,
                run.to_driver_tension,
                run.to_driven_tension,
            )
        ],
        axis=-1,
    )
    period = 1.0 / scenario.sample_rate
    angles = np.zeros(2)
    lost = 0.0
    running = RunningScenario(scenario, settings)
    running.start(start_ns)
    for number, row in enumerate(series):
        if number > 0:
            middle = 0.5 * (series[number - 1, :2] + row[:2])
            angles += period * middle
            lost += period * float(
                drive.driver.radius * middle[0] - drive.driven.radius * middle[1]
            )
        truth = _truth(settings, scenario, drive, row, lost)
        joints = sensors.measure(truth, float(angles[0]), float(angles[1]))
        stamp_ns = start_ns + scenario.stamp_ns(number)
        yield RigSample(stamp_ns, joints, truth, running.reports(stamp_ns, joints))


def _slope(time: _Floats, values: _Floats) -> _Floats:
    return np.gradient(values, time) if time.size > 1 else np.zeros_like(values)


def _truth(
    settings: DriveSettings, scenario: Scenario, drive: BeltDrive, row: _Floats, lost: float
) -> Truth:
    """Return the truth: what moves as simulated, what is derived from it as the rig derives it."""
    driver, driven, motor, load, transmitted, to_driver, to_driven = row.tolist()
    pull = transmitted / drive.driven.radius
    slack, tight = sorted((to_driver, to_driven))
    lift = drive.belt.mass_per_length * (drive.driver.radius * driver) ** 2
    held = {
        Tensioning.CONSTANT_MEAN: 0.5 * (slack + tight),
        Tensioning.CONSTANT_SLACK: slack,
        Tensioning.CONSTANT_HUB_LOAD: 0.5 * (slack + tight) - lift,
        Tensioning.FIXED_CENTRES: scenario.profiles[Command.TENSION].values[0],
    }
    condition = Condition(
        motor,
        load,
        max(held[drive.tensioning], 1e-9),
        drive.driven.friction_coefficient,
        drive.driven.friction_stiffness,
        0.0,
        0.0,
    )
    motion = Motion(driver, driven, pull)
    known = read_truth(
        drive_constants(drive), motion, condition, lost, settings.limits.standstill_speed
    )
    return dataclasses.replace(
        known, tight_tension=tight, slack_tension=slack, mean_tension=0.5 * (slack + tight)
    )
