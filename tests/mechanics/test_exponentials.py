"""e^x - 1 and ln(1 + y) against the library's own, to a few units in the last place."""

import math

from hypothesis import given, settings
from hypothesis import strategies as st

from belt_ros.mechanics.exponentials import exp_minus_one, log_one_plus

MANY = settings(max_examples=1000, deadline=None)
FEW_DIGITS = 1e-15


@MANY
@given(st.floats(-700.0, 700.0) | st.floats(-1.0, 1.0))
def test_a_growth_less_one_has_all_its_digits(x: float) -> None:
    found = exp_minus_one(x, math.exp(x))
    assert math.isclose(found, math.expm1(x), rel_tol=FEW_DIGITS)


@MANY
@given(st.floats(-1.0, 1e300, exclude_min=True) | st.floats(-0.999, 1.0))
def test_a_logarithm_of_more_than_one_has_all_its_digits(y: float) -> None:
    assert math.isclose(log_one_plus(y), math.log1p(y), rel_tol=FEW_DIGITS)


def test_without_bounds_they_are_what_the_limits_are() -> None:
    assert exp_minus_one(-math.inf, 0.0) == -1.0
    assert exp_minus_one(math.inf, math.inf) == math.inf
    assert log_one_plus(-1.0) == -math.inf
    assert math.isnan(log_one_plus(-2.0))
