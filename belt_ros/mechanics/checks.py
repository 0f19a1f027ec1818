"""What every function of a drive's steady states checks, and how it takes arrays."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from belt_ros.mechanics.drive import BeltDrive, DriveError, Tensioning

_Floats = NDArray[np.float64]
_ROUNDING = 1e-12


def state_arrays(*values: ArrayLike) -> list[_Floats]:
    """Broadcast to arrays of one shape; raise `DriveError` unless that works and all are finite."""
    given = [np.asarray(value, dtype=np.float64) for value in values]
    try:
        arrays = np.broadcast_arrays(*given)
    except ValueError:
        shapes = ", ".join(str(array.shape) for array in given)
        raise DriveError(f"arrays of shapes {shapes} do not broadcast to one shape") from None
    if not all(np.all(np.isfinite(array)) for array in arrays):
        raise DriveError("the state asked for contains NaN or infinity")
    return list(arrays)


def as_rows(*arrays: _Floats) -> _Floats:
    """Arrays of one shape as the columns of a matrix."""
    return np.stack(arrays, axis=-1).reshape(-1, len(arrays))


def check_belt(drive: BeltDrive, tension: _Floats, rim_speed: _Floats) -> None:
    """Raise `DriveError` unless the belt stays on the pulleys at this speed."""
    limit = drive.belt.critical_speed
    if np.any(bad := ~(rim_speed < limit)):
        raise DriveError(
            f"belt speed {rim_speed[bad].flat[0]:g} m/s is not below the critical speed "
            f"{limit:g} m/s"
        )
    lift = drive.belt.mass_per_length * rim_speed**2
    if drive.tensioning is Tensioning.CONSTANT_HUB_LOAD:
        lift = np.zeros_like(lift)  # the shaft follows the belt that inertia lifts
    if np.any(bad := ~(tension > lift)):
        raise DriveError(
            f"the belt lifts off: tension {tension[bad].flat[0]:g} N is not above "
            f"m v^2 = {lift[bad].flat[0]:g} N"
        )


def check_load(moment: _Floats, limit: _Floats, slip: _Floats) -> None:
    """Raise `DriveError` unless there is a steady state at every torque."""
    beside = np.abs(moment) > limit * (1.0 - _ROUNDING)
    if np.any(bad := ~(np.abs(moment) < limit) | (beside & ~np.isfinite(slip))):
        raise DriveError(
            f"torque {moment[bad].flat[0]:g} N m is not within the capacity of "
            f"{limit[bad].flat[0]:g} N m: gross slip"
        )
    if np.any(bad := ~np.isfinite(slip)):
        raise DriveError(
            f"torque {moment[bad].flat[0]:g} N m needs a slip beyond 100 %: no steady state"
        )
