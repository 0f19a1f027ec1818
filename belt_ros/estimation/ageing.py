"""An earlier belief, brought to the present: what the belt is has aged, what moves is as now."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation.gaussian_sum import Component
from belt_ros.estimation.process import Process
from belt_ros.estimation.state import Index

_Floats = NDArray[np.float64]
BELT = slice(Index.LOG_TENSION, Index.UNDEVELOPED)  # the belt, and how far the model is off
MOTION = [place for place in Index if not Index.LOG_TENSION <= place <= Index.CREEP_ERROR]
_AMONG_MOTION = np.ix_(MOTION, MOTION)


def aged(
    belief: Sequence[Component],
    processes: tuple[Process, Process],
    changes: float,
    prior_mean: _Floats,
) -> list[Component]:
    """Return what a belief has become without data, its motion left as it was.

    Parameters
    ----------
    belief : sequence of Component
        Over the state.
    processes : tuple of Process
        What the time between adds while traction is settled, and while it is changing.
    changes : float
        How often traction is expected to have begun to change meanwhile; for each settled member
        there is then another that has.
    prior_mean : ndarray
        (12,)
    """
    out = [_faded(member, processes[int(member.changing)], prior_mean) for member in belief]
    begun = -math.expm1(-changes)
    if begun > 0.0:
        for member in belief:
            if not member.changing:
                weight = member.log_weight + math.log(begun)
                changed = Component(weight, member.mean, member.covariance, changing=True)
                out.append(_faded(changed, processes[1], prior_mean))
    return out


def _faded(member: Component, process: Process, prior_mean: _Floats) -> Component:
    memory = np.ones(len(prior_mean))
    memory[BELT] = process.memory[BELT]
    gained = np.zeros_like(process.covariance_before)
    gained[BELT, BELT] = process.covariance_before[BELT, BELT]
    mean = prior_mean + memory * (member.mean - prior_mean)
    covariance = np.outer(memory, memory) * member.covariance + gained
    return Component(member.log_weight, mean, covariance, member.changing)


def in_motion(belief: Sequence[Component], x: _Floats, covariance: _Floats) -> list[Component]:
    """Return a belief of the belt with what moves as in `x` (12,) and `covariance` (12, 12)."""
    return [
        Component(member.log_weight, *_moving(member, x, covariance), member.changing)
        for member in belief
    ]


def _moving(member: Component, x: _Floats, covariance: _Floats) -> tuple[_Floats, _Floats]:
    mean, around = x.copy(), np.zeros_like(covariance)
    mean[BELT] = member.mean[BELT]
    around[_AMONG_MOTION] = covariance[_AMONG_MOTION]
    around[BELT, BELT] = member.covariance[BELT, BELT]
    return mean, around
