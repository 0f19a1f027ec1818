"""Numbers as they are written in a report: rounded by their errors, with a unit."""

import math

MINUS = "−"
UNKNOWN = "not known"
SPACE = "\u00a0"  # between number and unit, so that no line breaks there
_TWO_DIGITS_BELOW = 355  # of an error's first three digits: the Particle Data Group's rule
_DIGITS = 4  # of a number without an error
_PLAIN_BELOW = 7  # digits before the point


def decimals_of_error(error: float) -> int:
    """Return how many decimals a positive `error` deserves; negative: digits before the point.

    Two digits are kept while the first three are below 355, else one
    (Particle Data Group, Review of Particle Physics, introduction, section 5.3).
    """
    exponent = math.floor(math.log10(error))
    leading = error / 10.0 ** (exponent - 2)
    if leading < _TWO_DIGITS_BELOW:
        return 1 - exponent
    return -exponent  # 950 and more become 1000, of which this keeps two


def fixed(value: float, decimals: int) -> str:
    """Return a number rounded to `decimals`, which may be negative, with a true minus sign."""
    text = f"{round(value, decimals):.{max(decimals, 0)}f}"
    if float(text) == 0.0:
        text = text.lstrip("-")
    return text.replace("-", MINUS)


def plain(value: float | None, digits: int = _DIGITS) -> str:
    """Return a number without an error to so many significant digits."""
    if value is None or not math.isfinite(value):
        return UNKNOWN
    if value == 0.0:
        return "0"
    before = math.floor(math.log10(abs(value))) + 1
    if not -3 < before <= _PLAIN_BELOW:
        return f"{value:.{digits - 1}e}".replace("-", MINUS)
    return fixed(value, digits - before)


def with_error(
    value: float | None, stddev: float | None, unit: str = "", factor: float = 1.0
) -> str:
    """Return value and standard deviation, both rounded by the latter, and the unit.

    Parameters
    ----------
    value, stddev : float or None
        None or NaN: not known.
    unit : str
        In which they are shown.
    factor : float
        What turns them into this unit.
    """
    if value is None or not math.isfinite(value):
        return UNKNOWN
    tail = f"{SPACE}{unit}" if unit else ""
    if stddev is None or not math.isfinite(stddev) or stddev <= 0.0:
        return plain(value * factor) + tail
    shown, error = value * factor, stddev * factor
    decimals = decimals_of_error(error)
    if not -_PLAIN_BELOW < decimals < 2 * _PLAIN_BELOW:
        return f"{plain(shown)} ± {plain(error, 2)}{tail}"
    return f"{fixed(shown, decimals)} ± {fixed(error, decimals)}{tail}"


def duration(seconds: float) -> str:
    """Return a length of time as it is spoken of: 23.0 s, 4 min 10 s, 3 h 05 min, 12 d 4 h."""
    if seconds < 100.0:
        return f"{plain(seconds, 3)}{SPACE}s"
    minutes = round(seconds / 60.0)
    if minutes < 100:
        whole = round(seconds)
        return f"{whole // 60}{SPACE}min {whole % 60:02d}{SPACE}s"
    hours = round(seconds / 3600.0)
    if hours < 48:
        return f"{minutes // 60}{SPACE}h {minutes % 60:02d}{SPACE}min"
    return f"{hours // 24}{SPACE}d {hours % 24}{SPACE}h"


def count(number: int, noun: str, plural: str = "") -> str:
    """Return a number with its noun: 1 gap, 2 gaps, no gaps."""
    many = plural or f"{noun}s"
    return f"{number or 'no'} {noun if number == 1 else many}"
