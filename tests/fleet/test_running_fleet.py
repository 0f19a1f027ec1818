"""A fleet over many bags: nothing lost, nothing done twice, whatever is damaged or killed."""

import json
import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time

import pyarrow.parquet as pq
import pytest
from fleet_bags import CONFIG, REPOSITORY, make_bags, make_damaged

from belt_ros.fleet import FleetError, run_fleet
from belt_ros.fleet.files import alone_in
from belt_ros.fleet.records import configuration_hash
from belt_ros.fleet.work import Job, do_job
from belt_ros.replay import BagError
from belt_ros.replay.bags import find_bags
from belt_ros.replay.drives import load_drives


def records(out):
    records = (out / "bags").glob("[!.]*/record.json")  # not those that are being written
    return {path.parent.name: (path.stat().st_ino, path.stat().st_mtime_ns) for path in records}


def leftovers(out):
    return [path.name for path in (out / "bags").glob(".*.part")]


@pytest.fixture(scope="module")
def drives():
    return load_drives(CONFIG)


def job(bag, drives, out):
    return Job(bag, drives, out / "bags", configuration_hash(drives, smooth=False), smooth=False)


def test_a_bag_is_done_once_and_again_only_when_it_has_changed(tmp_path, drives):
    (bag,) = make_bags(tmp_path, 1)
    first = do_job(job(bag, drives, tmp_path))
    before = records(tmp_path)
    again = do_job(job(bag, drives, tmp_path))
    assert not first.skipped
    assert again.skipped
    assert again.rows == first.rows
    assert records(tmp_path) == before
    file = next(bag.glob("*.mcap"))
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])
    damaged = do_job(job(bag, drives, tmp_path))
    assert not damaged.skipped
    assert len(records(tmp_path)) == 1
    assert leftovers(tmp_path) == []


def test_another_configuration_is_another_result(tmp_path, drives):
    (bag,) = make_bags(tmp_path, 1, samples=5)
    plain = job(bag, drives, tmp_path)
    assert not do_job(plain).skipped
    other = plain._replace(configuration=configuration_hash(drives, smooth=True))
    of_topic = configuration_hash(drives, smooth=False, topic="/a/joint_states")
    assert len({plain.configuration, other.configuration, of_topic}) == 3
    assert not do_job(other).skipped
    assert do_job(other).skipped


def test_what_is_no_bag_is_a_row_with_its_error(tmp_path, drives):
    (bag,) = make_damaged(tmp_path, 1)
    done = do_job(job(bag, drives, tmp_path))
    (row,) = done.rows
    assert "damaged_0.mcap" in row.error
    assert do_job(job(bag, drives, tmp_path)) == done._replace(skipped=True)
    (gone,) = do_job(job(tmp_path / "gone", drives, tmp_path)).rows
    assert "no such file" in gone.error
    assert len(records(tmp_path)) == 1  # a bag that is not there may come


def test_what_is_wrong_with_the_machine_is_no_result(tmp_path, drives, monkeypatch):
    (bag,) = make_bags(tmp_path, 1, samples=5)

    def full(*_arguments, **_options):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("belt_ros.replay.results.StateTable", full)
    (row,) = do_job(job(bag, drives, tmp_path)).rows
    assert "No space left" in row.error
    assert records(tmp_path) == {}
    assert leftovers(tmp_path) == []


def kill_two(out, killed):
    """Kill the worker of the first bag under way, twice."""
    victim = None
    while len(killed) < 2:
        time.sleep(0.002)
        for part in (out / "bags").glob(".*.part"):
            name, pid, *_ = part.name.removeprefix(".").rsplit(".", 3)
            if victim in (None, name) and int(pid) not in killed:
                victim = name
                os.kill(int(pid), signal.SIGKILL)
                killed.append(int(pid))
                break


