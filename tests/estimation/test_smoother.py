"""The smoother behind small linear filters, against the textbook's and against an exact grid."""

import tracemalloc
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sums import moments

from belt_ros.estimation import smoother as smoother_module
from belt_ros.estimation.gaussian_sum import Component, normalised
from belt_ros.estimation.process import Process
from belt_ros.estimation.reduction import merge
from belt_ros.estimation.smoother import Members, Moved, Smoothed, Smoother

STEP_NS = 10_000_000
SCALES = np.array([100.0, 1e-5, 1.0])


def still(n: int, memory: float = 1.0, variance: float = 0.0) -> Process:
    return Process(np.full(n, memory), np.diag(np.full(n, variance)), np.zeros(n))


def members(belief: list[Component]) -> Members:
    return Members(
        np.array([c.log_weight for c in belief]),
        np.array([c.changing for c in belief], dtype=np.int64),
        np.stack([c.mean for c in belief]),
        np.stack([c.covariance for c in belief]),
    )


class Linear:
    """A Kalman filter of x' = F x + noise that shows its steps to a smoother."""

    def __init__(self, seed: int, smoother: Smoother | None) -> None:
        self.random = np.random.default_rng(seed)
        turn, _ = np.linalg.qr(self.random.standard_normal((3, 3)))
        self.f = SCALES[:, None] * turn * self.random.uniform(0.8, 1.0, 3) / SCALES
        self.q = np.diag([0.0, 0.01, 0.1]) * SCALES**2
        self.process = Process(
            np.array([1.0, 1.0, 0.9]),
            np.array([[0.0, 0.0, 0.0], [0.0, 0.1, -0.1], [0.0, -0.1, 0.2]])
            * np.outer(SCALES, SCALES),
            np.diag(self.q),
        )
        self.x, self.p = np.zeros(3), np.diag(SCALES**2)
        self.smoother = smoother
        self.stamp = 0
        self.past: list[tuple[np.ndarray, ...]] = []

    def belief(self) -> list[Component]:
        return [Component(0.0, self.x, self.p)]

    def step(self) -> None:
        before = members(self.belief())
        whole = self.f @ np.diag(self.process.memory)
        x, p = self.x, self.p
        faded = p * np.outer(self.process.memory, self.process.memory)
        faded = faded + self.process.covariance_before
        self.x, self.p = whole @ x, self.f @ faded @ self.f.T + self.q
        self.past.append((x, p, self.x, self.p, p @ whole.T))
        self.stamp += STEP_NS
        moved = Moved(self.x[None], self.p[None], (faded @ self.f.T)[None])
        if self.smoother is not None:
            self.smoother.step(self.stamp, before, (self.process, self.process), moved)
        self.update()

    def update(self) -> None:
        row = np.array([0.5, 1.0, -1.0]) / SCALES
        total = row @ self.p @ row + 0.3
        gain = self.p @ row / total
        self.x = self.x + gain * (self.random.standard_normal() - row @ self.x)
        left = np.eye(3) - np.outer(gain, row)
        self.p = left @ self.p @ left.T + 0.3 * np.outer(gain, gain)

    def textbook(self) -> list[tuple[np.ndarray, np.ndarray]]:
        """Rauch, Tung and Striebel's recursion, oldest first."""
        x, p = self.x, self.p
        found = [(x, p)]
        for before, covariance, predicted, spread, cross in self.past[::-1]:
            scale = np.outer(SCALES, SCALES)
            gain = cross @ (np.linalg.inv(spread / scale) / scale)
            x = before + gain @ (x - predicted)
            p = covariance + gain @ (p - spread) @ gain.T
            found.append((x, p))
        return found[::-1]


def three(block_ns: int) -> Smoother:
    return Smoother(np.zeros(3), 2, (2,), block_ns)


