"""Measure the node on the ROS graph: rate, latency, many drives, sudden death, stages.

The rows of a case take the place of those of the same case in the results file; the page is made
of all that the file holds.
"""

import argparse
from pathlib import Path
from typing import Any

from benchmarks.estimation.store import RESULTS
from benchmarks.graph.drives import run_drives
from benchmarks.graph.kill import run_kill
from benchmarks.graph.latency import run_latency
from benchmarks.graph.parts import PARTS
from benchmarks.graph.program import ROOT, die_together
from benchmarks.graph.rate import CASES, run_rate
from benchmarks.graph.results import keep
from benchmarks.graph.stages import run_stages

_PAPER, _DEMO = (ROOT / "config" / name for name in ("paper_drive.yaml", "demo_drive.yaml"))


def _rate(asked: argparse.Namespace) -> list[Any]:
    cases = CASES if asked.rate is None else ((asked.rate, asked.seconds or 60.0),)
    return [
        run_rate(asked.params, rate, asked.seconds or seconds, asked.depth)
        for rate, seconds in cases
    ]


def _latency(asked: argparse.Namespace) -> list[Any]:
    rates = (100.0, 1000.0) if asked.rate is None else (asked.rate,)
    return [
        turn
        for rate in rates
        for steady in (False, True)
        for turn in run_latency(
            asked.params, rate, asked.seconds or 60.0, asked.depth, steady=steady
        )
    ]


def _drives(asked: argparse.Namespace) -> list[Any]:
    rate, seconds = asked.rate or 100.0, asked.seconds or 60.0
    return [run_drives(asked.params, asked.drives, rate, seconds, asked.depth, asked.pool_period)]


def _kill(asked: argparse.Namespace) -> list[Any]:
    return list(run_kill(asked.params, asked.rate or 100.0, asked.kills, asked.seed))


def _stages(asked: argparse.Namespace) -> list[Any]:
    return list(run_stages(asked.params, asked.rate or 1000.0, asked.seconds or 10.0))


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.graph", description=__doc__)
    parser.add_argument("--out", type=Path, default=RESULTS, help="folder of the results")
    commands = parser.add_subparsers(required=True, dest="part")
    for name, run in _RUNS.items():
        command = commands.add_parser(name, help=PARTS[name].title)
        default = _DEMO if name in ("kill", "drives") else _PAPER
        command.add_argument("--params", type=Path, default=default, help="of the drive (YAML)")
        command.add_argument("--rate", type=float, help="of the input [Hz]")
        if name == "kill":
            command.add_argument("--kills", type=int, default=40)
            command.add_argument("--seed", type=int, default=1)
        else:
            command.add_argument("--seconds", type=float, help="that are measured, of each case")
            command.add_argument("--depth", type=int, default=200, help="input_depth of the node")
        if name == "drives":
            command.add_argument("--drives", type=int, default=50)
            command.add_argument("--pool-period", type=float, help="limits.pool_period [s]")
        command.set_defaults(run=run)
    asked = parser.parse_args()
    asked.params = asked.params.resolve()
    return asked


def main() -> None:
    """Run one part; write its rows and its page."""
    die_together()
    asked = _arguments()
    asked.out.mkdir(parents=True, exist_ok=True)
    print(keep(PARTS[asked.part], asked.run(asked), asked.out))


_RUNS = {
    "rate": _rate,
    "latency": _latency,
    "drives": _drives,
    "kill": _kill,
    "stages": _stages,
}

if __name__ == "__main__":
    main()
