"""What was known of every moment with all the measurements, those that came later too.

A fixed-interval smoother behind the belt's filter. The filter's members are merged and dropped all
the time and cannot be traced back, so each mode of the filter (tension settled, or changing) has
one backward kernel, that of all its members together, see `backward`. Back through the kernels go
the members of the filter's *last* belief: knowledge that is half-open at the end stays so.

Their weights stay: a kernel is a distribution of the past for each state that follows, so the
weight of what follows goes back with it whatever the filter's belief looked like. Only where modes
change is a member split, into the parts that come from either mode, see `origins`. Kernels must not
be shared between modes: while nothing is known of a change of tension to come, the kernel of the
whole belief is that of a settled tension, and carries the tension after the change to the times
before it.
"""

from collections.abc import Iterator, Sequence
from contextlib import suppress
from enum import IntEnum
from types import TracebackType
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation.backward import (
    Kernel,
    composed,
    fading_kernel,
    identity,
    mapped,
    mode_weights,
    step_kernel,
)
from belt_ros.estimation.condensing import condensed
from belt_ros.estimation.gaussian_sum import Component
from belt_ros.estimation.origins import Origins, origins_of, traced
from belt_ros.estimation.process import Process
from belt_ros.estimation.tape import Record, Tape

_Floats = NDArray[np.float64]
_MODES = 2
_IN_MEMORY = 64_000_000  # [bytes]


class Members(NamedTuple):
    """The filter's members."""

    log_weights: _Floats  # (k,)
    changing: NDArray[np.int64]  # (k,) 0 or 1
    means: _Floats  # (k, n)
    covariances: _Floats  # (k, n, n)


class Moved(NamedTuple):
    """The same members after a step's motion, in the same order."""

    means: _Floats  # (k, n)
    covariances: _Floats  # (k, n, n)
    crosses: _Floats  # (k, n, n) covariance of faded (row) and moved states


class Smoothed(NamedTuple):
    """Belief of one moment."""

    stamp_ns: int
    belief: list[Component]


class _Kind(IntEnum):
    BLOCK = 0
    ORIGINS = 1
    BELIEF = 2


