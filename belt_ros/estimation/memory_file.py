"""What was learned of a drive, as a file: JSON, one file a drive, replaced whole or not at all."""

import dataclasses
import json
import os
import secrets
from pathlib import Path
from typing import Any, NoReturn
from urllib.parse import quote

import numpy as np
from numpy.typing import NDArray

from belt_ros.estimation.fingerprint import Fingerprint
from belt_ros.estimation.installed import Installed
from belt_ros.estimation.memory import REMEMBERED, Learned, MemoryRefusedError

_FORMAT = "belt_ros memory"
_VERSION = 2.0
_WITHOUT_INSTALLED = 1.0  # a version that can be read too
_LARGEST_FILE = 1_000_000  # bytes; some 20 kB are usual
_MEMBERS = {"weights", "means", "covariances"}
_ENTRIES = {"format", "version", "states", "name", "date", "drive", "installed"} | _MEMBERS


class MemoryFileError(MemoryRefusedError):
    """A memory that cannot be read or written; the message, one line, names file and reason."""


def memory_path(folder: Path, name: str) -> Path:
    """Return the file in `folder` for the drive `name`, whatever characters that has."""
    return folder / f"{quote(name, safe='')}.json"


def save(learned: Learned, path: Path) -> None:
    """Write `learned` to `path`, making its folder where there is none.

    A crash at any moment leaves the previous file or the new one.

    Raises
    ------
    MemoryFileError
        If that is not possible; a previous file is then still there.
    """
    try:
        temporary = path.with_name(f".{path.name[:64]}.{secrets.token_hex(4)}")
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            with temporary.open("xb") as file:
                file.write(json.dumps(_document(learned), indent=1).encode())
                file.flush()
                os.fsync(file.fileno())
            temporary.replace(path)
        finally:
            temporary.unlink(missing_ok=True)
    except (OSError, ValueError) as error:
        raise _failure(path, "cannot be written", error) from error
    _sync_folder(path.parent)


def load(path: Path, name: str) -> Learned | None:
    """Read what was learned of the drive `name`; None where there is no file.

    Raises
    ------
    MemoryFileError
        If the file cannot be read, or is anything but what `save` writes for that drive.
    """
    try:
        if not path.exists():
            return None
        learned = _learned(_parsed(_content(path)))
    except (OSError, ValueError, RecursionError) as error:
        raise _failure(path, "is no memory that can be used", error) from error
    if learned.name != name:
        raise MemoryFileError(f"{str(path)!a} is the memory of {learned.name!a}, not of {name!a}")
    return learned


def _failure(path: Path, what: str, error: Exception) -> MemoryFileError:
    reason = " ".join(str(error).split())[:300]
    return MemoryFileError(f"{str(path)!a} {what}: {reason or type(error).__name__}")


def _sync_folder(folder: Path) -> None:
    """Make the renaming last, where the system can; the file itself is safe either way."""
    try:
        descriptor = os.open(folder, os.O_RDONLY)
    except OSError:
        return
    try:
        os.fsync(descriptor)
    except OSError:
        pass
    finally:
        os.close(descriptor)


def _document(learned: Learned) -> dict[str, Any]:
    return {
        "format": _FORMAT,
        "version": int(_VERSION),
        "states": _states(),
        "name": learned.name,
        "date": learned.date,
        "drive": dataclasses.asdict(learned.drive),
        "weights": learned.weights.tolist(),
        "means": learned.means.tolist(),
        "covariances": learned.covariances.tolist(),
        "installed": None if learned.installed is None else learned.installed._asdict(),
    }


def _states() -> list[str]:
    return [place.name.lower() for place in REMEMBERED]


def _content(path: Path) -> str:
    if not path.is_file():
        raise MemoryRefusedError("it is no regular file")
    with path.open("rb") as file:
        content = file.read(_LARGEST_FILE + 1)
    if len(content) > _LARGEST_FILE:
        raise MemoryRefusedError(f"it is larger than {_LARGEST_FILE} bytes")
    return content.decode()


def _parsed(content: str) -> dict[str, Any]:
    """Return the entries of a memory of this version; all numbers are floats."""
    document = json.loads(content, parse_int=float, parse_constant=_refuse_constant)
    if not isinstance(document, dict) or document.get("format") != _FORMAT:
        raise MemoryRefusedError("it was not written by belt_ros")
    version = document.get("version")
    if version == _WITHOUT_INSTALLED:
        document.setdefault("installed", None)
    elif version != _VERSION:
        age = "newer" if isinstance(version, float) and version > _VERSION else "unknown"
        raise MemoryRefusedError(f"it has a version of {age} kind; this reads {_VERSION:g}")
    if set(document) != _ENTRIES or document["states"] != _states():
        raise MemoryRefusedError("its entries are not those of this version")
    return document


def _refuse_constant(constant: str) -> NoReturn:
    raise MemoryRefusedError(f"it contains {constant}")


def _learned(document: dict[str, Any]) -> Learned:
    weights = document["weights"]
    members = len(weights) if isinstance(weights, list) else 0
    states = len(REMEMBERED)
    return Learned(
        name=_typed(document["name"], str, "name"),
        date=_typed(document["date"], float, "date"),
        drive=_fingerprint(document["drive"]),
        weights=_array(weights, "weights", members),
        means=_array(document["means"], "means", members, states),
        covariances=_array(document["covariances"], "covariances", members, states, states),
        installed=_installed(document["installed"]),
    )


def _installed(entries: object) -> Installed | None:
    if entries is None:
        return None
    if not isinstance(entries, dict) or set(entries) != set(Installed._fields):
        raise MemoryRefusedError("its belt's installation is not described as in this version")
    return Installed(**{name: _typed(entries[name], float, name) for name in Installed._fields})


def _fingerprint(entries: object) -> Fingerprint:
    fields = {field.name: field.type for field in dataclasses.fields(Fingerprint)}
    if not isinstance(entries, dict) or set(entries) != set(fields):
        raise MemoryRefusedError("its drive is not described as in this version")
    return Fingerprint(**{name: _typed(entries[name], kind, name) for name, kind in fields.items()})


def _typed(value: object, kind: Any, name: str) -> Any:
    if type(value) is not kind:
        raise MemoryRefusedError(f"its {name} is no {kind.__name__}")
    return value


def _array(value: object, name: str, *shape: int) -> NDArray[np.float64]:
    """Return nested lists of floats of just this shape as an array."""
    _check_shape(value, name, shape)
    return np.array(value, dtype=np.float64).reshape(shape)


def _check_shape(value: object, name: str, shape: tuple[int, ...]) -> None:
    if not shape:
        _typed(value, float, name)
        return
    if not isinstance(value, list) or len(value) != shape[0]:
        raise MemoryRefusedError(f"its {name} do not have the shape that goes with its weights")
    for part in value:
        _check_shape(part, name, shape[1:])
