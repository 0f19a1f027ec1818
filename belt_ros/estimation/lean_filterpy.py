"""filterpy's unscented filter, without the half of a node's start that filterpy spends on nothing.

All of filterpy is imported with any part of it, and with `filterpy.stats` all of `scipy.stats`:
more than everything else that estimation imports, for a likelihood that no filter here computes.
It is imported when it is asked for. `filterpy.stats` itself stays what it is for everybody else.
"""

import importlib
import sys
from types import ModuleType
from typing import Any

_KALMAN = "filterpy.kalman"
_STATISTICS = "filterpy.stats"


def _statistics(name: str) -> Any:
    return getattr(importlib.import_module(_STATISTICS), name)


def _logpdf(*arguments: Any, **options: Any) -> Any:
    """Stand in filterpy's filters for its `logpdf`, and call it."""
    return _statistics("logpdf")(*arguments, **options)


def _kalman() -> ModuleType:
    """Import `filterpy.kalman`, the statistics only where they are loaded already."""
    if "filterpy" in sys.modules or "scipy.stats" in sys.modules:
        return importlib.import_module(_KALMAN)
    stand_in = ModuleType(_STATISTICS)
    vars(stand_in).update(logpdf=_logpdf)
    sys.modules[_STATISTICS] = stand_in
    try:
        return importlib.import_module(_KALMAN)
    finally:
        del sys.modules[_STATISTICS]
        # For who finds it as an attribute of filterpy; while importing, it would find itself.
        vars(stand_in).update(__getattr__=_statistics)


UnscentedKalmanFilter = _kalman().UnscentedKalmanFilter
