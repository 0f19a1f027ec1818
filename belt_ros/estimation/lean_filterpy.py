"""filterpy's unscented filter, without the half of a node's start that filterpy spends on nothing.

All of filterpy is imported with any part of it: with `filterpy.stats` all of `scipy.stats`, for a
likelihood, and with `filterpy.discrete_bayes` all of `scipy.ndimage`, for filters on a grid. No
filter here uses either, and together they take longer than everything else that estimation imports.
They are imported when they are asked for, and are what they always were for everybody else.
"""

import importlib
import sys
from collections.abc import Callable
from types import ModuleType
from typing import Any

_KALMAN = "filterpy.kalman"
# Modules that filterpy's own import, what they take of these, and what all of it is for.
_SPARED = {
    "filterpy.stats": (("logpdf",), "scipy.stats"),
    "scipy.ndimage": (("convolve", "shift"), "scipy.ndimage"),
}


def _late(module: str, name: str) -> Callable[..., Any]:
    """Return what imports a module's function when it is called, and calls it."""

    def call(*arguments: Any, **options: Any) -> Any:
        return getattr(importlib.import_module(module), name)(*arguments, **options)

    return call


def _stand_in(module: str, names: tuple[str, ...]) -> ModuleType:
    made = ModuleType(module)
    vars(made).update({name: _late(module, name) for name in names})
    return made


def _kalman() -> ModuleType:
    """Import `filterpy.kalman`; what it does not need, only where it is loaded already."""
    if "filterpy" in sys.modules:
        return importlib.import_module(_KALMAN)
    made = {
        module: _stand_in(module, names)
        for module, (names, behind) in _SPARED.items()
        if behind not in sys.modules
    }
    sys.modules.update(made)
    try:
        return importlib.import_module(_KALMAN)
    finally:
        for module, stand_in in made.items():
            del sys.modules[module]
            # For who finds it as an attribute of its package; importing, it would find itself.
            vars(stand_in).update(__getattr__=_of(module))


def _of(module: str) -> Callable[[str], Any]:
    return lambda name: getattr(importlib.import_module(module), name)


UnscentedKalmanFilter = _kalman().UnscentedKalmanFilter
