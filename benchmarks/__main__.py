"""Run the coverage campaign and write benchmarks/results/coverage.md."""

import argparse
import os
import platform
import time
from datetime import datetime, timezone
from importlib.metadata import version
from pathlib import Path

from rich.progress import track

from benchmarks.coverage import CONFIGURATIONS, campaign, table

RESULT = Path(__file__).parent / "results" / "coverage.md"


def main() -> None:
    """Run and write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--drives", type=int, default=150, help="drives of each configuration")
    drives = parser.parse_args().drives
    workers = os.cpu_count() or 1
    began = time.monotonic()
    total = drives * len(CONFIGURATIONS)
    results = list(track(campaign(drives, workers), description="coverage", total=total))
    seconds = time.monotonic() - began
    packages = ", ".join(f"{name} {version(name)}" for name in ("numpy", "numba", "filterpy"))
    sampling = 1.96 * (0.95 * 0.05 / drives) ** 0.5
    text = [
        "# Coverage of the stated 95 % intervals",
        "",
        f"{drives} random drives of each configuration, drawn from the priors; rig, 100 Hz.",
        f"Sampling alone moves a cell by +/- {sampling:.1%} (95 %). z: error over its deviation.",
        "",
        *table(results),
        "",
        f"{datetime.now(timezone.utc):%Y-%m-%d}, Python {platform.python_version()}, {packages}, "
        f"{workers} cores of {platform.machine()}, {seconds:.0f} s. `make bench-coverage`",
    ]
    RESULT.write_text("\n".join(text) + "\n")
    print("\n".join(text))


if __name__ == "__main__":
    main()
