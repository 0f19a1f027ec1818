"""The life campaign: its scripts do what they say, and it counts what it should."""

import math

import numpy as np
import pytest

from belt_ros.estimation import Measurement, Phase
from belt_ros.rig import Truth
from benchmarks.estimation import store
from benchmarks.estimation.cells import BELTS, cell_settings
from benchmarks.estimation.life import FORM, RATE, Watch, jobs, life_samples, run_script
from benchmarks.estimation.life_report import life_files, life_sections
from benchmarks.estimation.life_scripts import DURATION, SCRIPTS, Script

BY_NAME = {script.name: script for script in SCRIPTS}
Run = list[tuple[Measurement, Truth]]
RIGHT, WRONG = np.zeros(5), np.full(5, 3.0)


def played(name: str, seed: int = 0) -> tuple[Run, Run]:
    """Return the samples during the phase, and those after it."""
    script = BY_NAME[name]
    run = list(life_samples(script, cell_settings(script.cell(seed)), seed))
    begin, end = script.span
    during = [s for s in run if begin <= s[0].stamp_ns * 1e-9 < end]
    return during, [s for s in run if s[0].stamp_ns * 1e-9 >= end]


def phases(run: Run) -> set[Phase]:
    return {truth.phase for _, truth in run}


def test_every_phase_ends_in_time_to_see_what_follows() -> None:
    assert len(BY_NAME) == len(SCRIPTS)
    for script in SCRIPTS:
        begin, end = script.span
        assert 0.0 < begin < end <= DURATION - 2.0


def test_seeds_take_belts_stiffnesses_and_noises_in_turn() -> None:
    cells = {SCRIPTS[0].cell(seed) for seed in range(20)}
    assert {cell.belt for cell in cells} == set(BELTS)
    assert {cell.noise for cell in cells} == {"fine", "coarse"}
    assert len(cells) > 15


@pytest.mark.parametrize("seed", range(3))  # each belt
def test_phases_are_what_they_are_called(seed: int) -> None:
    standing, _ = played("standstill", seed)
    assert np.mean([truth.phase is Phase.STANDSTILL for _, truth in standing]) > 0.8
    slipping, recovered = played("gross slip", seed)
    assert Phase.GROSS_SLIP in phases(slipping)
    assert phases(recovered[-50:]) == {Phase.RUNNING}
    assert Phase.REGENERATING in phases(played("regeneration", seed)[0])
    assert phases(played("reversal", seed)[1]) == {Phase.REVERSE}


@pytest.mark.parametrize("seed", range(3))
def test_the_motor_does_nothing_while_the_drive_coasts(seed: int) -> None:
    during, _ = played("coasting", seed)
    before, _ = played("steady running", seed)
    idle = np.median([abs(truth.driver_torque) for _, truth in during])
    assert idle < 0.05 * np.median([abs(truth.driver_torque) for _, truth in before])


def test_lost_tension_is_lost_and_the_belt_still_holds() -> None:
    during, after = played("tension loss")
    assert during[-1][1].mean_tension == pytest.approx(0.6 * during[0][1].mean_tension, rel=0.05)
    assert min(truth.margin for _, truth in during + after) > 0.05


def test_sensors_are_missing_during_the_phase_only() -> None:
    for name in ("load torque missing", "both torques missing", "a speed missing"):
        during, after = played(name)
        for field in BY_NAME[name].missing:
            assert all(math.isnan(getattr(measurement, field)) for measurement, _ in during)
            assert not any(math.isnan(getattr(measurement, field)) for measurement, _ in after)
    assert played("gap")[0] == []


def watched(inside: list[bool]) -> Watch:
    """Watch samples from 1 s on, of a phase that ends at 2 s."""
    watch = Watch((1.0, 2.0))
    for count, right in enumerate(inside):
        watch.see(count, 1.0 + count / RATE, RIGHT if right else WRONG, 1e-4)
    return watch


def test_every_tenth_instant_of_the_phase_is_judged() -> None:
    watch = watched([count < 50 for count in range(100)])
    assert watch.judged == 10
    assert watch.held.tolist() == [5] * 5


def test_right_again_is_when_it_stays_so_for_half_a_second() -> None:
    wrong, right = [False], [True]
    assert watched(wrong * 100 + right * 60).right_after == pytest.approx(0.0)
    assert watched(wrong * 130 + right * 60).right_after == pytest.approx(0.3)
    relapsed = wrong * 110 + right * 40 + wrong * 10 + right * 60
    assert watched(relapsed).right_after == pytest.approx(0.6)
    assert math.isnan(watched(wrong * 130 + right * 40).right_after)


def test_what_is_no_number_is_counted_and_never_right() -> None:
    watch = Watch((1.0, 2.0))
    watch.see(0, 1.5, np.full(5, math.nan), math.nan)
    assert watch.not_numbers == 1
    assert watch.held.tolist() == [0] * 5


def test_a_run_is_judged_kept_and_told(tmp_path) -> None:
    short: Script = BY_NAME["start"]
    rows = run_script(short, 0)
    (found,) = rows
    assert found.judged == 10
    assert found.not_numbers == 0
    assert found.case == "start"
    path = tmp_path / "life.csv"
    store.append(path, rows, FORM)
    (kept,) = store.load(path, FORM)
    assert kept.held == found.held
    assert kept._replace(slip_width=0.0, right_after=0.0, microseconds=0.0) == found._replace(
        slip_width=0.0, right_after=0.0, microseconds=0.0
    )
    assert any(line.startswith("| start |") for line in life_sections(rows))
    assert set(life_files(rows)) == {"estimation_life.png"}


def test_a_run_that_is_never_right_again_is_no_time() -> None:
    rows = run_script(BY_NAME["start"], 0)
    never = [rows[0]._replace(right_after=math.nan, seed=seed) for seed in range(3)]
    line = [line for line in life_sections(never) if line.startswith("| start | ")][-1]
    assert line.count("> 8.5") == 2


@pytest.mark.parametrize(
    ("phase", "seed"), [("gap", 1), ("gap", 12), ("load steps", 4), ("reversal", 0), ("start", 7)]
)
def test_what_a_drive_does_by_itself_is_not_taken_for_a_wrong_sensor(phase: str, seed: int) -> None:
    (life,) = run_script(BY_NAME[phase], seed)
    assert life.lost == 0


def test_the_first_run_of_all_phases_comes_first() -> None:
    names = [job.case for job in jobs(2)]
    assert names[: len(SCRIPTS)] == list(BY_NAME)
    assert len(names) == 2 * len(SCRIPTS)
