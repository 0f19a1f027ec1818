"""A fleet on a Dask cluster: a scheduler and workers that are processes of their own."""

import os
import re
import subprocess
import sys
import time

import pytest
from fleet_bags import CONFIG, REPOSITORY, make_bags, make_damaged

from belt_ros.fleet import FleetError, run_fleet

pytest.importorskip("distributed")
pytestmark = pytest.mark.slow


def start(log, *arguments):
    with log.open("wb") as file:
        return subprocess.Popen(
            [sys.executable, "-m", "dask", *arguments],
            stdout=file,
            stderr=subprocess.STDOUT,
            cwd=REPOSITORY,
            env={**os.environ, "PYTHONPATH": str(REPOSITORY)},
        )


def logged(log, pattern, process):
    end = time.monotonic() + 60.0
    while time.monotonic() < end:
        found = re.search(pattern, log.read_text(encoding="utf-8", errors="replace"))
        if found:
            return found[1]
        assert process.poll() is None, log.read_text(encoding="utf-8")
        time.sleep(0.05)
    raise AssertionError(log.read_text(encoding="utf-8"))


@pytest.fixture
def cluster(tmp_path):
    """Address of a scheduler, with two workers."""
    log = tmp_path / "scheduler.log"
    options = ("--host", "127.0.0.1", "--port", "0", "--dashboard-address", ":0")
    processes = [start(log, "scheduler", *options)]
    address = logged(log, r"Scheduler at:\s+(tcp://\S+)", processes[0])
    for number in range(2):
        place = tmp_path / f"worker_{number}.log"
        options = ("--nthreads", "1", "--no-dashboard", "--local-directory", str(tmp_path))
        processes.append(start(place, "worker", address, *options))
    yield address
    for process in reversed(processes):
        process.terminate()
    for process in processes:
        process.wait(20.0)


def test_a_cluster_does_the_same_as_this_machine(cluster, tmp_path):
    make_bags(tmp_path / "bags", 3, samples=10)
    make_damaged(tmp_path / "bags", 1)
    there = run_fleet([tmp_path / "bags"], CONFIG, tmp_path / "there", scheduler=cluster)
    assert (there.done, there.skipped, there.failed) == (4, 0, 1)
    here = run_fleet([tmp_path / "bags"], CONFIG, tmp_path / "here", workers=1)
    assert repr(here.rows) == repr(there.rows)  # NaN included
    again = run_fleet([tmp_path / "bags"], CONFIG, tmp_path / "there", scheduler=cluster)
    assert (again.done, again.skipped) == (0, 4)


def test_a_scheduler_that_is_not_there_is_told(tmp_path, monkeypatch):
    monkeypatch.setattr("belt_ros.fleet.cluster._PATIENCE", 1.0)
    make_bags(tmp_path / "bags", 1, samples=5)
    with pytest.raises(FleetError, match="no Dask scheduler can be reached"):
        run_fleet([tmp_path / "bags"], CONFIG, tmp_path / "out", scheduler="tcp://127.0.0.1:9")
