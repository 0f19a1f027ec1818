"""The curve of slip against load as measured: a few dozen loads, each the mean of its blocks."""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from belt_ros.identify.blocks import Block, merged

_Floats = NDArray[np.float64]
_LOADS = 40  # into which the range of pulls is divided
_LIFT_STEP = 0.02  # prior tensions by which m v^2 may differ within one load
_NEAREST = 1e-3  # of the prior tension: no load is finer than this
_FINE = 0.005  # prior tensions within which pulls are one load, while a run is long
_COMPACT = 4000  # blocks kept before they are merged


class Curve(NamedTuple):
    """Loads (n,), by rising pull."""

    slip: _Floats  # [-]
    slip_stddev: _Floats
    pull: _Floats  # along the rotation [N]
    pull_stddev: _Floats
    speed: _Floats  # of the belt [m/s]

    def widened(self, factor: float) -> "Curve":
        """Return the curve with its deviations times `factor`."""
        return self._replace(
            slip_stddev=factor * self.slip_stddev, pull_stddev=factor * self.pull_stddev
        )


def curve_of(blocks: Iterable[Block], tension: float, mass: float) -> tuple[Curve, list[Block]]:
    """Return the curve, and blocks that show how far those of one load agree.

    Parameters
    ----------
    blocks : iterable of Block
        Of a long run, those of one load that follow each other are merged in pairs, so that memory
        stays flat.
    tension : float
        Scale of tensions [N].
    mass : float
        Of the belt per length [kg/m].
    """
    kept: list[Block] = []
    limit = _COMPACT
    for block in blocks:
        kept.append(block)
        if len(kept) >= limit:
            kept = _halved(kept, tension, mass)
            limit = max(_COMPACT, 2 * len(kept))
    if not kept:
        return Curve(*np.empty((5, 0))), []
    step = max(max(abs(block.pull) for block in kept) / _LOADS, _NEAREST * tension)
    numbers = np.array(merged(kept, step, _LIFT_STEP * tension, max(mass, 1e-12)))
    table = np.array(kept)
    rows = [_mean(table[numbers == number]) for number in range(int(numbers.max()) + 1)]
    return Curve(*np.array(rows).T), kept


def _halved(blocks: list[Block], tension: float, mass: float) -> list[Block]:
    """Return blocks of one load, two that follow each other made one."""
    same: dict[int, list[Block]] = {}
    numbers = merged(blocks, _FINE * tension, _LIFT_STEP * tension, max(mass, 1e-12))
    for number, block in zip(numbers, blocks, strict=True):
        same.setdefault(number, []).append(block)
    halved = []
    for row in same.values():
        pairs = (row[at : at + 2] for at in range(0, len(row), 2))
        halved += [Block(*_mean(np.array(pair))) for pair in pairs]
    return halved


def _mean(rows: _Floats) -> tuple[float, ...]:
    """Mean of blocks by the weights of their slips; deviations as if they were independent."""
    weights = rows[:, 1] ** -2.0
    weights /= np.sum(weights)
    spread = np.sqrt(weights**2 @ rows[:, [1, 3]] ** 2)
    slip, pull, speed = weights @ rows[:, [0, 2, 4]]
    return float(slip), float(spread[0]), float(pull), float(spread[1]), float(speed)
