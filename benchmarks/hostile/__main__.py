"""Feed drives a million hostile messages; write benchmarks/results/hostile.md.

Blocks are appended to a results file, and what it holds is not run again; --fresh begins anew. The
page is made from all that it holds; --messages 0 makes just that.
"""

import argparse
import math
from functools import partial
from pathlib import Path

from benchmarks.estimation import campaign, report, store
from benchmarks.estimation.campaign import Task
from benchmarks.hostile.block import CASES, FORM, MESSAGES, METHOD, Block, run_block
from benchmarks.hostile.page import sections


def main() -> None:
    """Run what is missing; write the page."""
    asked = _arguments()
    path = asked.out / f"hostile_{asked.seed}.csv"
    if asked.fresh:
        path.unlink(missing_ok=True)
    rows = campaign.run(
        jobs(asked.seed, asked.messages), path, asked.workers, "hostile messages", FORM
    )
    if not rows:
        raise SystemExit("there are no results yet; ask for messages")
    made_with = report.made_with(f"--messages {asked.messages}", rows, "hostile")
    text = "\n".join([*sections(sorted(rows, key=lambda row: row.seed)), made_with]) + "\n"
    (asked.out / "hostile.md").write_text(text, encoding="utf-8")
    print(text)
    if any(row.fault for row in rows):
        raise SystemExit("something does not hold that must")


def jobs(seed: int, messages: int) -> list[Task[Block]]:
    """Return the blocks that make so many messages."""
    return [
        Task(METHOD, CASES[block % len(CASES)], block, partial(run_block, seed), (block,))
        for block in range(math.ceil(messages / MESSAGES))
    ]


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.hostile", description=__doc__)
    parser.add_argument("--messages", type=int, default=1_000_000)
    parser.add_argument("--seed", type=int, default=1, help="of all random numbers")
    parser.add_argument("--workers", type=int, default=2, help="processes")
    parser.add_argument("--fresh", action="store_true", help="forget what was run before")
    parser.add_argument("--out", type=Path, default=store.RESULTS, help="folder of the results")
    return parser.parse_args()


if __name__ == "__main__":
    main()
