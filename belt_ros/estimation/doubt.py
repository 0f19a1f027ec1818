"""What was believed before the sensors stopped fitting, and when to ask whether it still holds.

A sensor that is stuck, late or of the wrong scale bends what is believed of the belt, and narrows
it about the wrong place. Real changes surprise as well. Which of the two it was, the data say that
come when sensors fit again, if both are among the hypotheses: so the belief goes on as a mixture of
the present one, in which the belt has changed, and the one from before, aged, in which a sensor was
wrong. While sensors do not fit, that mixture is what is known.

A fault may come and go, or begin to fit once it has bent the belief enough. So what was believed
before the first of a row of misfits counts as well as what was believed before the last.
"""

import math
from collections import deque
from collections.abc import Callable, Sequence
from enum import Enum
from typing import NamedTuple

import numpy as np

from belt_ros.estimation.estimate import LostTraction
from belt_ros.estimation.gaussian_sum import Component

_SECONDS = 1e-9
_EVERY = 1.0  # [s] between snapshots, of which few are kept
_KEPT = 3
_OLD_ENOUGH = 1.0  # [s] before a misfit shows: it takes up to 0.7 s to
_ASKED_EVERY = 0.5, 5.0  # [s] while sensors do not fit: at first, at last, and in between ...
_ASKED_AFTER = 0.2  # ... this share of the time for which they have not
_DECIDED = 5.0  # [s] after which the data have decided ...
_NEGLIGIBLE = 1e-4  # ... against members of this weight
_ROW = 30.0  # [s] at most between misfits that belong together
_LEAST_CREDIT = 1e-12  # so that weights stay numbers
_PRESENT = 0.2  # probability that the belt has changed rather than a sensor: that surprises less


class Turn(Enum):
    """What a sample brings."""

    NONE = 0
    BEGINS = 1  # sensors no longer fit
    ASKS = 2  # do they fit what was believed before?
    DECIDES = 3  # they have fitted for long enough to know


class Snapshot(NamedTuple):
    """What was believed at a time."""

    stamp_ns: int
    belief: list[Component]
    lost_traction: LostTraction


class Doubt:
    """Keeps what was believed while sensors fitted."""

    def __init__(self) -> None:
        self._lasts = False
        self._undecided = False
        self._began_ns = 0  # the present misfit
        self._turned_ns = 0  # when it began, asked, ended or was decided
        self.forget()

    def forget(self) -> None:
        """Forget what was believed before: it does not hold any more, whoever was wrong."""
        self._recent: deque[Snapshot] = deque(maxlen=_KEPT)
        self._before: list[Snapshot] = []

    @property
    def before(self) -> list[Snapshot]:
        """What was believed before the first and the last of a row of misfits, if there is one."""
        return self._before

    def keep(
        self, stamp_ns: int, belief: Callable[[], list[Component]], lost_traction: LostTraction
    ) -> None:
        """Keep a belief of a time when sensors fit, if it is time for one."""
        if self._lasts:
            return
        if not self._recent or stamp_ns - self._recent[-1].stamp_ns >= _EVERY / _SECONDS:
            self._recent.append(Snapshot(stamp_ns, belief(), lost_traction))

    def turn(self, stamp_ns: int, *, misfit: bool) -> Turn:
        """Say what to do at a sample at which there is a misfit, or none."""
        turn = self._turn(stamp_ns, misfit=misfit)
        self._lasts = misfit
        if turn is Turn.NONE:
            return turn
        self._turned_ns = stamp_ns
        self._undecided = turn is not Turn.DECIDES
        if turn is Turn.BEGINS:
            self._began_ns = stamp_ns
            self._go_back(stamp_ns)
        return turn

    def _turn(self, stamp_ns: int, *, misfit: bool) -> Turn:
        if misfit and not self._lasts:
            return Turn.BEGINS
        if self._lasts and not misfit:
            return Turn.ASKS
        since = (stamp_ns - self._turned_ns) * _SECONDS
        if misfit:
            lasted = (stamp_ns - self._began_ns) * _SECONDS
            first, last = _ASKED_EVERY
            return Turn.ASKS if since >= min(max(_ASKED_AFTER * lasted, first), last) else Turn.NONE
        if self._undecided and since >= _DECIDED:
            return Turn.DECIDES
        if self._before and since >= _ROW:
            self._before = []
        return Turn.NONE

    def _go_back(self, stamp_ns: int) -> None:
        """Choose what was believed before a misfit that shows at `stamp_ns`."""
        latest = None
        for snapshot in self._recent:  # the oldest first
            if latest is None or (stamp_ns - snapshot.stamp_ns) * _SECONDS >= _OLD_ENOUGH:
                latest = snapshot
        self._recent.clear()
        if latest is not None:
            self._before = [*self._before[:1], latest]


def either(
    present: Sequence[Component],
    before: Sequence[Sequence[Component]],
    plausibility: Callable[[Sequence[Component]], float],
) -> list[Component]:
    """Return the belief that one of several holds: the present one, or one of those before.

    The present one has a probability of `_PRESENT`, or less where it is less plausible by itself
    than those before; these are as likely as each other.
    """
    if not before:
        return list(present)
    share = (1.0 - _PRESENT) / len(before)
    credit = plausibility(present) / max(plausibility(belief) for belief in before)
    mixed = _weighing(present, _PRESENT * min(max(credit, _LEAST_CREDIT), 1.0))
    for belief in before:
        mixed += _weighing(belief, share)
    return mixed


def decided(belief: Sequence[Component]) -> list[Component]:
    """Return a belief without what has next to no weight."""
    heaviest = max(member.log_weight for member in belief)
    return [m for m in belief if m.log_weight - heaviest > math.log(_NEGLIGIBLE)]


def _weighing(belief: Sequence[Component], weight: float) -> list[Component]:
    """Return a belief of a total weight."""
    total = float(np.logaddexp.reduce([member.log_weight for member in belief]))
    shift = math.log(weight) - total
    return [Component(m.log_weight + shift, m.mean, m.covariance, m.changing) for m in belief]
