import json
import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from belt_ros.replay import replay
from belt_ros.settings import load_settings

REPOSITORY = Path(__file__).parents[2]


@pytest.fixture(scope="session")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What belt replay makes of a short run with lost tension and an overload."""
    out = tmp_path_factory.mktemp("report") / "results"
    settings = load_settings(REPOSITORY / "config" / "paper_drive.yaml")
    replay(REPOSITORY / "tests" / "data" / "rig_bag", settings, out)
    return out


@pytest.fixture(scope="module")
def tools() -> Iterator[None]:
    """Let the repository's tools be imported."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(REPOSITORY / "tools"))
        yield


@pytest.fixture
def changed(results: Path, tmp_path: Path) -> Callable[[Callable[[dict[str, Any]], None]], Path]:
    """Return a copy of the results with another summary."""

    def make(change: Callable[[dict[str, Any]], None]) -> Path:
        copy = tmp_path / "changed"
        shutil.copytree(results, copy)
        place = copy / "summary.json"
        summary = json.loads(place.read_text())
        change(summary)
        place.write_text(json.dumps(summary))
        return copy

    return make
