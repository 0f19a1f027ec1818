"""What the data do not tell, and the load that would."""

import numpy as np
from numpy.typing import NDArray

from belt_ros.identify.fit import Fit
from belt_ros.identify.model import BELT, SlipModel

_Floats = NDArray[np.float64]
_SHARES = np.arange(0.1, 0.96, 0.05)  # of the capacity
_WORTH = 0.6  # of the prior's deviation: what a load has to bring it down to
_ADDED = 3  # loads held at once: that one, and some less


def telling_load(model: SlipModel, fit: Fit, place: int, creep_error: float) -> float | None:
    """Return the least pull [N] that would tell one of the belt's quantities.

    To first order about the fit: the loads of the curve, and with them a few more up to that pull,
    each as well measured as those are.

    Parameters
    ----------
    model : SlipModel
    fit : Fit
    place : int
        Of the quantity in `BELT`.
    creep_error : float
        Standard deviation of the model's relative error of creep.

    Returns
    -------
    float or None
        None where no load below gross slip would.
    """
    belt = model.belt(fit.unknowns)
    information = np.linalg.inv(fit.covariance)
    noise = float(np.median(model.curve.slip_stddev))
    capacity = model.capacity(belt)
    for share in _SHARES:
        pull = float(share) * capacity
        if pull <= float(np.max(np.abs(model.curve.pull))):
            continue
        added = _information(model, belt, pull, noise, creep_error)
        if np.linalg.inv(information + added)[place, place] < _WORTH**2:
            return pull
    return None


def _information(
    model: SlipModel, belt: _Floats, pull: float, noise: float, creep_error: float
) -> _Floats:
    """Return the information (4, 4) of a few loads up to `pull`, of one error of creep."""
    pulls = pull * np.arange(1, _ADDED + 1) / _ADDED
    slips, slopes = zip(*(model.slip_slopes(belt, float(one)) for one in pulls), strict=True)
    gradient = np.stack(slopes)
    wrong = creep_error * np.array(slips)
    covariance = noise**2 * np.eye(_ADDED) + np.outer(wrong, wrong)
    assert gradient.shape == (_ADDED, len(BELT))
    return np.asarray(gradient.T @ np.linalg.solve(covariance, gradient))
