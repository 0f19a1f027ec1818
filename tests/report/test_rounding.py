import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from belt_ros.report.rounding import MINUS, SPACE, duration, fixed, plain, with_error


@pytest.mark.parametrize(
    ("value", "error", "written"),
    [
        (467.6972918, 189.5365693, "470 ± 190"),
        (435.4181038, 3.6528460, "435 ± 4"),
        (435.4181038, 3.1, "435.4 ± 3.1"),
        (0.01234567, 0.000354, "0.01235 ± 0.00035"),
        (0.01234567, 0.000356, "0.0123 ± 0.0004"),
        (12.3, 0.96, "12.3 ± 1.0"),
        (-0.0508855, 0.6399, f"{MINUS}0.1 ± 0.6"),
        (-0.0008, 0.64, "0.0 ± 0.6"),
        (123456.0, 2345.0, "123500 ± 2300"),
    ],
)
def test_value_and_error_end_at_the_same_digit(value, error, written):
    assert with_error(value, error) == written


def test_error_is_converted_with_the_value_and_the_unit_stays_on_the_line():
    assert with_error(6.2507e6, 250896.0, "MN/m²", 1e-6) == f"6.25 ± 0.25{SPACE}MN/m²"


@pytest.mark.parametrize("value", [None, math.nan, math.inf])
def test_what_is_not_known_is_said_so(value):
    assert with_error(value, 1.0, "N") == "not known"
    assert plain(value) == "not known"


@pytest.mark.parametrize("error", [None, math.nan, 0.0])
def test_a_number_without_an_error_has_four_digits(error):
    assert with_error(12.34567, error, "N") == f"12.35{SPACE}N"


@given(
    st.floats(-1e6, 1e6),
    st.floats(1e-5, 1e5),
)
@settings(derandomize=True, deadline=None)
def test_rounding_moves_a_value_by_less_than_a_sixth_of_its_error(value, error):
    number, shown_error = (
        float(part.replace(MINUS, "-")) for part in with_error(value, error).split(" ± ")
    )
    assert abs(number - value) <= error / 7.0 + 1e-9 * abs(value)
    assert shown_error == pytest.approx(error, rel=0.15)


def test_no_zero_is_negative():
    assert fixed(-0.001, 1) == "0.0"


@pytest.mark.parametrize(
    ("seconds", "written"),
    [
        (23.0, "23.0 s"),
        (250.0, "4 min 10 s"),
        (11_100.0, "3 h 05 min"),
        (1_051_200.0, "12 d 4 h"),
    ],
)
def test_lengths_of_time_read_as_they_are_spoken(seconds, written):
    assert duration(seconds).replace(SPACE, " ") == written
