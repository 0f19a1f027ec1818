"""What a load that wanders does within a step, of which only the end is sampled.

Torques wander before the motion, so that within the same step the pull follows them. The motion
then takes the torques of the step's end for all of it. For the pull that is right, which is that of
the end as well; but what both pulleys gain together comes of the torques in between. In a walk
those are on average half as far away as at the end, and the integral of a walk between known ends
has the variance dt^3/12.
"""

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation.load import Activity
from belt_ros.estimation.state import Index
from belt_ros.mechanics._compile import compiled
from belt_ros.mechanics.constants import DriveConstants

_Floats = NDArray[np.float64]
# Compiled code wants plain integers.
_DRIVER_SPEED, _DRIVEN_SPEED = int(Index.DRIVER_SPEED), int(Index.DRIVEN_SPEED)
_DRIVER_TORQUE = int(Index.DRIVER_TORQUE)


@compiled
def set_walk(
    covariance: _Floats, load: float, c: DriveConstants, activity: Activity, dt: float
) -> None:
    """Set what torques that wander by `load` [N/sqrt(s)] at the rims add before a step of `dt` [s].

    That is the variance of both torques, and that of the speeds to start from, which lack what the
    torques have not given them. A torque that its own sensor shows to be calm has given all. One
    that jumps has given half of it: when it jumped is left open no further than in the liveliest
    walk, lest a sensor that errs for a sample should pass as a load.

    Parameters
    ----------
    covariance : ndarray
        To be changed (12, 12).
    load : float
    c : DriveConstants
    activity : Activity
    dt : float
    """
    mass = c.driver_inertia / c.driver_radius**2 + c.driven_inertia / c.driven_radius**2
    lag = dt / mass
    together = 0.0
    for pulley in range(2):
        torque = _DRIVER_TORQUE + pulley
        radius = c.driver_radius if pulley == 0 else c.driven_radius
        taken = (activity.taken[pulley] * load) ** 2 * dt
        shown = (activity.shown[pulley] * load) ** 2 * dt
        between = (min(activity.shown[pulley], 1.0) * load) ** 2 * dt
        together += (shown / 4.0 + between / 12.0) * lag**2
        covariance[torque, torque] = taken * radius**2
        covariance[_DRIVER_SPEED, torque] = -0.5 * shown * lag * radius / c.driver_radius
        covariance[_DRIVEN_SPEED, torque] = -0.5 * shown * lag * radius / c.driven_radius
        covariance[torque, _DRIVER_SPEED] = covariance[_DRIVER_SPEED, torque]
        covariance[torque, _DRIVEN_SPEED] = covariance[_DRIVEN_SPEED, torque]
    covariance[_DRIVER_SPEED, _DRIVER_SPEED] = together / c.driver_radius**2
    covariance[_DRIVEN_SPEED, _DRIVEN_SPEED] = together / c.driven_radius**2
    both = together / (c.driver_radius * c.driven_radius)
    covariance[_DRIVER_SPEED, _DRIVEN_SPEED] = covariance[_DRIVEN_SPEED, _DRIVER_SPEED] = both