@given(st.integers(0, 2**32 - 1), st.sampled_from([1, 3, 7]))
@settings(derandomize=True, deadline=None, max_examples=25)
def test_at_block_ends_it_is_the_textbooks_smoother(seed: int, steps: int) -> None:
    with three(steps * STEP_NS) as smoother:
        linear = Linear(seed, smoother)
        for _ in range(20):
            linear.step()
        smoother.cut(linear.belief())
        found = list(smoother.smoothed())
    expected = linear.textbook()
    ends = {20, *range(0, 20, steps)}
    assert [smoothed.stamp_ns // STEP_NS for smoothed in found] == sorted(ends, reverse=True)
    for stamp_ns, belief in found:
        mean, covariance = moments(belief)
        x, p = expected[stamp_ns // STEP_NS]
        np.testing.assert_allclose(mean / SCALES, x / SCALES, rtol=0, atol=1e-9)
        scale = np.outer(SCALES, SCALES)
        np.testing.assert_allclose(covariance / scale, p / scale, rtol=0, atol=1e-9)


def test_what_follows_a_cut_says_nothing_of_before() -> None:
    with three(5 * STEP_NS) as smoother:
        first = Linear(1, smoother)
        for _ in range(12):
            first.step()
        smoother.cut(first.belief())
        alone = list(smoother.smoothed())
        second = Linear(2, smoother)
        second.stamp = 10**12
        smoother.start(second.stamp)
        for _ in range(12):
            second.step()
        smoother.cut(second.belief())
        both = list(smoother.smoothed())
    assert len(both) == 2 * len(alone)
    for mine, theirs in zip(both[len(alone) :], alone, strict=True):
        assert mine.stamp_ns == theirs.stamp_ns
        np.testing.assert_array_equal(mine.belief[0].mean, theirs.belief[0].mean)
        np.testing.assert_array_equal(mine.belief[0].covariance, theirs.belief[0].covariance)


def test_over_a_gap_what_fades_little_is_still_learned_from() -> None:
    """States that begin anew tell nothing; the last one kept 0.9 of its distance from 0."""
    memory, variance = np.array([0.0, 0.0, 0.9]), np.array([1.0, 1.0, 0.19]) * SCALES**2
    fading = Process(memory, np.diag(variance), np.zeros(3))
    before = [Component(0.0, SCALES, np.diag(SCALES**2))]
    after = [Component(0.0, SCALES * [5.0, 5.0, 2.0], 1e-4 * np.diag(SCALES**2))]
    with three(STEP_NS) as smoother:
        smoother.fade(10**10, members(before), (fading, fading))
        smoother.cut(after)
        last, first = smoother.smoothed()
    assert (last.stamp_ns, first.stamp_ns) == (10**10, 0)
    mean, covariance = moments(first.belief)
    np.testing.assert_allclose(mean / SCALES, [1.0, 1.0, 1.0 + 0.9 * 1.1], rtol=1e-12)
    expected = np.array([1.0, 1.0, 0.19 + 0.81e-4]) * SCALES**2
    np.testing.assert_allclose(np.diag(covariance), expected, rtol=1e-12)


def half_open() -> list[Component]:
    """Either of two narrow beliefs, four to one."""
    return [
        Component(np.log(0.8), np.array([1.0, -1.0, 0.0]) * SCALES, 0.01 * np.diag(SCALES**2)),
        Component(np.log(0.2), np.array([1.0, 1.0, 2.0]) * SCALES, 0.04 * np.diag(SCALES**2)),
    ]


def still_steps(smoother: Smoother, belief: list[Component], count: int) -> None:
    process = still(3)
    now = members(belief)
    moved = Moved(now.means, now.covariances, now.covariances)
    for k in range(count):
        smoother.step((k + 1) * STEP_NS, now, (process, process), moved)


def test_of_what_never_changes_the_last_belief_holds_at_all_times() -> None:
    """Wide beliefs on the way, and one at the end that is bimodal and stays so."""
    wide = [Component(0.0, np.zeros(3), np.diag(SCALES**2))]
    with three(10 * STEP_NS) as smoother:
        still_steps(smoother, wide, 500)
        smoother.cut(half_open())
        found = list(smoother.smoothed())
    assert len(found) == 51
    for _, belief in found:
        for member, expected in zip(belief, half_open(), strict=True):
            assert member.log_weight == expected.log_weight
            np.testing.assert_allclose(member.mean / SCALES, expected.mean / SCALES, atol=1e-9)
            scale = np.outer(SCALES, SCALES)
            np.testing.assert_allclose(
                member.covariance / scale, expected.covariance / scale, atol=1e-9
            )


def test_memory_stays_flat(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(smoother_module, "_IN_MEMORY", 100_000)
    wide = [Component(0.0, np.zeros(3), np.diag(SCALES**2))]

    def most_for(steps: int) -> int:
        with three(STEP_NS) as smoother:
            tracemalloc.start()
            still_steps(smoother, wide, steps)
            smoother.cut(wide)
            assert sum(1 for _ in smoother.smoothed()) == steps + 1
            _, most = tracemalloc.get_traced_memory()
            tracemalloc.stop()
        return most

    most_for(10)  # compiles
    assert most_for(4000) < most_for(1000) + 50_000


class Level(NamedTuple):
    """A level that stays, or drifts while it is changing, measured with noise."""

    drift: float = 0.05  # a step, while changing
    begins: float = 1e-3  # probability at each tenth step
    ends: float = 0.1
    noise: float = 0.15


GRID = np.linspace(-2.5, 1.5, 801)
STEPS = 300


def readings(level: Level, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """A level that falls from 0 to -1 in steps 141 to 160."""
    truth = -np.clip((np.arange(STEPS + 1) - 140) / 20.0, 0.0, 1.0)
    random = np.random.default_rng(seed)
    return truth, truth + level.noise * random.standard_normal(STEPS + 1)


def exact(level: Level, z: np.ndarray) -> np.ndarray:
    """Densities (steps + 1, 2 modes, grid) given all readings: forwards and backwards on a grid."""
    kernel = np.exp(-0.5 * ((GRID[:, None] - GRID) / level.drift) ** 2)
    kernel /= np.sum(kernel, axis=0)
    switch = np.array([[1 - level.begins, level.begins], [level.ends, 1 - level.ends]])
    likely = np.exp(-0.5 * ((z[:, None] - GRID) / level.noise) ** 2)
    ahead = np.empty((STEPS + 1, 2, len(GRID)))
    ahead[0] = np.outer([1 - level.begins, level.begins], np.exp(-0.5 * GRID**2))
    for k in range(1, STEPS + 1):
        now = np.stack([ahead[k - 1, 0], kernel @ ahead[k - 1, 1]]) * likely[k]
        now = switch.T @ now if k % 10 == 0 else now
        ahead[k] = now / np.sum(now)
    back = np.ones((2, len(GRID)))
    both = ahead.copy()
    for k in range(STEPS, 0, -1):
        back = (switch @ back if k % 10 == 0 else back) * likely[k]
        back = np.stack([back[0], kernel.T @ back[1]])
        back /= np.max(back)
        both[k - 1] *= back
    return both / np.sum(both, axis=(1, 2), keepdims=True)


def filtered(level: Level, z: np.ndarray, smoother: Smoother) -> list[Component]:
    """One Gaussian for each mode; shows its steps to `smoother` and returns the last belief."""
    belief = [
        Component(np.log1p(-level.begins), np.zeros(1), np.eye(1), changing=False),
        Component(np.log(level.begins), np.zeros(1), np.eye(1), changing=True),
    ]
    processes = still(1), still(1, variance=level.drift**2)
    for k in range(1, STEPS + 1):
        before = members(belief)
        for c in belief:
            c.covariance = c.covariance + processes[int(c.changing)].covariance_before
        now = members(belief)
        moved = Moved(now.means, now.covariances, now.covariances)
        smoother.step(k * STEP_NS, before, processes, moved)
        for c in belief:
            total = c.covariance[0, 0] + level.noise**2
            away = z[k] - c.mean[0]
            c.log_weight -= 0.5 * (away**2 / total + np.log(total))
            c.mean = c.mean + c.covariance[0] / total * away
            c.covariance = c.covariance * level.noise**2 / total
        if k % 10 == 0:
            parts = switched(level, belief)
            smoother.switch(parts, [False, True, False, True])
            belief = [merge(*parts[:2]), merge(*parts[2:])]
    return belief


def switched(level: Level, belief: list[Component]) -> list[Component]:
    """Parts that came from settled and changing: two that are settled, two that are changing."""
    rates = [[1 - level.begins, level.begins], [level.ends, 1 - level.ends]]
    return [
        Component(
            c.log_weight + np.log(rates[int(c.changing)][after]), c.mean, c.covariance, bool(after)
        )
        for after in (0, 1)
        for c in belief
    ]


def changing(smoothed: Smoothed) -> float:
    weights = normalised(np.array([c.log_weight for c in smoothed.belief]))
    return float(weights @ [c.changing for c in smoothed.belief])


@pytest.mark.parametrize("seed", range(4))
def test_a_change_is_seen_with_hindsight_as_exact_inference_sees_it(seed: int) -> None:
    level = Level()
    truth, z = readings(level, seed)
    densities = exact(level, z)
    with Smoother(np.zeros(1), 0, (0,), STEP_NS) as smoother:
        smoother.cut(filtered(level, z, smoother))
        found = list(smoother.smoothed())[::-1]
    for k in range(5, STEPS, 5):
        smoothed, density = found[k], np.sum(densities[k], axis=0)
        assert smoothed.stamp_ns == k * STEP_NS
        mean, covariance = moments(smoothed.belief)
        right = density @ GRID
        spread = np.sqrt(density @ (GRID - right) ** 2)
        assert abs(mean[0] - right) < 0.4 * spread
        assert 0.6 < np.sqrt(covariance[0, 0]) / spread < 1.5
        assert abs(changing(smoothed) - np.sum(densities[k, 1])) < 0.35
    for k in (20, 60, 240, 280):
        assert changing(found[k]) < 0.02
        assert abs(moments(found[k].belief)[0][0] - truth[k]) < 0.05
    assert min(changing(found[k]) for k in range(141, 160)) > 0.5
