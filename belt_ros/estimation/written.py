"""Arrays written into others, number by number, compiled.

numpy's own assignment of arrays does the same. But in case that shapes disagree numba compiles the
making of a message, and makes it part of every function that assigns, and of all that call such a
one: for a short function that is twice as much to compile as the function.
"""

import numpy as np
from numpy.typing import NDArray

from belt_ros.mechanics._compile import compiled

_Floats = NDArray[np.float64]


@compiled
def write(target: _Floats, values: _Floats) -> None:
    """Write `values` (n,) into `target` (n,)."""
    for i in range(values.shape[0]):
        target[i] = values[i]


@compiled
def write_matrix(target: _Floats, values: _Floats) -> None:
    """Write `values` (n, m) into `target` (n, m)."""
    for i in range(values.shape[0]):
        for j in range(values.shape[1]):
            target[i, j] = values[i, j]
