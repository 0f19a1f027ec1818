"""Compile inner loops and modules beforehand, so that no start waits for them."""

import compileall
import gc
import re
import shutil
from itertools import islice
from pathlib import Path

from belt_ros.estimation.hindsight import HindsightReader
from belt_ros.mechanics._compile import CACHE_DIRECTORY
from belt_ros.node.warming_up import warm_up
from belt_ros.rating import rate
from belt_ros.replay.smoothing import smoothed_rows
from belt_ros.rig import Scenario, load_scenario, measured
from belt_ros.settings import DriveSettings, load_settings

CONFIG = Path(__file__).resolve().parent.parent / "config"
MEASUREMENTS = 130  # a second and more: as long as it takes until modes change
_GARBAGE = 100_000  # objects
KEPT = 3  # branches, or checkouts, that can take turns without compiling anew
DIGEST = re.compile("[0-9a-f]{16}")


def remove_outdated(current: Path) -> None:
    """Remove the machine code of all but the latest sources, `current` among them."""
    if not current.is_dir():  # numba found it not writable
        return
    current.touch()
    codes = [place for place in current.parent.iterdir() if DIGEST.fullmatch(place.name)]
    codes.sort(key=lambda place: place.stat().st_mtime, reverse=True)
    for outdated in codes[KEPT:]:
        shutil.rmtree(outdated, ignore_errors=True)


def replay(settings: DriveSettings, scenario: Scenario) -> None:
    """Run what replay does, on the first moments of a scenario: it looks back as well."""
    monitor = settings.monitor()
    reader = HindsightReader(settings.drive, settings.limits.standstill_speed)
    with monitor.smoother() as smoother:
        for measurement, _ in islice(measured(settings, scenario), MEASUREMENTS):
            monitor.step(measurement)
        monitor.finish()
        for _ in smoothed_rows(smoother, reader, lambda _: None):
            pass


def main() -> None:
    """Run what the node, the rig and the command compile."""
    gc.set_threshold(_GARBAGE)  # the compiler makes little of it, and much to look through
    settings = load_settings(CONFIG / "demo_drive.yaml")
    warm_up(settings)
    rate(settings)
    replay(settings, load_scenario(CONFIG / "scenarios" / "demo.yaml", settings))
    remove_outdated(Path(CACHE_DIRECTORY))
    # Where Python is told to write no bytecode, every start would compile all modules anew.
    compileall.compile_dir(CONFIG.parent / "belt_ros", quiet=1)


if __name__ == "__main__":
    main()
