import numpy as np
import pytest

from belt_ros.estimation import Phase, Quantity
from belt_ros.report.comparison import Compared
from belt_ros.report.load_slip import LOADS, CloudTally, SlipAtLoadTally, Window, common_step
from belt_ros.report.rounding import MINUS, SPACE
from belt_ros.report.table_scan import Batch


def compared(before, now, name="mean_tension"):
    return Compared(name, "", Quantity(*before), Quantity(*now))


@pytest.mark.parametrize(
    ("before", "now", "words", "significant"),
    [
        ((440.0, 3.0), (400.0, 4.0), "significantly lower (8.0 σ)", True),
        ((440.0, 3.0), (451.0, 4.0), "perhaps higher (2.2 σ)", False),
        ((440.0, 3.0), (445.0, 4.0), "no difference that the data can tell (1.0 σ)", False),
        ((440.0, 30.0), (440.0, 30.0), "no difference that the data can tell (0.0 σ)", False),
    ],
)
def test_a_difference_is_judged_by_the_errors_of_both(before, now, words, significant):
    pair = compared(before, now)
    assert pair.verdict == words
    assert pair.significant is significant


def test_a_difference_is_written_with_its_own_error():
    assert compared((440.0, 3.0), (400.0, 4.0)).difference == f"{MINUS}40 ± 5{SPACE}N"


def test_friction_is_compared_by_its_logarithm():
    # A factor of two at 20 % each is ln 2 / 0.277 deviations, in either direction.
    up = compared((5e6, 1e6), (1e7, 2e6), "friction_stiffness")
    down = compared((1e7, 2e6), (5e6, 1e6), "friction_stiffness")
    assert up.deviations == pytest.approx(-down.deviations)
    assert up.deviations == pytest.approx(np.log(2.0) / (np.sqrt(2.0) * 0.196), rel=0.02)


def rows(torque, slip, stddev=1e-4, speed=100.0):
    count = len(torque)
    return Batch(
        np.arange(count) * 0.01,
        np.full(count, 0.01),
        np.arange(count),
        {
            "transmitted_torque": np.asarray(torque, dtype=float),
            "slip": np.asarray(slip, dtype=float),
            "slip_stddev": np.full(count, stddev),
            "phase": np.full(count, float(Phase.RUNNING)),
            "driver_speed": np.full(count, speed),
        },
    )


def test_slip_is_compared_at_the_load_that_both_runs_had():
    now, before = SlipAtLoadTally(48.0), SlipAtLoadTally(48.0)
    now.add(rows([30.5] * 50 + [40.5] * 50, [0.009] * 50 + [0.02] * 50))
    before.add(rows([10.5] * 50 + [30.9] * 50, [0.002] * 50 + [0.007] * 50))
    step = common_step(now, before)
    assert now.at(step).torque == pytest.approx(31.0)
    assert now.at(step).slip == pytest.approx(0.009)
    assert before.at(step).slip == pytest.approx(0.007)
    assert before.at(step).stddev == pytest.approx(1e-4)


def test_how_much_slip_varied_is_part_of_its_error():
    tally = SlipAtLoadTally(48.0)
    tally.add(rows([30.5] * 100, [0.008, 0.010] * 50))
    assert tally.at(int(30.5 / 48.0 * LOADS)).stddev == pytest.approx(1e-3, rel=0.01)


def test_runs_without_a_common_load_have_no_common_slip():
    now, before = SlipAtLoadTally(48.0), SlipAtLoadTally(48.0)
    now.add(rows([30.5], [0.009]))
    before.add(rows([10.5], [0.002]))
    assert common_step(now, before) is None


def test_every_moving_measurement_is_in_a_cell_or_counted_beyond():
    generator = np.random.default_rng(3)
    cloud = CloudTally(Window(-5.0, 50.0, -0.01, 0.04), 1.0)
    for _ in range(3):
        cloud.add(rows(generator.uniform(-20, 80, 400), generator.uniform(-0.05, 0.1, 400)))
    cloud.add(rows([10.0] * 7, [0.01] * 7, speed=0.5))
    assert cloud.moving == 1200
    assert np.sum(cloud.cells().measurements) + cloud.beyond == cloud.moving
    assert 0 < cloud.beyond < 1200


def test_load_counts_along_the_rotation():
    cloud = CloudTally(Window(0.0, 50.0, 0.0, 0.04), 1.0)
    cloud.add(rows([-10.0] * 5, [0.01] * 5, speed=-100.0))
    assert cloud.beyond == 0
