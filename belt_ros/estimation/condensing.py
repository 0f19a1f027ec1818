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


def condensed(
    components: list[Component], axes: Sequence[int], most: int = MEMBERS
) -> list[Component]:
    """Return at most `most` members of the same mean and covariance, exactly symmetric.

    Negligible members are dropped, those alike along `axes` merged, and then the least likely
    merged into its neighbour for as long as there are too many (M. West, 1993).
    """
    kept = reduced(components, axes)
    places = list(axes)
    means = np.stack([c.mean[places] for c in kept])
    variances = np.stack([c.covariance[places, places] for c in kept])
    while len(kept) > most:
        at = min(range(len(kept)), key=lambda k: kept[k].log_weight)
        least, mean, variance = kept.pop(at), means[at], variances[at]
        means, variances = np.delete(means, at, 0), np.delete(variances, at, 0)
        nearest = int(np.argmin(np.sum((means - mean) ** 2 / (variances + variance), 1)))
        kept[nearest] = both = merge(kept[nearest], least)
        means[nearest], variances[nearest] = both.mean[places], both.covariance[places, places]
    return [replace(c, covariance=0.5 * (c.covariance + c.covariance.T)) for c in kept]
