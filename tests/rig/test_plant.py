"""The plant is a belt drive: equilibrium, energy, gross slip, reversal, regeneration."""

import dataclasses
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from belt_ros.estimation import Phase
from belt_ros.mechanics import solve_equilibrium
from belt_ros.rig import RigSample, Truth
from belt_ros.settings import DriveSettings, load_settings

Run = Callable[..., list[RigSample]]


def column(samples: list[RigSample], name: str) -> np.ndarray:
    return np.array([getattr(sample.truth, name) for sample in samples])


def all_numbers_finite(samples: list[RigSample]) -> bool:
    for sample in samples:
        _, *quantities = dataclasses.astuple(sample.truth)
        _, *joints = sample.joints
        if not np.all(np.isfinite([*quantities, *(value for pair in joints for value in pair)])):
            return False
    return True


@pytest.mark.parametrize("load", [5.0, 30.0, 45.0, 60.0, -30.0])
def test_steady_state_is_the_equilibrium(run: Run, settings: DriveSettings, load: float) -> None:
    last = run(duration=2.0, speed=120.0, load=[[0.0, 0.0], [0.5, load]])[-1].truth

    steady = solve_equilibrium(settings.drive, load, settings.prior.tension, last.driver_speed)
    assert last.driver_speed == pytest.approx(120.0, abs=1e-3)
    assert last.slip == pytest.approx(float(steady.slip), abs=1e-6)
    assert last.transmitted_torque == pytest.approx(load, rel=1e-6)
    assert last.tight_tension == pytest.approx(float(steady.tight_tension), rel=1e-6)
    assert last.margin == pytest.approx(float(steady.margin), abs=1e-6)
    assert last.excess_slip == pytest.approx(0.0, abs=1e-6)


def test_run_starts_in_the_steady_state(run: Run) -> None:
    samples = run(duration=1.0, speed=120.0, load=45.0)

    assert column(samples, "driver_speed") == pytest.approx(120.0, abs=1e-6)
    assert np.ptp(column(samples, "slip")) < 1e-7


def test_stretchy_belt_reaches_its_equilibrium(run: Run, root: Path) -> None:
    settings = load_settings(root / "config" / "exudyn_flat_belt.yaml")
    last = run(settings, duration=4.0, speed=100.0, load=[[0.2, 0.0], [0.5, 20.0]])[-1].truth

    steady = solve_equilibrium(settings.drive, 20.0, settings.prior.tension, last.driver_speed)
    assert last.slip == pytest.approx(float(steady.slip), abs=1e-6)


def test_ratio_bias_and_creep_error_appear_in_what_sensors_see(run: Run) -> None:
    common = {"duration": 2.0, "speed": 120.0, "load": 30.0}
    exact = run(**common)[-1].truth
    other = run(**common, condition__ratio_bias=1e-3, condition__creep_error=0.1)[-1].truth

    assert other.slip == pytest.approx(1.1 * exact.slip, rel=1e-3)
    ratio = other.driven_speed / exact.driven_speed
    assert ratio == pytest.approx((1.0 - other.slip) / (1.0 - exact.slip) / 1.001, rel=1e-6)


def test_energy_put_in_is_kinetic_elastic_or_lost_to_slip(
    run: Run, settings: DriveSettings
) -> None:
    drive = settings.drive
    rate = 5000.0
    samples = run(
        duration=2.0,
        sample_rate=rate,
        speed=[[0.0, 0.0], [0.5, 60.0]],
        load=[[0.8, 0.0], [1.0, 45.0]],
    )
    speeds = column(samples, "driver_speed"), column(samples, "driven_speed")
    torques = column(samples, "driver_torque"), column(samples, "driven_torque")
    pull = column(samples, "pull")
    work = sum(
        np.sum(torque[1:] * speed[1:]) for torque, speed in zip(torques, speeds, strict=True)
    )
    lost = np.sum(pull[1:] * np.diff(column(samples, "accumulated_slip")))
    kinetic = 0.5 * (drive.driver.inertia * speeds[0][-1] ** 2)
    kinetic += 0.5 * (drive.driven.inertia * speeds[1][-1] ** 2)

    assert lost > 0.0
    assert work / rate == pytest.approx(kinetic + lost, rel=2e-3)


def overload(run: Run, **more: object) -> list[RigSample]:
    return run(
        duration=3.0,
        speed=120.0,
        load=30.0,
        events=[
            {"at": 0.5, "load": 75.0, "over": 0.05},
            {"at": 1.0, "load": 30.0, "over": 0.05},
            *more.pop("events", []),
        ],
        **more,
    )


