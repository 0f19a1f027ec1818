from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import pytest
from bags import Sample, write_bag

from belt_ros.settings import DriveSettings, load_settings

REPOSITORY = Path(__file__).parents[2]


@pytest.fixture(scope="session")
def settings() -> DriveSettings:
    return load_settings(REPOSITORY / "config" / "paper_drive.yaml")


@pytest.fixture
def make_bag(tmp_path: Path) -> Callable[..., Path]:
    def make(
        samples: Iterable[bytes | Sample], topic: str = "/joint_states", **options: Any
    ) -> Path:
        return write_bag(tmp_path / "bag", {topic: samples}, **options)

    return make
