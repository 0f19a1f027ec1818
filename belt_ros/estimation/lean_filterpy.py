"""filterpy's unscented filter, without the half of a node's start that filterpy spends on nothing.

All of filterpy is imported with any part of it, and with `filterpy.stats` all of `scipy.stats`:
more than everything else that estimation imports, for a likelihood that no filter here computes.
It is imported when it is asked for. `filterpy.stats` itself stays what it is for everybody else.
"""

import importlib
import sys
from types import ModuleType
from typing import Any

_STATISTICS = "filterpy.stats"


def _statistics(name: str) -> Any:
    return getattr(importlib.import_module(_STATISTICS), name)


def _logpdf(*arguments: Any, **options: Any) -> Any:
    """Stand in filterpy's filters for its `logpdf`, and call it."""
    return _statistics("logpdf")(*arguments, **options)


def _unscented_filter() -> Any:
    if "filterpy" in sys.modules or "scipy.stats" in sys.modules:
        from filterpy.kalman import UnscentedKalmanFilter  # noqa: PLC0415

        return UnscentedKalmanFilter
    stand_in = ModuleType(_STATISTICS)
    vars(stand_in).update(logpdf=_logpdf)
    sys.modules[_STATISTICS] = stand_in
    try:
        from filterpy.kalman import UnscentedKalmanFilter  # noqa: PLC0415
    finally:
        del sys.modules[_STATISTICS]
    vars(stand_in).update(__getattr__=_statistics)  # for who finds it as an attribute of filterpy
    return UnscentedKalmanFilter


UnscentedKalmanFilter = _unscented_filter()
