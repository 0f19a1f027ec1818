"""Backward kernels against the textbook's smoother and filterpy's."""

from typing import NamedTuple

import numpy as np
import pytest
from filterpy.kalman import KalmanFilter
from hypothesis import given, settings
from hypothesis import strategies as st

from belt_ros.estimation.backward import (
    Kernel,
    Moments,
    backward_kernel,
    composed,
    fading_moments,
    identity,
    mapped,
    mixture_cross,
    mode_weights,
    step_kernel,
)
from belt_ros.estimation.gaussian_sum import mixture_moments

STEPS = 12
SCALES = 10.0 ** np.array([2.0, -5.0, 3.0, 0.0, -8.0])
SEEDS = st.integers(0, 2**32 - 1)


class Model(NamedTuple):
    """A linear system: x' = F x + noise Q, z = H x + noise R."""

    f: np.ndarray
    q: np.ndarray
    h: np.ndarray
    r: np.ndarray


class Filtered(NamedTuple):
    """A forward pass: after each update, and predicted to the one after."""

    means: np.ndarray
    covariances: np.ndarray
    joints: list[Moments]


def random_model(random: np.random.Generator, n: int = 5) -> Model:
    """A stable system of which not all states are driven by noise, nor measured."""
    orthogonal, _ = np.linalg.qr(random.standard_normal((n, n)))
    noise = random.standard_normal((n, n - 2))
    return Model(
        orthogonal * random.uniform(0.7, 1.0, n),
        0.1 * noise @ noise.T,
        random.standard_normal((2, n)),
        np.diag(random.uniform(0.1, 1.0, 2)),
    )


def scaled(model: Model, scales: np.ndarray) -> Model:
    return Model(
        scales[:, None] * model.f / scales,
        scales[:, None] * model.q * scales,
        model.h / scales,
        model.r,
    )


def filtered(model: Model, z: np.ndarray, p0: np.ndarray) -> Filtered:
    n = len(p0)
    x, p = np.zeros(n), p0
    means, covariances, joints = [], [], []
    for k, reading in enumerate(z):
        if k:
            predicted = model.f @ x, model.f @ p @ model.f.T + model.q
            joints.append(Moments(x, p, *predicted, p @ model.f.T))
            x, p = predicted
        gain = np.linalg.solve(model.h @ p @ model.h.T + model.r, model.h @ p).T
        x = x + gain @ (reading - model.h @ x)
        left = np.eye(n) - gain @ model.h
        p = left @ p @ left.T + gain @ model.r @ gain.T
        means.append(x)
        covariances.append(p)
    return Filtered(np.array(means), np.array(covariances), joints)


def textbook(run: Filtered) -> tuple[np.ndarray, np.ndarray]:
    """Rauch, Tung and Striebel's recursion, word for word."""
    means, covariances = run.means.copy(), run.covariances.copy()
    for k in range(len(means) - 2, -1, -1):
        joint = run.joints[k]
        gain = joint.cross @ np.linalg.inv(joint.later_covariance)
        means[k] += gain @ (means[k + 1] - joint.later_mean)
        covariances[k] += gain @ (covariances[k + 1] - joint.later_covariance) @ gain.T
    return means, covariances


def block(kernels: list[Kernel]) -> Kernel:
    whole = identity(len(kernels[0].centre))
    for kernel in kernels:
        whole = composed(whole, kernel)
    return whole


def correlation(covariance: np.ndarray, like: np.ndarray) -> np.ndarray:
    deviation = np.sqrt(np.diag(like))
    return covariance / np.outer(deviation, deviation)


def random_run(seed: int, scales: np.ndarray) -> tuple[Model, Filtered]:
    random = np.random.default_rng(seed)
    model = scaled(random_model(random), scales)
    return model, filtered(model, 3.0 * random.standard_normal((STEPS, 2)), np.diag(scales**2))


