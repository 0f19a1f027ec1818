"""Gaussian sums in tests."""

import numpy as np

from belt_ros.estimation.gaussian_sum import Component, mixture_moments, normalised


def moments(components: list[Component]) -> tuple[np.ndarray, np.ndarray]:
    """Mean and covariance of a sum."""
    return mixture_moments(
        normalised(np.array([c.log_weight for c in components])),
        np.stack([c.mean for c in components]),
        np.stack([c.covariance for c in components]),
    )
