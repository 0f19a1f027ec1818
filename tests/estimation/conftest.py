"""The demonstration's drive, scripted runs of it through the monitor, and a saved memory."""

from collections.abc import Callable
from pathlib import Path

import pytest
from memories import learn, one
from runs import ROOT, Run, Runner, scripted

from belt_ros.estimation import BeltMonitor, Measurement
from belt_ros.estimation.memory_file import memory_path, save
from belt_ros.settings import DriveSettings, load_settings


@pytest.fixture(scope="session")
def settings() -> DriveSettings:
    return load_settings(ROOT / "config" / "demo_drive.yaml")


@pytest.fixture(scope="session")
def run(settings: DriveSettings) -> Runner:
    """Run a scenario through a fresh monitor; `alter` changes measurements on the way."""

    def through(
        alter: Callable[[Measurement], Measurement] = lambda measurement: measurement,
        drive: DriveSettings = settings,
        monitor: BeltMonitor | None = None,
        **scenario: object,
    ) -> Run:
        monitor = monitor or drive.monitor()
        pairs = [(alter(m), truth) for m, truth in scripted(drive, **scenario)]
        return Run(
            drive,
            [m for m, _ in pairs],
            [truth for _, truth in pairs],
            [monitor.step(m) for m, _ in pairs],
        )

    return through


@pytest.fixture
def saved(tmp_path: Path) -> Path:
    path = memory_path(tmp_path / "new", "conveyor")
    save(learn(one()), path)
    return path
