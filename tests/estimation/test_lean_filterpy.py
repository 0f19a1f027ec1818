"""filterpy without what it imports and we never use, and nothing of it lost."""

import subprocess
import sys

import pytest


def says(script: str) -> str:
    """What a fresh interpreter prints."""
    command = [sys.executable, "-c", script]
    return subprocess.run(command, capture_output=True, text=True, check=True, timeout=60).stdout


@pytest.mark.parametrize("module", ["scipy.stats", "scipy.ndimage"])
def test_estimation_starts_without_what_it_does_not_use(module: str) -> None:
    script = f"import sys, belt_ros.estimation; print('{module}' in sys.modules)"
    assert says(script) == "False\n"


@pytest.mark.parametrize("module", ["filterpy", "filterpy.stats"])
def test_the_statistics_of_filterpy_are_whole_for_who_asks(module: str) -> None:
    script = f"import belt_ros.estimation, {module}; print(filterpy.stats.gaussian(0, 0, 1))"
    assert float(says(script)) > 0.39


def test_a_filter_on_a_grid_moves_its_belief() -> None:
    script = """
import belt_ros.estimation
from filterpy.discrete_bayes import predict
print(*predict([0.0, 1.0, 0.0, 0.0], 1, [0.0, 1.0, 0.0]))
"""
    assert [float(share) for share in says(script).split()] == [0.0, 0.0, 1.0, 0.0]


def test_images_are_whole_for_who_asks() -> None:
    script = "import belt_ros.estimation, scipy.ndimage; print(scipy.ndimage.sum_labels([1, 2]))"
    assert float(says(script)) == 3.0


def test_a_filter_computes_its_likelihood() -> None:
    script = """
import belt_ros.estimation
from filterpy.kalman import KalmanFilter
from filterpy import kalman
filter = KalmanFilter(1, 1)
filter.H[:] = 1.0
filter.update(0.0)
print(filter.log_likelihood)
"""
    # One reading of variance 1 of a state of variance 1, where it was expected: ln(1/sqrt(4 pi)).
    assert abs(float(says(script)) + 1.2655121) < 1e-6


def test_it_is_the_class_that_everybody_else_imports() -> None:
    script = """
from belt_ros.estimation.lean_filterpy import UnscentedKalmanFilter
import filterpy.kalman
print(UnscentedKalmanFilter is filterpy.kalman.UnscentedKalmanFilter)
"""
    assert says(script) == "True\n"
