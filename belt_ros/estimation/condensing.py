"""Members of a Gaussian sum: made fewer, and partly made anew."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation.gaussian_sum import Component
from belt_ros.estimation.reduction import reduced

_Floats = NDArray[np.float64]
MEMBERS = 32  # at most; half of what the filter may have, so that it can still split them


def renewed(
    component: Component, places: Sequence[int], mean: _Floats, variance: _Floats
) -> Component:
    """Return a settled member with the states at `places` anew, independent of all others."""
    at = list(places)
    means, covariance = component.mean.copy(), component.covariance.copy()
    means[at] = mean
    covariance[at, :] = 0.0
    covariance[:, at] = 0.0
    covariance[at, at] = variance
    return Component(component.log_weight, means, covariance)


def condensed(
    components: Sequence[Component], axes: Sequence[int], most: int = MEMBERS
) -> list[Component]:
    """Return at most `most` members of the same mean and covariance, exactly symmetric.

    Negligible members are dropped, and others merged, see `reduction.reduced`.
    """
    return [
        replace(c, covariance=0.5 * (c.covariance + c.covariance.T))
        for c in reduced(components, axes, most)
    ]
