"""Runs of the drive that were measured side by side, kept as text: Exudyn is slow to ask again."""

import json
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from benchmarks.mechanics.clock import Seconds
from benchmarks.mechanics.drive_run import ArcProfile, DriveRun

FILE = Path(__file__).resolve().parents[1] / "results" / "drive_runs.json"


class Session(NamedTuple):
    """Runs of one session on one machine."""

    made: str  # date, versions, machine
    runs: list[DriveRun]


def save(session: Session) -> None:
    """Write the session in place of the one before."""
    values = {"made": session.made, "runs": [_plain(run) for run in session.runs]}
    FILE.write_text(json.dumps(values, indent=1) + "\n", encoding="utf-8")


def load() -> Session | None:
    """Read the session kept, if there is one."""
    if not FILE.is_file():
        return None
    kept = json.loads(FILE.read_text(encoding="utf-8"))
    return Session(kept["made"], [_run(run) for run in kept["runs"]])


def _plain(run: DriveRun) -> dict[str, Any]:
    values = run._asdict()
    values["seconds"] = run.seconds._asdict()
    for name in ("driven", "driver"):
        profile: ArcProfile = values[name]
        values[name] = {
            "angle": np.round(profile.angle, 5).tolist(),
            "friction": np.round(profile.friction, 1).tolist(),
        }
    return values


def _run(values: dict[str, Any]) -> DriveRun:
    arcs = {
        name: ArcProfile(np.array(values[name]["angle"]), np.array(values[name]["friction"]))
        for name in ("driven", "driver")
    }
    return DriveRun(**{**values, "seconds": Seconds(**values["seconds"]), **arcs})