class Smoother:
    """Follow a filter forwards, then give its beliefs with hindsight, backwards.

    Memory stays flat: what is kept goes to a temporary file once it is large, some 5 kB for each
    block. A block ends at the first step in each `block_ns`, and where modes change.

    Parameters
    ----------
    anchor : ndarray
        State (n,) to which what fades returns.
    tension : int
        The state in which the modes of the filter differ.
    axes : sequence of int
        States along which members must be alike to be merged.
    block_ns : int
        Time [ns] between smoothed beliefs, at most.
    """

    def __init__(
        self, anchor: _Floats, tension: int, axes: Sequence[int], block_ns: int = 500_000_000
    ) -> None:
        self._anchor = anchor
        self._tension = tension
        self._axes = tuple(axes)
        self.block_ns = block_ns
        self._beliefs = 0
        self._tape = Tape(_IN_MEMORY)
        self.start(0)

    def __enter__(self) -> "Smoother":
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Remove what was kept."""
        with suppress(OSError):  # a full disk refuses the last bytes
            self._tape.close()

    @property
    def beliefs(self) -> int:
        """Number of beliefs that `smoothed` yields."""
        return self._beliefs

    def start(self, stamp_ns: int) -> None:
        """Begin a chain of steps at `stamp_ns`; call `cut` before to end another."""
        self._begun_ns = self._stamp_ns = stamp_ns
        self._kernels = [identity(len(self._anchor))] * _MODES
        self._steps = 0

    def step(
        self, stamp_ns: int, before: Members, processes: Sequence[Process], moved: Moved
    ) -> None:
        """Take in the filter's step to `stamp_ns`: `before` fades by its mode's process and moves.

        For every prediction that the filter went on from, whether or not it was updated.
        """
        for mode, process in enumerate(processes):
            weights = mode_weights(before.log_weights, before.changing, mode)
            if np.any(weights):
                faded = before.means, before.covariances, process.memory, self._anchor
                kernel = step_kernel(weights, *faded, process.covariance_before, *moved)
                self._kernels[mode] = composed(self._kernels[mode], kernel)
        self._advance(stamp_ns)

    def fade(self, stamp_ns: int, before: Members, processes: Sequence[Process]) -> None:
        """Take in that `before` fades without a motion that is known, as over a gap in the data.

        States whose memory is zero begin anew.
        """
        for mode, process in enumerate(processes):
            weights = mode_weights(before.log_weights, before.changing, mode)
            if np.any(weights):
                faded = before.means, before.covariances, process.memory, self._anchor
                kernel, _ = fading_kernel(weights, *faded, process.covariance_before)
                self._kernels[mode] = composed(self._kernels[mode], kernel)
        self._advance(stamp_ns)

    def switch(self, members: list[Component], came_from: Sequence[bool]) -> None:
        """Take in that `members` were in other modes just before: changing, or not.

        For every change of modes, in all members that there are after it.
        """
        self._close_block()
        origins = origins_of(members, came_from, self._tension)
        self._tape.append(Record(_Kind.ORIGINS, self._stamp_ns, np.ravel(np.stack(origins))))

    def cut(self, belief: list[Component]) -> None:
        """End a chain of steps at `belief`, with which what follows has nothing to do."""
        self._close_block()
        members = condensed(belief, self._axes)
        values = [
            np.concatenate([[c.log_weight, float(c.changing)], c.mean, np.ravel(c.covariance)])
            for c in members
        ]
        self._tape.append(Record(_Kind.BELIEF, self._stamp_ns, np.concatenate(values)))
        self._beliefs += 1

    def smoothed(self) -> Iterator[Smoothed]:
        """Yield beliefs of all ends of blocks, the newest first, after `cut` at the last of all.

        Around a gap there may be two of one stamp.
        """
        belief: list[Component] | None = None
        for record in self._tape.backwards():
            if record.kind == _Kind.BELIEF:
                belief = self._components(record.values)
                yield Smoothed(record.stamp_ns, belief)
                continue
            assert belief is not None, "cut() comes before smoothed()"
            if record.kind == _Kind.ORIGINS:
                origins = Origins(*record.values.reshape(-1, _MODES, _MODES))
                belief = condensed(traced(belief, origins, self._tension), self._axes)
            else:
                belief = _mapped(belief, self._unpacked(record.values))
                yield Smoothed(record.stamp_ns, belief)

    def _advance(self, stamp_ns: int) -> None:
        self._stamp_ns = stamp_ns
        self._steps += 1
        if stamp_ns // self.block_ns != self._begun_ns // self.block_ns:
            self._close_block()

    def _close_block(self) -> None:
        """Write the block up to now, and begin another."""
        if self._steps == 0:
            return
        values = np.concatenate([np.ravel(part) for kernel in self._kernels for part in kernel])
        self._tape.append(Record(_Kind.BLOCK, self._begun_ns, values))
        self._beliefs += 1
        self.start(self._stamp_ns)

    def _unpacked(self, values: _Floats) -> list[Kernel]:
        n = len(self._anchor)
        sizes = [n * n, n, n, n * n] * _MODES
        gain, centre, reference, spread = range(4)
        parts = np.split(values, np.cumsum(sizes)[:-1])
        return [
            Kernel(
                parts[at + gain].reshape(n, n),
                parts[at + centre],
                parts[at + reference],
                parts[at + spread].reshape(n, n),
            )
            for at in range(0, 4 * _MODES, 4)
        ]

    def _components(self, values: _Floats) -> list[Component]:
        n = len(self._anchor)
        return [
            Component(float(row[0]), row[2 : 2 + n], row[2 + n :].reshape(n, n), bool(row[1]))
            for row in values.reshape(-1, 2 + n + n * n)
        ]


def _mapped(belief: list[Component], kernels: list[Kernel]) -> list[Component]:
    """Members as they were, by the kernels of their modes."""
    return [
        Component(c.log_weight, *mapped(kernels[int(c.changing)], c.mean, c.covariance), c.changing)
        for c in belief
    ]
