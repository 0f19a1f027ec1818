"""The drives that belts are identified on."""

import pytest
from steady import CONFIG

from belt_ros.settings import DriveSettings, load_settings


@pytest.fixture(scope="session")
def soft() -> DriveSettings:
    """A soft-faced belt, whose slip tells much."""
    return load_settings(CONFIG / "demo_drive.yaml")


@pytest.fixture(scope="session")
def stiff() -> DriveSettings:
    """The paper's belt, whose slip tells little."""
    return load_settings(CONFIG / "paper_drive.yaml")
