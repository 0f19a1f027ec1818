"""Compile inner loops with numba, and keep the machine code between runs.

Numba invalidates a cached function when its own file changes, not when a function it calls in
another file does. The cache directory is therefore named after the content of every source file
here, so that code from before an edit can never be run after it.
"""

import hashlib
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
from numba.core import config

Function = TypeVar("Function", bound=Callable[..., Any])


def _cache_directory() -> str:
    digest = hashlib.sha256()
    for source in sorted(Path(__file__).parent.parent.rglob("*.py")):
        if b"compiled" in (text := source.read_bytes()):
            digest.update(text)
    base = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    return str(Path(base) / "belt_ros" / digest.hexdigest()[:16])


CACHE_DIRECTORY = _cache_directory()
_SETTING = "CACHE_DIR"  # numba makes its settings at run time


def compiled(function: Function, *, inline: bool = False) -> Function:
    """Compile `function` to machine code on first call; cached on disk, releases the GIL."""
    before = getattr(config, _SETTING)
    setattr(config, _SETTING, CACHE_DIRECTORY)
    make = numba.njit(cache=True, nogil=True, error_model="numpy", forceinline=inline)
    try:
        return cast(Function, make(function))
    finally:
        setattr(config, _SETTING, before)


def inlined(function: Function) -> Function:
    """As `compiled`, but made part of every compiled function that calls it.

    For what is short and takes or returns large tuples, whose numbers a call would copy, each.
    """
    return compiled(function, inline=True)
