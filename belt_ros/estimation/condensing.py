"""Members of a Gaussian sum: made fewer, and partly made anew."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation.gaussian_sum import Component, merge, reduced

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


def condensed(components: list[Component], axes: Sequence[int]) -> list[Component]:
    """Return at most `MEMBERS` members of the same mean and covariance, exactly symmetric.

    Negligible members are dropped, those alike along `axes` merged, and then the least likely
    merged into its neighbour for as long as there are too many (M. West, 1993).
    """
    kept = reduced(components, axes)
    places = list(axes)
    while len(kept) > MEMBERS:
        least = kept.pop(min(range(len(kept)), key=lambda k: kept[k].log_weight))
        means = np.stack([c.mean[places] for c in kept])
        variances = np.stack([c.covariance[places, places] for c in kept])
        shift = (means - least.mean[places]) ** 2
        nearest = int(np.argmin(np.sum(shift / (variances + least.covariance[places, places]), 1)))
        kept[nearest] = merge(kept[nearest], least)
    return [replace(c, covariance=0.5 * (c.covariance + c.covariance.T)) for c in kept]