def at(samples: list[RigSample], time: float) -> Truth:
    return next(sample.truth for sample in samples if sample.stamp_ns >= time * 1e9)


def test_overload_slips_and_the_belt_grips_again(run: Run) -> None:
    samples = overload(run)

    assert at(samples, 0.45).phase is Phase.RUNNING
    assert at(samples, 0.9).phase is Phase.GROSS_SLIP
    assert at(samples, 0.9).gross_slip
    assert at(samples, 0.9).slip > 0.2
    assert at(samples, 2.9).phase is Phase.RUNNING
    assert at(samples, 2.9).excess_slip == pytest.approx(0.0, abs=1e-5)
    assert all_numbers_finite(samples)


def test_stalled_brake_does_not_turn_the_pulley_back(run: Run) -> None:
    samples = run(
        duration=3.0, speed=120.0, load=20.0, events=[{"at": 0.5, "load": 500.0, "over": 0.05}]
    )

    driven = column(samples, "driven_speed")
    assert driven[-1] == pytest.approx(0.0, abs=1.0)
    assert np.min(driven) > -0.1
    assert all_numbers_finite(samples)


@pytest.mark.parametrize("tension", [150.0, 30.0, 900.0])
def test_tension_may_change_during_gross_slip(run: Run, tension: float) -> None:
    samples = overload(run, events=[{"at": 0.7, "tension": tension, "over": 0.1}])

    assert all_numbers_finite(samples)
    assert np.max(np.abs(column(samples, "driven_speed"))) < 150.0
    assert samples[-1].truth.mean_tension == pytest.approx(tension)


def test_lost_friction_takes_the_reserve(run: Run) -> None:
    samples = run(
        duration=2.0,
        speed=120.0,
        load=30.0,
        events=[{"at": 1.0, "friction_coefficient": 0.35, "over": 0.2}],
    )

    assert at(samples, 0.9).margin > 0.5
    assert at(samples, 1.9).margin < 0.2


def test_reverse_rotation_mirrors_forward_rotation(run: Run) -> None:
    def script(sign: float) -> list[RigSample]:
        speed = [[0.0, 0.0], [1.0, sign * 100.0]]
        return run(duration=2.0, speed=speed, load=[[1.2, 0.0], [1.3, 40.0]])

    forward, reverse = script(1.0), script(-1.0)

    for name in ("driver_speed", "driven_speed", "driver_torque", "transmitted_torque"):
        np.testing.assert_allclose(column(reverse, name), -column(forward, name), atol=1e-9)
    np.testing.assert_allclose(column(reverse, "slip"), column(forward, "slip"), atol=1e-9)
    assert reverse[-1].truth.phase is Phase.REVERSE


def test_load_that_drives_makes_the_motor_brake(run: Run) -> None:
    last = run(duration=2.0, speed=100.0, load=-30.0)[-1].truth

    assert last.phase is Phase.REGENERATING
    assert last.slip < 0.0
    assert last.driver_torque < 0.0


def test_load_of_fixed_direction_does_not_turn_with_the_rotation(run: Run) -> None:
    last = run(duration=2.0, speed=-100.0, load=30.0, load_direction="fixed")[-1].truth

    assert last.driven_torque == pytest.approx(-30.0)
    assert last.phase is Phase.REGENERATING


def test_motor_torque_stays_within_its_limit(run: Run) -> None:
    samples = run(duration=2.0, speed=[[0.1, 0.0], [0.2, 100.0]], motor__torque_limit=20.0)

    assert np.max(np.abs(column(samples, "driver_torque"))) == pytest.approx(20.0)
    assert samples[-1].truth.driver_speed == pytest.approx(100.0, rel=0.01)


def test_creep_error_wanders_as_told(run: Run) -> None:
    samples = run(
        duration=60.0,
        sample_rate=10.0,
        condition__creep_error=0.02,
        condition__creep_error_stddev=0.01,
        condition__creep_error_time=0.5,
    )

    error = column(samples, "creep_model_error")
    assert np.mean(error) == pytest.approx(0.02, abs=0.004)
    assert np.std(error) == pytest.approx(0.01, rel=0.3)


def test_step_is_short_enough(run: Run) -> None:
    """Halving the step, as a higher sample rate does, changes nothing that matters."""
    script = {"duration": 1.0, "speed": 120.0, "load": [[0.2, 0.0], [0.3, 50.0]]}

    coarse = run(**script, sample_rate=100.0)
    fine = run(**script, sample_rate=10_000.0)[::100]

    np.testing.assert_allclose(
        column(coarse, "driver_speed"), column(fine, "driver_speed"), atol=0.1
    )
    np.testing.assert_allclose(column(coarse, "slip"), column(fine, "slip"), atol=1e-4)
