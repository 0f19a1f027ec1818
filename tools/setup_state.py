"""What set-up has done, and for what, so that it does only the rest."""

from __future__ import annotations

import hashlib
import json
from typing import TYPE_CHECKING

from setup_steps import ROOT, VENV

if TYPE_CHECKING:
    from pathlib import Path

STATE = VENV / "setup.json"


def fingerprint(*files: Path) -> str:
    """Return a digest of the files' names and contents."""
    digest = hashlib.sha256()
    for file in files:
        name = file.relative_to(ROOT).as_posix()
        digest.update(b"%s\0%s\0" % (name.encode(), file.read_bytes()))
    return digest.hexdigest()


class State:
    """The steps that are done, and for what; kept in the virtual environment."""

    def __init__(self) -> None:
        try:
            self.done: dict[str, str] = json.loads(STATE.read_text())
        except (OSError, ValueError):
            self.done = {}

    def begin(self, step: str) -> None:
        """Forget a step: should it be interrupted, it counts as not done."""
        self.done.pop(step, None)
        self._save()

    def finish(self, step: str, key: str) -> None:
        """Remember for what a step was done."""
        self.done[step] = key
        self._save()

    def _save(self) -> None:
        STATE.write_text(json.dumps(self.done, indent=1) + "\n")
