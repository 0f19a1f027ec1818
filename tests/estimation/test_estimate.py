import math

import numpy as np
import pytest

from belt_ros.estimation.estimate import (
    UNKNOWN_FIT,
    UNKNOWN_LOSS,
    UNKNOWN_RESERVE,
    Consistency,
    log_spread,
    lognormal_quantity,
)
from belt_ros.message_types import belt_typestore


@pytest.mark.parametrize("spread", [1e-6, 0.05, 1.15, 3.0])
def test_a_log_normal_gives_its_spread_back(spread) -> None:
    assert log_spread(lognormal_quantity(math.log(5e6), spread)) == pytest.approx(spread, rel=1e-4)


def test_its_deviation_is_that_of_its_samples() -> None:
    samples = np.exp(2.0 + 0.4 * np.random.default_rng(0).standard_normal(400_000))
    quantity = lognormal_quantity(2.0, 0.4)
    assert quantity.value == pytest.approx(np.median(samples), rel=5e-3)
    assert quantity.stddev == pytest.approx(np.std(samples), rel=5e-3)


@pytest.mark.parametrize("log_mean", [-1e4, -700.0, 700.0, 1e4, 1e300])
@pytest.mark.parametrize("spread", [0.0, 1.0, 30.0, 1e200])
def test_the_wildest_belief_is_finite_numbers(log_mean, spread) -> None:
    quantity = lognormal_quantity(log_mean, spread)
    assert np.all(np.isfinite(quantity))
    assert quantity.value > 0.0


def test_what_is_not_known_is_no_number() -> None:
    fit, reserve, lost = UNKNOWN_FIT, UNKNOWN_RESERVE, UNKNOWN_LOSS
    assert fit.consistency is Consistency.UNKNOWN
    assert np.all(np.isnan([*reserve.capacity_torque, *lost]))
    assert [*fit[1:], reserve.gross_slip_probability_at_peak_load] == [0.0] * 4


def test_verdicts_are_numbered_as_in_the_message() -> None:
    message = belt_typestore().types["belt_msgs/msg/BeltState"]
    for verdict in Consistency:
        assert getattr(message, f"FIT_{verdict.name}") == verdict