@given(SEEDS)
@settings(derandomize=True, deadline=None, max_examples=60)
def test_step_by_step_kernels_are_the_textbooks_smoother(seed: int) -> None:
    _, run = random_run(seed, np.ones(5))
    means, covariances = textbook(run)
    mean, covariance = run.means[-1], run.covariances[-1]
    for k in range(STEPS - 2, -1, -1):
        mean, covariance = mapped(backward_kernel(run.joints[k]), mean, covariance)
        np.testing.assert_allclose(mean, means[k], rtol=0, atol=1e-9)
        np.testing.assert_allclose(covariance, covariances[k], rtol=0, atol=1e-9)


@given(SEEDS)
@settings(derandomize=True, deadline=None, max_examples=60)
def test_a_block_of_steps_is_the_textbooks_smoother_whatever_the_scales(seed: int) -> None:
    _, run = random_run(seed, np.ones(5))
    means, covariances = textbook(run)
    _, uneven = random_run(seed, SCALES)
    for k in range(STEPS - 1):
        whole = block([backward_kernel(joint) for joint in uneven.joints[k:]])
        mean, covariance = mapped(whole, uneven.means[-1], uneven.covariances[-1])
        np.testing.assert_allclose(mean / SCALES, means[k], rtol=0, atol=1e-9)
        np.testing.assert_allclose(
            covariance / np.outer(SCALES, SCALES), covariances[k], rtol=0, atol=1e-9
        )


def test_kernels_agree_with_filterpys_smoother() -> None:
    model, run = random_run(3, np.ones(5))
    stock = KalmanFilter(5, 2)
    stock.F, stock.Q = model.f, model.q
    means, covariances, _, _ = stock.rts_smoother(run.means, run.covariances)
    whole = block([backward_kernel(joint) for joint in run.joints])
    mean, covariance = mapped(whole, run.means[-1], run.covariances[-1])
    np.testing.assert_allclose(mean, means[0], rtol=0, atol=1e-9)
    np.testing.assert_allclose(covariance, covariances[0], rtol=0, atol=1e-9)


@given(SEEDS, st.integers(0, 5), st.sampled_from([0.0, 1e-9, 1.0]))
@settings(derandomize=True, deadline=None, max_examples=200)
def test_the_spread_is_never_negative_even_of_impossible_moments(
    seed: int, rank: int, off: float
) -> None:
    random = np.random.default_rng(seed)
    root = random.standard_normal((10, rank))
    joint = root @ root.T
    cross = (joint[:5, 5:] + off * random.standard_normal((5, 5))) * np.outer(SCALES, SCALES)
    before = joint[:5, :5] * np.outer(SCALES, SCALES)
    kernel = backward_kernel(
        Moments(np.zeros(5), before, np.zeros(5), joint[5:, 5:] * np.outer(SCALES, SCALES), cross)
    )
    assert all(np.all(np.isfinite(part)) for part in kernel)
    np.testing.assert_array_equal(kernel.spread, kernel.spread.T)
    spread = kernel.spread / np.outer(SCALES, SCALES)
    assert np.min(np.linalg.eigvalsh(spread)) >= -1e-12 * max(np.trace(spread), 1e-300)
    if off == 0.0:  # what is left is no more than there was
        left = (before - kernel.spread) / np.outer(SCALES, SCALES)
        assert np.min(np.linalg.eigvalsh(left)) >= -1e-9 * max(np.trace(joint), 1.0)


def test_what_others_determine_takes_no_part() -> None:
    covariance = np.array([[4.0, 1.0], [1.0, 1.0]])
    twice = np.array([[1.0, 0.0], [0.0, 1.0], [1.0, 1.0]])  # the third is the sum of the others
    later = twice @ covariance @ twice.T
    joint = Moments(twice @ [1.0, 2.0], later, twice @ [1.0, 2.0], later, later)
    mean, spread = mapped(backward_kernel(joint), np.array([3.0, 1.0, 4.0]), np.zeros((3, 3)))
    np.testing.assert_allclose(mean, [3.0, 1.0, 4.0], atol=1e-12)
    np.testing.assert_allclose(spread, 0.0, atol=1e-13)


