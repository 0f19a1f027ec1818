"""A pile of small bags of one drive, months apart, and some that are none."""

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

REPOSITORY = Path(__file__).parents[2]
CONFIG = REPOSITORY / "config" / "paper_drive.yaml"
MONTH_NS = 30 * 86_400 * 1_000_000_000


def _load(name: str) -> ModuleType:
    """Return a helper of the replay tests, which lie in another folder."""
    if name not in sys.modules:
        path = REPOSITORY / "tests" / "replay" / f"{name}.py"
        spec = importlib.util.spec_from_file_location(name, path)
        assert spec is not None
        assert spec.loader is not None
        sys.modules[name] = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(sys.modules[name])
    return sys.modules[name]


def make_bags(folder: Path, count: int, samples: int = 30) -> list[Path]:
    bags = _load("bags")
    made = []
    for number in range(count):
        shift = number * MONTH_NS
        run = [
            sample._replace(log_ns=sample.log_ns + shift, stamp_ns=sample.stamp_ns + shift)
            for sample in bags.steady_run(samples, seed=number)
        ]
        made.append(bags.write_bag(folder / f"bag_{number:03d}", {"/joint_states": run}))
    return made


def make_damaged(folder: Path, count: int) -> list[Path]:
    made = []
    for number in range(count):
        path = folder / f"damaged_{number}.mcap"
        path.write_bytes(b"\x89MCAP0\r\n" + bytes(range(64)) * (number + 1))
        made.append(path)
    return made
