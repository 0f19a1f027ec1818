"""The two-pulley drive in steady state, against the paper's Table 2 and Figure 10."""

import math

import numpy as np
import pytest
from two_pulleys import PAPER_MASS, paper_drive

from belt_ros.mechanics import (
    Belt,
    BeltDrive,
    Kinematics,
    Pulley,
    Role,
    Tensioning,
    solve_arc,
    solve_equilibrium,
    torque_capacity,
)

TABLE_2 = [  # kf, T_L, T_H
    (2.7678e7, 156.2, 712.2),  # the kf_min that the paper prints as 2.8e7
    (2.8e7, 156.2, 712.2),
    (2e8, 155.1, 716.7),
    (8.1e9, 158.3, 707.1),
]


def paper_arcs(case: int, mass: float) -> tuple[float, float, float, float]:
    """Transition angles driven and driver, T_o and inlet strain of the driven pulley."""
    stiffness, slack, tight = TABLE_2[case]
    fixed = (0.08125, math.pi, 1.2, stiffness, 80068.0, mass, 9.75)
    driven = solve_arc(Role.DRIVEN, *fixed, slack, tight)
    driver = solve_arc(Role.DRIVER, *fixed, tight, slack)
    strain = float(driven.inlet_strain_gradient)
    return (
        float(driven.transition_angle),
        float(driver.transition_angle),
        slack - 80068.0 * strain,
        strain,
    )


@pytest.mark.parametrize(
    ("case", "driven", "driver"),
    [(0, 3.14, 2.34), (1, 3.125, 2.342), (2, 2.158, 2.082), (3, 1.934, 1.932)],
)
def test_table_2_angles_without_inertia(case: int, driven: float, driver: float) -> None:
    theta1, theta2, _, _ = paper_arcs(case, 0.0)
    digit = 0.5e-2 if case == 0 else 0.5e-3
    assert theta1 == pytest.approx(driven, abs=digit)
    assert theta2 == pytest.approx(driver, abs=digit)


@pytest.mark.parametrize(
    ("case", "driven", "driver"),
    [(0, 0.00, 0.80), (2, 0.98, 1.06), (3, 1.21, 1.21)],
)
def test_table_2_slip_arcs_without_inertia(case: int, driven: float, driver: float) -> None:
    theta1, theta2, _, _ = paper_arcs(case, 0.0)
    assert math.pi - theta1 == pytest.approx(driven, abs=0.5e-2)
    assert math.pi - theta2 == pytest.approx(driver, abs=0.5e-2)


@pytest.mark.parametrize(
    ("case", "driven", "driver"),
    [(1, 3.078, 2.298), (2, 2.115, 2.039), (3, 1.892, 1.890)],
)
def test_table_2_angles_with_the_belts_own_inertia(case: int, driven: float, driver: float) -> None:
    theta1, theta2, _, _ = paper_arcs(case, PAPER_MASS)
    assert theta1 == pytest.approx(driven, abs=0.5e-3)
    assert theta2 == pytest.approx(driver, abs=1e-3)


@pytest.mark.parametrize(
    ("case", "unstretched", "strain"),
    [(0, 146.4, 1.2e-4), (1, 146.6, 1.2e-4), (2, 155.1, 2.5e-7), (3, 158.3, 0.0)],
)
def test_table_2_inlet_strain_and_unstretched_tension(
    case: int, unstretched: float, strain: float
) -> None:
    _, _, tension, gradient = paper_arcs(case, 0.0)
    assert tension == pytest.approx(unstretched, abs=0.05)
    assert gradient == pytest.approx(strain, rel=0.03, abs=1e-20)


@pytest.mark.parametrize(("case", "printed"), [(0, 119.13), (2, 119.16), (3, 119.18)])
@pytest.mark.parametrize("mass", [0.0, PAPER_MASS])
def test_table_2_driven_speed_from_the_linear_kinematics(
    case: int, printed: float, mass: float
) -> None:
    stiffness, slack, tight = TABLE_2[case]
    drive = paper_drive(stiffness, mass, kinematics=Kinematics.LINEAR)
    state = solve_equilibrium(drive, (tight - slack) * 0.08125, 0.5 * (tight + slack), 120.0)
    assert float(state.driven_speed) == pytest.approx(printed, abs=0.005)
    if mass == 0.0:
        angles = (float(state.driven_transition_angle), float(state.driver_transition_angle))
        assert angles == pytest.approx(paper_arcs(case, mass)[:2], abs=1e-12)


@pytest.mark.parametrize("case", [1, 2, 3])
def test_table_2_tensions_from_the_torque_to_their_own_imbalance(case: int) -> None:
    stiffness, slack, tight = TABLE_2[case]
    state = solve_equilibrium(paper_drive(stiffness), 45.0, 0.5 * (tight + slack), 120.0)
    assert float(state.tight_tension) == pytest.approx(tight, rel=0.015)
    assert float(state.slack_tension) == pytest.approx(slack, rel=0.03)
    assert float(state.tight_tension - state.slack_tension) == pytest.approx(45.0 / 0.08125)


def slack_held(pulley_driven: Pulley, pulley_driver: Pulley) -> BeltDrive:
    return BeltDrive(
        Belt(80068.0), pulley_driven, pulley_driver, tensioning=Tensioning.CONSTANT_SLACK
    )


def test_figure_10_limits_of_elastic_creep_and_full_slip() -> None:
    drive = slack_held(*[Pulley(0.08125, math.pi, 1.2, 8.1e7)] * 2)
    tight = np.array([292.5, 293.5, 372.5, 373.5])
    state = solve_equilibrium(drive, (tight - 200.0) * 0.08125, 200.0, 120.0)
    np.testing.assert_array_equal(
        state.driver_transition_angle >= math.pi * (1 - 1e-15), [True, False, False, False]
    )
    np.testing.assert_array_equal(
        state.driven_transition_angle >= math.pi * (1 - 1e-15), [True, True, True, False]
    )
    full_slip = 200.0 + float(torque_capacity(drive, 200.0)) / 0.08125
    assert full_slip == pytest.approx(8675.0, abs=0.5)