def test_what_is_renewed_in_a_step_says_nothing_of_before() -> None:
    covariance = np.array([[2.0, 0.5], [0.5, 1.0]])
    memory, anchor, variance = np.array([1.0, 0.0]), np.array([0.0, 7.0]), np.array([0.0, 3.0])
    joint = fading_moments(np.array([1.0, 2.0]), covariance, memory, anchor, np.diag(variance))
    kernel = backward_kernel(joint)
    np.testing.assert_array_equal(joint.later_mean, [1.0, 7.0])
    np.testing.assert_array_equal(kernel.gain[:, 1], 0.0)
    np.testing.assert_allclose(kernel.gain[:, 0], [1.0, 0.25], atol=1e-14)
    np.testing.assert_allclose(kernel.spread, [[0.0, 0.0], [0.0, 0.875]], atol=1e-14)


def test_a_state_that_does_not_change_is_the_same_before() -> None:
    random = np.random.default_rng(1)
    root = random.standard_normal((5, 5)) * SCALES[:, None]
    mean, covariance = SCALES * random.standard_normal(5), root @ root.T
    joint = fading_moments(mean, covariance, np.ones(5), np.zeros(5), np.zeros((5, 5)))
    kernels = [backward_kernel(joint)] * 1000
    later = SCALES * random.standard_normal(5)
    before, spread = mapped(block(kernels), later, np.zeros((5, 5)))
    np.testing.assert_allclose(before / SCALES, later / SCALES, rtol=0, atol=1e-9)
    np.testing.assert_allclose(correlation(spread, covariance), 0.0, atol=1e-9)


def test_the_cross_covariance_of_a_sum_is_that_of_its_joint_members() -> None:
    random = np.random.default_rng(4)
    weights = random.dirichlet(np.ones(3))
    roots, means = random.standard_normal((3, 10, 10)), random.standard_normal((3, 10))
    joints = roots @ roots.transpose(0, 2, 1)
    mean, covariance = mixture_moments(weights, means, joints)
    before, later, cross = mixture_cross(
        weights,
        np.ascontiguousarray(means[:, :5]),
        np.ascontiguousarray(means[:, 5:]),
        np.ascontiguousarray(joints[:, :5, 5:]),
    )
    np.testing.assert_allclose(np.concatenate([before, later]), mean, rtol=1e-12)
    np.testing.assert_allclose(cross, covariance[:5, 5:], rtol=1e-12)


def test_a_step_that_fades_and_moves_has_the_kernel_of_the_two_together() -> None:
    model, run = random_run(5, SCALES)
    mean, covariance = run.means[-1], run.covariances[-1]
    memory = np.array([1.0, 0.9, 0.3, 0.0, 1.0])
    root = np.diag([0.0, 0.4, 1.0, 1.4, 0.0])
    root[1, 2:4] = 0.3, -0.5  # what is gained goes together
    anchor, gained = SCALES, root @ root.T * np.outer(SCALES, SCALES)
    faded = fading_moments(mean, covariance, memory, anchor, gained)
    moved = model.f @ faded.later_mean, model.f @ faded.later_covariance @ model.f.T + model.q
    at_once = model.f @ np.diag(memory)
    expected = backward_kernel(Moments(mean, covariance, *moved, covariance @ at_once.T))
    kernel = step_kernel(
        np.ones(1),
        mean[None],
        covariance[None],
        memory,
        anchor,
        gained,
        moved[0][None],
        moved[1][None],
        (faded.later_covariance @ model.f.T)[None],
    )
    later = np.linspace(-1.0, 1.0, 5) * SCALES
    for mine, theirs in zip(
        mapped(kernel, later, moved[1]), mapped(expected, later, moved[1]), strict=True
    ):
        scale = SCALES if mine.ndim == 1 else np.outer(SCALES, SCALES)
        np.testing.assert_allclose(mine / scale, theirs / scale, rtol=0, atol=1e-9)


def test_members_of_one_mode_are_weighed_among_themselves() -> None:
    log_weights = np.array([0.0, -2000.0, -2000.0 + np.log(3.0), -5.0])
    modes = np.array([0, 1, 1, 0])
    assert mode_weights(log_weights, modes, 1) == pytest.approx([0.0, 0.25, 0.75, 0.0])
    assert np.sum(mode_weights(log_weights, modes, 0)) == pytest.approx(1.0)
    np.testing.assert_array_equal(mode_weights(log_weights, modes, 2), 0.0)
