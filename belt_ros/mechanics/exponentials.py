"""e^x - 1 and ln(1 + y) to the last digit but one, compiled.

`math.expm1` and `math.log1p` take more than twice the time of `exp` and `log`, and the inner loops
call them hundreds of times a step. Only near zero are their digits needed.
"""

import math

from belt_ros.mechanics._compile import compiled

_FAR = 0.4  # from zero: beyond it, the plain forms lose no more than one digit in 2e15


@compiled
def exp_minus_one(x: float, grown: float) -> float:
    """Return e^x - 1, where `grown` = e^x is at hand."""
    return grown - 1.0 if abs(x) > _FAR else math.expm1(x)


@compiled
def log_one_plus(y: float) -> float:
    """Return ln(1 + y)."""
    return math.log(1.0 + y) if abs(y) > _FAR else math.log1p(y)
