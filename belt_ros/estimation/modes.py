"""How members change between their modes: traction is settled, or it is changing.

A member in which traction is changing gives every loss of it a hypothesis to be explained by,
before slower quantities are bent to explain it.
"""

import math
from collections.abc import Sequence

import numpy as np

from belt_ros.estimation.condensing import condensed
from belt_ros.estimation.gaussian_sum import Component, normalised

_BRANCH_WHILE_SETTLED = 1.0  # [s]; traction is unlikely to be changing
_BRANCH_WHILE_CHANGING = 0.1  # [s]
_BRANCHES = 6  # members, at most, in which a mode changes into the other
UNLIKELY = 0.02  # weight of a mode, below which it is held by no more members than that
_CHANGE_END_RATE = 0.5  # at which a change of traction ends [1/s]


def due(components: list[Component], elapsed: float) -> bool:
    """Whether members should change modes, `elapsed` [s] after some last did.

    It is so as soon as a mode has no member left. While traction may be changing, it may come to
    rest at any moment: members that rest foretell readings far better than those that change, and
    one that came to rest too early or with too little lost would be all that is left to believe,
    had those that are right to wait for their turn.
    """
    if all(component.changing is components[0].changing for component in components):
        return True
    settled = _share_changing(components) < UNLIKELY
    return elapsed >= (_BRANCH_WHILE_SETTLED if settled else _BRANCH_WHILE_CHANGING)


def _share_changing(components: list[Component]) -> float:
    weights = normalised(np.array([component.log_weight for component in components]))
    return float(np.sum(weights[[component.changing for component in components]]))


def parted(components: list[Component]) -> tuple[list[Component], list[Component]]:
    """Part members into those of modes that are likely, and those of one that is not."""
    share = _share_changing(components)
    if UNLIKELY <= share <= 1.0 - UNLIKELY:
        return components, []
    unlikely = share < UNLIKELY
    return (
        [component for component in components if component.changing is not unlikely],
        [component for component in components if component.changing is unlikely],
    )


def few(components: list[Component], axes: Sequence[int]) -> list[Component]:
    """Return few members in place of those of an unlikely mode, of the same mean and covariance."""
    return condensed(components, axes, _BRANCHES) if len(components) > _BRANCHES else components


def branched(
    components: list[Component], elapsed: float, begin_rate: float, axes: Sequence[int]
) -> tuple[list[Component], list[bool]]:
    """Let members of the best one's mode change into the other.

    Parameters
    ----------
    components : list of Component
        Their weights change in place.
    elapsed : float
        [s] since members last changed modes.
    begin_rate : float
        At which traction begins to change [1/s].
    axes : sequence of int
        Along which members that change are told apart.

    Returns
    -------
    components : list of Component
        With those that have changed.
    came_from : list of bool
        The mode that each was in.
    """
    best = max(components, key=lambda component: component.log_weight)
    begun, ended = begin_rate * elapsed, _CHANGE_END_RATE * elapsed
    leaving = math.log(-math.expm1(-(ended if best.changing else begun)))
    branches = _branches(components, leaving, axes, changing=best.changing)
    came_from = [component.changing for component in components]
    came_from += [best.changing] * len(branches)
    for component in components:
        component.log_weight -= ended if component.changing else begun
    return components + branches, came_from


def _branches(
    components: list[Component], log_share: float, axes: Sequence[int], *, changing: bool
) -> list[Component]:
    """Return the share of a mode that changes into the other: few members, as wide as all."""
    mode = [component for component in components if component.changing is changing]
    return [
        Component(c.log_weight + log_share, c.mean, c.covariance, not changing)
        for c in condensed(mode, axes, _BRANCHES)
    ]
