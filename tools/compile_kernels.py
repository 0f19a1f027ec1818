"""Compile inner loops and modules beforehand, so that no start waits for them."""

import compileall
import re
import shutil
from pathlib import Path

from belt_ros.mechanics._compile import CACHE_DIRECTORY
from belt_ros.node.warming_up import warm_up
from belt_ros.rating import rate
from belt_ros.rig import load_scenario, simulate
from belt_ros.settings import load_settings

CONFIG = Path(__file__).resolve().parent.parent / "config"
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


def main() -> None:
    """Run what the node, the rig and the command compile."""
    settings = load_settings(CONFIG / "demo_drive.yaml")
    warm_up(settings)
    rate(settings)
    samples = simulate(settings, load_scenario(CONFIG / "scenarios" / "demo.yaml", settings))
    for _ in range(2):  # the first is there before any motion
        next(samples)
    remove_outdated(Path(CACHE_DIRECTORY))
    # Where Python is told to write no bytecode, every start would compile all modules anew.
    compileall.compile_dir(CONFIG.parent / "belt_ros", quiet=1)


if __name__ == "__main__":
    main()
