"""What the rig's tests share: the paper's drive, and runs of it scripted in the test itself."""

from collections.abc import Callable
from pathlib import Path

import pytest

from belt_ros.rig import RigSample, simulate
from belt_ros.rig.scenario import scenario_from_mapping
from belt_ros.settings import DriveSettings, load_settings

ROOT = Path(__file__).resolve().parents[2]
Run = Callable[..., list[RigSample]]

EXACT_SENSORS = {
    "sensors.counts_per_turn": 1e12,
    "sensors.speed_resolution": 0.0,
    "sensors.speed_relative": 0.0,
    "sensors.speed_absolute": 0.0,
    "sensors.torque_relative": 0.0,
    "sensors.torque_absolute": 0.0,
}


@pytest.fixture(scope="session")
def root() -> Path:
    return ROOT


@pytest.fixture(scope="session")
def settings() -> DriveSettings:
    return load_settings(ROOT / "config" / "paper_drive.yaml")


@pytest.fixture
def run(settings: DriveSettings) -> Run:
    """Run a scenario given as flat names, with exact sensors unless told otherwise."""

    def simulated(drive: DriveSettings = settings, **values: object) -> list[RigSample]:
        named = {name.replace("__", "."): value for name, value in values.items()}
        return list(simulate(drive, scenario_from_mapping({**EXACT_SENSORS, **named}, drive)))

    return simulated
