"""Drives, histories and meshes that the finite element belt cannot run are refused."""

import math
from dataclasses import replace
from typing import Any

import pytest
from finite_elements import INSTALLED, RADIUS, make_drive

from belt_ros.mechanics import DriveError
from belt_ros.mechanics.finite_element import History, simulate
from belt_ros.mechanics.finite_element_mesh import Discretisation, open_belt

STILL = History([0.0, 0.01], [0.0, 0.0], [0.0, 0.0])


@pytest.mark.parametrize("tension", [0.0, -1.0, math.nan])
def test_belt_without_tension_is_refused(tension: float) -> None:
    with pytest.raises(DriveError, match="installed tension"):
        simulate(make_drive(), STILL, tension)


def test_massless_belt_is_refused() -> None:
    with pytest.raises(DriveError, match="mass per length"):
        simulate(make_drive().without_inertia(), STILL, INSTALLED)


@pytest.mark.parametrize(("speed", "why"), [(1.2e4, "critical speed"), (-900.0, "lifts off")])
def test_too_fast_a_belt_is_refused(speed: float, why: str) -> None:
    fast = History([0.0, 0.01], [0.0, speed], [0.0, 0.0])
    with pytest.raises(DriveError, match=why):
        simulate(make_drive(), fast, INSTALLED)


def test_wraps_that_are_not_an_open_belts_are_refused() -> None:
    drive = make_drive()
    crossed = replace(drive, driver=replace(drive.driver, wrap_angle=3.5))
    with pytest.raises(DriveError, match=r"open belt.*3\.14159"):
        simulate(crossed, STILL, INSTALLED)


def test_overlapping_pulleys_are_refused() -> None:
    with pytest.raises(DriveError, match="overlap"):
        simulate(replace(make_drive(), span_length=0.1), STILL, INSTALLED)
    with pytest.raises(DriveError, match="overlap"):
        open_belt(0.1, 0.1, 0.2)


def test_span_of_few_elements_is_refused() -> None:
    near = replace(make_drive(), span_length=2.0 * RADIUS + 0.01)
    with pytest.raises(DriveError, match="more elements"):
        simulate(near, STILL, INSTALLED, Discretisation(6))


@pytest.mark.parametrize(
    ("rows", "why"),
    [
        (([0.0, 0.0], [0.0, 0.0], [0.0, 0.0]), "does not increase after 0 s"),
        (([0.0, 1.0, 0.5], [0.0] * 3, [0.0] * 3), "does not increase after 1 s"),
        (([0.0, 1.0], [0.0, math.nan], [0.0, 0.0]), "NaN"),
        (([0.0, 1.0], [0.0, 0.0], [0.0, math.inf]), "NaN or infinity"),
        (([0.0, 1.0], [0.0], [0.0, 0.0]), "three rows"),
        (([0.0], [0.0], [0.0]), "three rows"),
    ],
)
def test_impossible_history_is_refused(rows: Any, why: str) -> None:
    with pytest.raises(DriveError, match=why):
        History(*rows)


@pytest.mark.parametrize(
    ("changed", "why"),
    [
        ({"elements_per_half_pulley": 3}, "too coarse"),
        ({"penalty_ratio": 0.0}, "penalty ratio"),
        ({"axial_damping": 0.0}, r"axial_damping is 0; .* >= 0\.05"),
        ({"contact_damping": -0.1}, "contact_damping"),
        ({"span_damping": math.nan}, "span_damping"),
    ],
)
def test_impossible_discretisation_is_refused(changed: dict[str, Any], why: str) -> None:
    with pytest.raises(DriveError, match=why):
        Discretisation(**changed)


@pytest.mark.parametrize(
    ("duration", "interval", "n", "why"),
    [
        (0.01, 1e-3, 10_000, "elements exceed"),
        (0.01, 0.1, 30, "less than one sampling interval"),
        (20.0, 1e-5, 30, "samples exceed"),
        (20.0, 20.0, 30, "shorter interval"),
        (900.0, 1e-2, 100, "shorter history"),
    ],
)
def test_too_large_a_run_is_refused(duration: float, interval: float, n: int, why: str) -> None:
    history = History([0.0, duration], [0.0, 0.0], [0.0, 0.0])
    with pytest.raises(DriveError, match=why):
        simulate(make_drive(), history, INSTALLED, Discretisation(n), sampling_interval=interval)
