"""Drives that nobody has: any parameter anywhere within its range, often at an end of it."""

import math
from pathlib import Path

import numpy as np

from belt_ros.parameter_table import PARAMETERS, Parameter, SettingsError
from belt_ros.settings import DriveSettings, load_settings

_CONFIG = Path(__file__).resolve().parents[2] / "config"
BASES = ("paper_drive", "demo_drive", "conveyor_drive", "robot_joint")
_SHARES = (0.0, 0.0, 0.03, 0.1, 0.3, 1.0)  # of the parameters that are not the base's
_TUNED = ("noise.", "drift.", "limits.", "alarm.")
_WIDEST = 1e12  # of a parameter without a range


def hostile_value(parameter: Parameter, random: np.random.Generator) -> float | str:
    """Return a value within a parameter's range; in every other case at one of its ends."""
    if parameter.choices:
        return str(random.choice(parameter.choices))
    if parameter.name.endswith(".sign"):
        return float(random.choice([-1.0, 1.0]))
    low, high = max(parameter.low, -_WIDEST), min(parameter.high, _WIDEST)
    if random.random() < 0.5:
        return float(random.choice([low, high]))
    if low > 0.0:
        return float(np.clip(math.exp(random.uniform(math.log(low), math.log(high))), low, high))
    if low == 0.0:
        return float(high * 10.0 ** -random.uniform(0.0, 12.0))
    return float(random.uniform(low, high))


def hostile_settings(random: np.random.Generator, base: str = "") -> DriveSettings:
    """Return a drive that settings accept."""
    return _drawn(random, base or str(random.choice(BASES)), ("",))


def retuned(random: np.random.Generator, base: str) -> DriveSettings:
    """Return settings of a drive with other noise, drift, limits and alarm thresholds."""
    return _drawn(random, base, _TUNED)


def _drawn(random: np.random.Generator, base: str, groups: tuple[str, ...]) -> DriveSettings:
    share = float(random.choice(_SHARES))
    while True:
        overrides: dict[str, object] = {
            name: hostile_value(parameter, random)
            for name, parameter in PARAMETERS.items()
            if (parameter.choices or not parameter.is_text)
            and name.startswith(groups)
            and random.random() < share
        }
        try:
            return load_settings(_CONFIG / f"{base}.yaml", overrides)
        except SettingsError:
            share *= 0.95  # a geometry that cannot be; ask for less of it
