"""Write the small bag that the tests replay, tests/data/rig_bag, from its scenario.

Usage: ``python tools/make_rig_bag.py [directory]``. It gives the same bag every time.
"""

import shutil
import sys
from pathlib import Path

from belt_ros.rig.bag import write_bag
from belt_ros.rig.scenario import load_scenario
from belt_ros.rig.simulate import simulate
from belt_ros.settings import load_settings

ROOT = Path(__file__).resolve().parents[1]
BAG = ROOT / "tests" / "data" / "rig_bag"
START_NS = 1_750_000_000 * 10**9
TRUTH_EVERY = 5


def make_bag(path: Path) -> int:
    """Write the bag to `path`, which must not exist; return its number of joint states."""
    settings = load_settings(ROOT / "config" / "paper_drive.yaml")
    scenario = load_scenario(ROOT / "tests" / "data" / "rig_bag_scenario.yaml", settings)
    samples = simulate(settings, scenario, START_NS)
    return write_bag(path, settings.name, samples, truth_every=TRUTH_EVERY)


def main() -> None:
    """Write the bag anew, in place of what is there."""
    path = Path(sys.argv[1]) if len(sys.argv) > 1 else BAG
    if (path / "metadata.yaml").is_file():
        shutil.rmtree(path)
    count = make_bag(path)
    size = sum(file.stat().st_size for file in path.iterdir())
    print(f"{path}: {count} joint states, {size} bytes")


if __name__ == "__main__":
    main()
