"""The benchmark of replaying: its page, and that what it times is a replay."""

from pathlib import Path

import pyarrow.parquet as pq

from belt_ros.replay import replay
from belt_ros.replay.drive_bag import DriveBag
from belt_ros.settings import load_settings
from benchmarks.fleet.bags import make_bag
from benchmarks.replay import measure
from benchmarks.replay.__main__ import keep
from benchmarks.replay.measure import Figure
from benchmarks.replay.playback import played_back

WHATS = (measure.READING, *measure.PARTS, measure.PLAIN, measure.SMOOTHED)
SPEED = [
    Figure(measure.speed_case(rate), what, value, "code")
    for rate in measure.RATES
    for what, value in zip(WHATS, (10.0, 8.0, 60.0, 12.0, 50.0, 80.0, 130.0), strict=True)
]
CORES = [
    Figure(measure.CORES, what, value, "code")
    for what, value in ((measure.ONE, 20.0), (measure.TWO, 12.5))
]


def test_page_says_what_is_reached_and_cases_are_renewed(tmp_path: Path) -> None:
    keep([*SPEED, *CORES], tmp_path)
    page = keep([Figure(measure.CORES, measure.ONE, 25.0, "code"), CORES[1]], tmp_path)
    assert page == (tmp_path / "replay.md").read_text(encoding="utf-8")
    assert "1000 Hz, all, --no-smooth: 10000 samples/s in one core | 12500 | yes" in page
    assert "1000 Hz, all: 10000 samples/s in one core | 7692 | **no**" in page
    assert "10 bags on two cores: 1.8 times as fast as on one | 2.00 | yes" in page
    assert "| smoothing | 50.0 | 38% | 5.0 |" in page
    assert len((tmp_path / "replay.csv").read_text(encoding="utf-8").splitlines()) == 17


def test_what_is_played_back_is_written_as_the_real_thing(tmp_path: Path) -> None:
    settings = load_settings(measure.CONFIG)
    bag = make_bag(tmp_path / "bag", 1000.0, 100)
    monitor = settings.monitor()
    with DriveBag(bag, settings) as source:
        outputs = [monitor.step(sample.content) for sample in source.samples()]
    played = replay(bag, played_back(settings, monitor, outputs), tmp_path / "a", smooth=False)
    real = replay(bag, settings, tmp_path / "b", smooth=False)
    assert played.as_json() == real.as_json()
    tables = [pq.read_table(tmp_path / name / "estimates.parquet") for name in "ab"]
    assert tables[0].num_rows == tables[1].num_rows < 100
    assert str(tables[0].to_pydict()) == str(tables[1].to_pydict())  # NaN included
