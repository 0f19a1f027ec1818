"""Dynamic finite element simulation of a two-pulley drive: the reference the closed forms face.

The peer of the simulator in section 6 of the paper (DOI 10.1115/1.4003796): a closed belt of
two-noded corotational truss elements with lumped mass, rigid circular pulleys with penalty
contact, a series spring-slider (EPP) friction state in every node that resets when the node leaves
the pulley, and explicit time marching by central differences. Friction is not told anything of
arcs, zones or equilibrium.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from belt_ros.mechanics.drive import BeltDrive, DriveError, require_positive
from belt_ros.mechanics.finite_element_kernel import Mesh, Profile, Rim, advance
from belt_ros.mechanics.finite_element_mesh import Discretisation, build_mesh, initial_state

_Floats = NDArray[np.float64]
_MOST_NODE_STEPS = 2e10
_MOST_SAMPLES = 1_000_000
_MOST_STEPS_PER_SAMPLE = 1_000_000
_STRIDE = 8
_BIN = 1.05  # elements; a little above one, so that no bin is empty at standstill


@dataclass(frozen=True, eq=False)
class History:
    """What is imposed on the drive, piecewise linear in time.

    Parameters
    ----------
    time : array_like
        (k,) increasing [s].
    driver_speed : array_like
        (k,) omega2 [rad/s]; the run starts with belt and pulleys moving at the first.
    load_torque : array_like
        (k,) on the driven pulley [N m], positive against positive rotation.
    """

    time: ArrayLike
    driver_speed: ArrayLike
    load_torque: ArrayLike

    def __post_init__(self) -> None:
        for name in ("time", "driver_speed", "load_torque"):
            object.__setattr__(self, name, np.array(getattr(self, name), dtype=np.float64))
        time, speed, load = self.arrays
        if time.ndim != 1 or time.size < 2 or not time.shape == speed.shape == load.shape:
            raise DriveError(
                f"a history needs three rows of one length >= 2; shapes are {time.shape}, "
                f"{speed.shape}, {load.shape}"
            )
        if not all(np.all(np.isfinite(array)) for array in (time, speed, load)):
            raise DriveError("the history contains NaN or infinity")
        if np.any(bad := np.diff(time) <= 0.0):
            raise DriveError(f"the history's time does not increase after {time[:-1][bad][0]:g} s")

    @property
    def arrays(self) -> tuple[_Floats, _Floats, _Floats]:
        """Time [s], driver speed [rad/s], load torque [N m]."""
        return np.asarray(self.time), np.asarray(self.driver_speed), np.asarray(self.load_torque)


class ArcDistribution(NamedTuple):
    """Time-averaged distributions on one pulley, (bins,) each, one bin about an element long."""

    angle: _Floats  # middle of the bin from the inlet [rad]
    friction: _Floats  # per unit length [N/m], positive where it raises tension along travel
    normal: _Floats  # per unit length [N/m]
    tension: _Floats  # of the belt [N]


@dataclass(frozen=True, eq=False)
class FiniteElementRun:
    """Result of `simulate`; time series are means over each sampling interval, (samples,).

    Attributes
    ----------
    time : ndarray
        Middle of the sampling interval [s], on the history's clock.
    driver_speed, driven_speed : ndarray
        omega2, omega1 [rad/s].
    driver_torque : ndarray
        That the driver puts into the belt through friction [N m].
    driven_torque : ndarray
        That the belt puts on the driven pulley through friction [N m].
    to_driver_tension : ndarray
        Of the span that runs to the driver at positive rotation [N]: tight under positive load.
    to_driven_tension : ndarray
        Of the other span [N].
    driven_arc, driver_arc : ArcDistribution
        Averaged over the last `average_over` seconds; the inlet is that of the rotation at the end.
    time_step : float
        [s]
    elements : int
        Of the whole belt.
    """

    time: _Floats
    driver_speed: _Floats
    driven_speed: _Floats
    driver_torque: _Floats
    driven_torque: _Floats
    to_driver_tension: _Floats
    to_driven_tension: _Floats
    driven_arc: ArcDistribution
    driver_arc: ArcDistribution
    time_step: float
    elements: int

    @property
    def tight_tension(self) -> _Floats:
        """T_H [N], the greater of both span tensions."""
        return np.maximum(self.to_driver_tension, self.to_driven_tension)

    @property
    def slack_tension(self) -> _Floats:
        """T_L [N], the lesser of both span tensions."""
        return np.minimum(self.to_driver_tension, self.to_driven_tension)


class _Sampling(NamedTuple):
    """How many samples and steps a run has."""

    samples: int
    steps: int  # in a sample
    averaged: int  # of the samples, the last


def simulate(
    drive: BeltDrive,
    history: History,
    installed_tension: float,
    discretisation: Discretisation | None = None,
    sampling_interval: float = 1e-3,
    average_over: float = 0.05,
    progress: Callable[[float, float], None] | None = None,
) -> FiniteElementRun:
    """Simulate a drive on fixed centres.

    Parameters
    ----------
    drive : BeltDrive
        An open belt: wraps must match radii and span length, see `open_belt`. Kinematics and
        tensioning of the drive play no part: the elements know their strain, the centres are fixed.
    history : History
        Driver speed and load torque; the run lasts as long as it does.
    installed_tension : float
        Of the belt at standstill [N].
    discretisation : Discretisation, optional
    sampling_interval : float
        Between two entries of the time series [s].
    average_over : float
        Window at the end of the run for the distributions on the pulleys [s]. Let at least one
        element pass in it, unless the belt stands.
    progress : callable, optional
        Called with (done, total) simulated time [s] after every sample.

    Returns
    -------
    FiniteElementRun

    Raises
    ------
    DriveError
        For a belt without mass, slack, lifted off by its inertia or above its critical speed;
        pulleys that overlap or wraps that are not an open belt's; a run that is too large.
    """
    time, speed, _ = history.arrays
    _check_belt(drive, installed_tension, float(np.max(np.abs(speed))))
    require_positive(sampling_interval, "sampling interval", "s")
    require_positive(average_over, "averaging window", "s")
    mesh = build_mesh(drive, installed_tension, discretisation or Discretisation())
    duration = float(time[-1] - time[0])
    samples = math.floor(duration / sampling_interval * (1.0 + 1e-12))
    steps = _STRIDE * math.ceil(sampling_interval / (_STRIDE * mesh.time_step))
    _check_size(samples, steps, mesh.elements, duration, sampling_interval)
    mesh = mesh._replace(time_step=sampling_interval / steps)
    averaged = max(round(average_over / sampling_interval), 1)
    rows, driven, driver = _march(
        drive, mesh, history, installed_tension, _Sampling(samples, steps, averaged), progress
    )
    backward = bool(speed[-1] < 0.0)
    return FiniteElementRun(
        time=time[0] + (np.arange(samples) + 0.5) * sampling_interval,
        driver_speed=rows[:, 0],
        driven_speed=rows[:, 1],
        driver_torque=-rows[:, 2],
        driven_torque=rows[:, 3],
        to_driver_tension=rows[:, 4],
        to_driven_tension=rows[:, 5],
        driven_arc=_distribution(driven, mesh.driven, backward),
        driver_arc=_distribution(driver, mesh.driver, backward),
        time_step=mesh.time_step,
        elements=mesh.elements,
    )


def _march(
    drive: BeltDrive,
    mesh: Mesh,
    history: History,
    tension: float,
    sampling: _Sampling,
    progress: Callable[[float, float], None] | None,
) -> tuple[_Floats, Profile, Profile]:
    """Rows of `advance` for each sample, and both profiles over the averaged ones."""
    samples, steps, averaged = sampling
    interval = steps * mesh.time_step
    time, speed, load = history.arrays
    state = initial_state(drive, mesh, tension, float(speed[0]))
    idle = Profile(*(np.empty(0) for _ in Profile._fields))
    profiles = _no_profile(mesh, mesh.driven), _no_profile(mesh, mesh.driver)
    rows = np.empty((samples, 6))
    for k in range(samples):
        now = time[0] + (k * steps + np.arange(steps) + 0.5) * mesh.time_step
        imposed = np.interp(now, time, speed), np.interp(now, time, load)
        observers = profiles if samples - k <= averaged else (idle, idle)
        rows[k] = advance(mesh, state, *imposed, _STRIDE, *observers)
        if progress is not None:
            progress((k + 1) * interval, samples * interval)
    return rows, *profiles


def _check_belt(drive: BeltDrive, tension: float, fastest: float) -> None:
    """Raise unless the belt has mass and stays on the pulleys at `fastest` [rad/s]."""
    require_positive(tension, "installed tension", "N")
    require_positive(drive.belt.mass_per_length, "belt mass per length", "kg/m")
    speed = fastest * drive.driver.radius
    if not speed < drive.belt.critical_speed:
        raise DriveError(
            f"belt speed {speed:g} m/s is not below the critical speed "
            f"{drive.belt.critical_speed:g} m/s"
        )
    lift = drive.belt.mass_per_length * speed**2
    if not tension > lift:
        raise DriveError(
            f"the belt lifts off: installed tension {tension:g} N is not above "
            f"m v^2 = {lift:g} N at the fastest"
        )


def _check_size(samples: int, steps: int, nodes: int, duration: float, interval: float) -> None:
    if samples < 1:
        raise DriveError(
            f"the history lasts {duration:g} s, less than one sampling interval of {interval:g} s"
        )
    if samples > _MOST_SAMPLES:
        raise DriveError(
            f"{samples} samples exceed the limit of {_MOST_SAMPLES}; take a longer interval"
        )
    if steps > _MOST_STEPS_PER_SAMPLE:
        raise DriveError(
            f"a sampling interval of {interval:g} s takes {steps} steps, above the limit of "
            f"{_MOST_STEPS_PER_SAMPLE}; take a shorter interval"
        )
    if (work := float(samples) * steps * nodes) > _MOST_NODE_STEPS:
        raise DriveError(
            f"{work:.2g} steps times nodes exceed the limit of {_MOST_NODE_STEPS:.0g}; take a "
            "shorter history or fewer elements"
        )


def _no_profile(mesh: Mesh, rim: Rim) -> Profile:
    bins = max(int(rim.wrap * rim.radius / (_BIN * mesh.rest_length)), 1)
    return Profile(*(np.zeros(bins) for _ in Profile._fields))


def _distribution(profile: Profile, rim: Rim, backward: bool) -> ArcDistribution:
    """Means of the bins, seen from the inlet of the actual rotation; NaN where no node passed."""
    bins = profile.visits.size
    angle = (np.arange(bins, dtype=np.float64) + 0.5) * (rim.wrap / bins)
    visits = np.where(profile.visits > 0.0, profile.visits, np.nan)
    friction, normal, tension = (
        values / visits for values in (profile.friction, profile.normal, profile.tension)
    )
    if backward:
        return ArcDistribution(angle, -friction[::-1], normal[::-1], tension[::-1])
    return ArcDistribution(angle, friction, normal, tension)