def test_killed_workers_and_damaged_bags_cost_nothing_else(tmp_path):
    make_bags(tmp_path / "bags", 6)
    make_damaged(tmp_path / "bags", 2)
    out, killed, told = tmp_path / "out", [], []
    killer = threading.Thread(target=kill_two, args=(out, killed), daemon=True)
    killer.start()
    result = run_fleet(
        [tmp_path / "bags"],
        CONFIG,
        out,
        workers=2,
        smooth=False,
        progress=lambda *progress: told.append(progress),
    )
    assert len(killed) == 2
    assert (result.done, result.skipped, result.failed) == (8, 0, 2)
    assert len(records(out)) == 8
    assert leftovers(out) == []
    table = pq.read_table(out / "fleet.parquet").to_pylist()
    assert [bool(row["error"]) for row in table] == [False] * 6 + [True] * 2
    assert all((out / row["result"] / "summary.json").is_file() for row in table[:6])
    assert told[-1] == (8, 8)
    assert multiprocessing.active_children() == []
    before = records(out)
    again = run_fleet([tmp_path / "bags"], CONFIG, out, workers=1, smooth=False)
    assert (again.done, again.skipped) == (0, 8)
    assert repr(again.rows) == repr(result.rows)  # NaN included
    assert records(out) == before


SCRIPT = """
import signal
import sys
from belt_ros.fleet import run_fleet
if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.default_int_handler)  # ignored in the background
    run_fleet([sys.argv[1]], sys.argv[2], sys.argv[3], workers=1, smooth=False)
"""


def test_an_interrupted_fleet_leaves_what_is_finished(tmp_path):
    make_bags(tmp_path / "bags", 40, samples=300)
    out = tmp_path / "out"
    script = tmp_path / "script.py"
    script.write_text(SCRIPT)
    running = subprocess.Popen(
        [sys.executable, str(script), str(tmp_path / "bags"), str(CONFIG), str(out)],
        cwd=REPOSITORY,
        env={**os.environ, "PYTHONPATH": str(REPOSITORY)},
        stderr=subprocess.DEVNULL,
    )
    while len(records(out)) < 2:
        assert running.poll() is None
        time.sleep(0.01)
    running.send_signal(signal.SIGINT)
    assert running.wait(20.0) != 0
    finished = records(out)
    assert 2 <= len(finished) < 40
    assert leftovers(out) == []
    for name in finished:
        assert json.loads((out / "bags" / name / "record.json").read_text())["rows"]


def test_long_bags_come_first_and_rows_stay_in_order(tmp_path, monkeypatch):
    for number, samples in enumerate((5, 40, 20)):
        make_bags(tmp_path / "bags" / str(number), 1, samples)
    begun = []

    def run(jobs, *_arguments):
        begun.extend(jobs)
        return ((job, do_job(job)) for job in jobs)

    monkeypatch.setattr("belt_ros.fleet.run.run_in_processes", run)
    bags = [str(tmp_path / "bags" / name) for name in "012"]
    result = run_fleet([*bags, tmp_path / "gone"], CONFIG, tmp_path / "out", smooth=False)
    assert [job.bag.parent.name for job in begun[:3]] == ["1", "2", "0"]
    assert [row.messages for row in result.rows] == [5, 40, 20, 0]


def test_two_fleets_do_not_work_in_one_folder(tmp_path):
    with alone_in(tmp_path), pytest.raises(FleetError, match="another fleet"), alone_in(tmp_path):
        pass


def test_bags_are_found_by_folder_and_pattern_but_never_results(tmp_path, drives):
    made = make_bags(tmp_path / "pile" / "2025", 3, samples=5)
    damaged = make_damaged(tmp_path / "pile", 1)
    assert find_bags([tmp_path / "pile"]) == [*made, *damaged]
    assert find_bags([str(tmp_path / "pile" / "*" / "bag_00[12]")]) == made[1:]
    assert find_bags([made[0], made[0]]) == made[:1]
    do_job(job(made[0], drives, tmp_path / "pile"))
    assert find_bags([tmp_path / "pile"]) == [*made, *damaged]
    with pytest.raises(BagError, match="nothing matches"):
        find_bags([str(tmp_path / "*.bag")])
