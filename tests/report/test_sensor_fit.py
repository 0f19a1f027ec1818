import pytest

from belt_ros.diagnostic_rows import Level, Row
from belt_ros.estimation.estimate import Consistency
from belt_ros.replay.result_bag import ResultBag
from belt_ros.report.result_directory import open_results
from belt_ros.report.sensor_fit import MOST_ROWS, FitTally, read_fits
from belt_ros.report.study import study

S = 1_000_000_000


def bag_of(place, seconds, limits=(0.3, 1.25)):
    """A result bag that holds diagnostics of these means by sensor, one row a second."""
    bag = ResultBag(place)
    for second, means in enumerate(seconds, 1):
        low, high = limits
        drive = {"fit": 1, "fit mean [-]": 1.0, "fit lowest [-]": low, "fit highest [-]": high}
        sensors = {f"fit {sensor} mean [-]": mean for sensor, mean in means.items()}
        rows = [
            Row(Level.OK, "belt_node: d", "d", "", drive),
            Row(Level.OK, "belt_node: d input", "d", "", {"accepted": 100.0, **sensors}),
        ]
        bag.write_diagnostics(second * S, rows)
    bag.close()
    return place


def test_each_sensor_is_told_of_by_itself(tmp_path):
    noisy, fair = [0.9, 4.0, 2.0, 1.0], [1.0, 1.1, 0.9, 1.0]
    rows = [{"driver speed": a, "driven torque": b} for a, b in zip(noisy, fair, strict=True)]
    first, second = read_fits(bag_of(tmp_path / "bag", rows))
    assert (first.sensor, second.sensor) == ("driver speed", "driven torque")
    assert (first.median, first.greatest, first.log_ns) == (1.5, 4.0, 2 * S)
    assert (first.worse, second.worse) == (0.5, 0.0)


@pytest.mark.parametrize(
    ("means", "kind"),
    [
        ([1.0, 1.0, 5.0], Consistency.CONSISTENT),
        ([2.0, 2.0, 1.0], Consistency.OVERCONFIDENT),
        ([0.1, 0.1, 1.0], Consistency.UNDERCONFIDENT),
        ([0.0, 0.0], Consistency.UNKNOWN),
    ],
)
def test_the_verdict_is_that_of_most_of_the_time(tmp_path, means, kind):
    (fit,) = read_fits(bag_of(tmp_path / "bag", [{"positions": mean} for mean in means]))
    assert fit.verdict is kind


def test_time_in_which_nothing_is_known_does_not_count(tmp_path):
    means = [0.0, 0.0, 0.0, 2.0]
    (fit,) = read_fits(bag_of(tmp_path / "bag", [{"positions": mean} for mean in means]))
    assert (fit.worse, fit.median) == (1.0, 2.0)


def test_before_the_filter_has_a_verdict_its_sensors_have_none(tmp_path):
    (fit,) = read_fits(bag_of(tmp_path / "bag", [{"positions": 2.0}], limits=(0.0, 0.0)))
    assert fit.verdict is Consistency.UNKNOWN


def test_a_long_bag_is_thinned_evenly(tmp_path, monkeypatch):
    monkeypatch.setattr("belt_ros.report.sensor_fit.MOST_ROWS", 10)
    assert MOST_ROWS > 3600
    means = [1.0] * 50 + [2.0] * 50
    (fit,) = read_fits(bag_of(tmp_path / "bag", [{"positions": mean} for mean in means]))
    assert fit.worse == 0.5


def test_results_without_diagnostics_have_no_fits(tmp_path):
    assert read_fits(tmp_path / "absent") == ()
    assert read_fits(bag_of(tmp_path / "bag", [])) == ()
    assert FitTally(()).fits() == ()


def test_a_replay_tells_of_each_of_its_sensors_and_when_it_fitted_worst(results):
    found = study(open_results(results), None).sensor_fits
    names = [fit.sensor for fit in found]
    assert names == ["driver speed", "driven speed", "driver torque", "driven torque", "positions"]
    assert all(0.0 < fit.time <= 7.5 for fit in found)
    assert all(fit.time == pytest.approx((fit.log_ns - 1_750_000_000 * S) / S) for fit in found)
