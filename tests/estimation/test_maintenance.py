import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sums import moments

from belt_ros.estimation import Prior
from belt_ros.estimation.condensing import MEMBERS
from belt_ros.estimation.gaussian_sum import Component, normalised
from belt_ros.estimation.maintenance import Maintenance, MaintenanceKind, maintained
from belt_ros.estimation.process import lognormal, prior_state
from belt_ros.estimation.state import STATES, Index
from belt_ros.mechanics import Belt, BeltDrive, Pulley
from belt_ros.mechanics.drive import DriveError

DRIVE = BeltDrive(
    Belt(80068.0, 0.1036), Pulley(0.08, 3.0, 0.5, 1e8), Pulley(0.06, 2.9, 0.6, 2e8), 0.5
)
MEAN, STDDEV = prior_state(Prior(), DRIVE)
RETENSIONED, BELT_REPLACED, TENSION_MEASURED = MaintenanceKind
TENSION, STIFFNESS, FRICTION = Index.LOG_TENSION, Index.LOG_STIFFNESS, Index.LOG_FRICTION
BIAS, ERROR = Index.RATIO_BIAS, Index.CREEP_ERROR
exactly = settings(derandomize=True, deadline=None, max_examples=60)


class Members(list[Component]):
    def __repr__(self) -> str:
        return f"{len(self)} members"


@st.composite
def members(draw: st.DrawFn) -> Members:
    """Members of a filter in the middle of its work, all states going with all others."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    out = Members()
    for _ in range(draw(st.integers(1, 50))):
        factor = rng.standard_normal((STATES, STATES)) * rng.uniform(0.02, 0.4)
        mean = MEAN + STDDEV * rng.standard_normal(STATES)
        covariance = np.outer(STDDEV, STDDEV) * (factor @ factor.T)
        out.append(Component(rng.uniform(-5.0, 0.0), mean, covariance, bool(rng.random() < 0.2)))
    return out


def known(tension: float = 500.0, spread: float = 0.05, together: float = 0.8) -> Component:
    """One member whose tension, kf and mu go `together`."""
    deviation = 0.1 * STDDEV
    deviation[TENSION] = spread
    mean = MEAN + 0.3 * STDDEV
    mean[TENSION] = math.log(tension)
    correlation = np.eye(STATES)
    for place in (STIFFNESS, FRICTION):
        correlation[TENSION, place] = correlation[place, TENSION] = 0.7 * together
    return Component(0.0, mean, correlation * np.outer(deviation, deviation))


def after(components: list[Component], kind: MaintenanceKind, *value: float) -> list[Component]:
    return maintained(components, Maintenance(kind, *value), MEAN, STDDEV).components


def assert_close(actual: np.ndarray, expected: np.ndarray, unit: np.ndarray) -> None:
    np.testing.assert_allclose(actual / unit, expected / unit, rtol=1e-9, atol=1e-9)


maintenances = st.one_of(
    st.builds(
        lambda kind, tension, error: Maintenance(kind, tension, error * tension),
        st.sampled_from(MaintenanceKind),
        st.floats(1.0, 1e5),
        st.floats(1e-3, 0.9),
    ),
    st.just(Maintenance(BELT_REPLACED)),
    st.builds(Maintenance, st.sampled_from([RETENSIONED, BELT_REPLACED]), st.floats(1.0, 1e5)),
)


@exactly
@given(members(), maintenances)
def test_what_is_left_is_proper_bounded_and_settled(components, maintenance) -> None:
    before = [(c.log_weight, c.mean.copy(), c.covariance.copy(), c.changing) for c in components]
    result = maintained(components, maintenance, MEAN, STDDEV)
    assert 1 <= len(result.components) <= MEMBERS
    assert result.message
    assert "\n" not in result.message
    for component in result.components:
        assert not component.changing
        assert math.isfinite(component.log_weight)
        assert np.all(np.isfinite(component.mean))
        unit = np.sqrt(np.diag(component.covariance))
        correlation = component.covariance / np.outer(unit, unit)
        assert np.array_equal(component.covariance, component.covariance.T)
        assert np.min(np.linalg.eigvalsh(correlation)) >= -1e-9
    for component, (log_weight, mean, covariance, changing) in zip(components, before, strict=True):
        assert (component.log_weight, component.changing) == (log_weight, changing)
        assert np.array_equal(component.mean, mean)
        assert np.array_equal(component.covariance, covariance)


# Re-tensioned


@exactly
@given(members(), st.floats(50.0, 5e3), st.floats(1e-3, 0.5))
def test_a_new_tension_has_nothing_to_do_with_the_old_one_and_all_else_stays(
    components, tension, error
) -> None:
    mean, covariance = moments(components)
    new_mean, new_covariance = moments(
        after(components, RETENSIONED, tension, error * tension),
    )
    value, spread = lognormal(tension, error * tension)
    assert new_mean[TENSION] == pytest.approx(value, rel=1e-12)
    assert new_covariance[TENSION, TENSION] == pytest.approx(spread**2, rel=1e-9)
    others = [place for place in Index if place is not TENSION]
    assert np.max(np.abs(new_covariance[TENSION, others])) < 1e-12
    assert_close(new_mean[others], mean[others], STDDEV[others])
    unit = np.outer(STDDEV, STDDEV)
    places = np.ix_(others, others)
    assert_close(new_covariance[places], covariance[places], unit[places])


def test_a_new_tension_of_unknown_error_is_as_uncertain_as_the_prior() -> None:
    mean, covariance = moments(after([known()], RETENSIONED, 700.0))
    assert covariance[TENSION, TENSION] == pytest.approx(STDDEV[TENSION] ** 2)
    assert mean[TENSION] + 0.5 * covariance[TENSION, TENSION] == pytest.approx(math.log(700.0))


# Belt replaced


@exactly
@given(members())
def test_a_new_belt_is_at_the_prior_and_the_pulleys_are_the_old_ones(components) -> None:
    mean, covariance = moments(components)
    new_mean, new_covariance = moments(after(components, BELT_REPLACED))
    fresh = [TENSION, STIFFNESS, FRICTION, ERROR]
    assert_close(new_mean[fresh], MEAN[fresh], STDDEV[fresh])
    unit = np.outer(STDDEV, STDDEV)
    expected = np.diag(STDDEV**2)[fresh]
    assert_close(new_covariance[fresh], expected, unit[fresh])
    assert new_mean[BIAS] == pytest.approx(mean[BIAS] * math.sqrt(0.5), rel=1e-9, abs=1e-15)
    half = 0.5 * (covariance[BIAS, BIAS] + STDDEV[BIAS] ** 2)
    assert new_covariance[BIAS, BIAS] == pytest.approx(half, rel=1e-9)


def test_a_new_belt_of_known_tension_has_that_one() -> None:
    mean, covariance = moments(after([known()], BELT_REPLACED, 700.0, 35.0))
    value, spread = lognormal(700.0, 35.0)
    assert mean[TENSION] == pytest.approx(value)
    assert covariance[TENSION, TENSION] == pytest.approx(spread**2)
    assert mean[STIFFNESS] == pytest.approx(MEAN[STIFFNESS])


# Tension measured


def test_a_measurement_is_taken_in_as_by_a_kalman_filter() -> None:
    prior = known(500.0, 0.1)
    (posterior,) = after([prior], TENSION_MEASURED, 550.0, 20.0)
    value, spread = lognormal(550.0, 20.0)
    information = np.linalg.inv(prior.covariance)
    information[TENSION, TENSION] += 1.0 / spread**2
    covariance = np.linalg.inv(information)
    gain = covariance[:, TENSION] / spread**2
    assert_close(posterior.covariance, covariance, np.outer(STDDEV, STDDEV))
    assert_close(posterior.mean, prior.mean + gain * (value - prior.mean[TENSION]), STDDEV)


def test_a_measurement_tells_of_all_that_goes_with_tension() -> None:
    tighter = after([known(together=0.8)], TENSION_MEASURED, 550.0, 5.0)[0]
    alone = after([known(together=0.0)], TENSION_MEASURED, 550.0, 5.0)[0]
    assert tighter.mean[FRICTION] > known().mean[FRICTION]
    assert alone.mean[FRICTION] == known().mean[FRICTION]


def test_members_are_weighed_by_how_well_they_foretold_the_measurement() -> None:
    """Against Bayes' rule on a grid of tensions."""
    sum_before = [known(300.0, 0.1), known(450.0, 0.2)]
    sum_before[1].log_weight = math.log(0.5)
    sum_after = after(sum_before, TENSION_MEASURED, 400.0, 60.0)
    value, spread = lognormal(400.0, 60.0)
    x = np.linspace(math.log(100.0), math.log(1500.0), 20001)

    def density(components: list[Component]) -> np.ndarray:
        total = np.zeros_like(x)
        for c in components:
            variance = c.covariance[TENSION, TENSION]
            squared = (x - c.mean[TENSION]) ** 2 / variance
            total += np.exp(c.log_weight - 0.5 * squared) / math.sqrt(variance)
        return total / np.sum(total)

    expected = density(sum_before) * np.exp(-0.5 * ((x - value) / spread) ** 2)
    np.testing.assert_allclose(
        density(sum_after), expected / np.sum(expected), rtol=1e-9, atol=1e-12
    )


def test_a_measurement_that_the_belief_does_not_explain_is_taken_for_the_tension() -> None:
    result = maintained(
        [known(500.0, 0.05)], Maintenance(TENSION_MEASURED, 300.0, 10.0), MEAN, STDDEV
    )
    mean, covariance = moments(result.components)
    value, spread = lognormal(300.0, 10.0)
    assert mean[TENSION] == pytest.approx(value)
    assert covariance[TENSION, TENSION] == pytest.approx(spread**2)
    assert "does not explain" in result.message


def test_what_went_with_a_tension_that_was_wrong_is_half_kept_and_half_forgotten() -> None:
    before = known(500.0, 0.05)
    result = after([before], TENSION_MEASURED, 300.0, 10.0)
    weights = normalised(np.array([c.log_weight for c in result]))
    np.testing.assert_allclose(weights, 0.5)
    for place in (STIFFNESS, FRICTION):
        found = sorted(c.mean[place] for c in result)
        assert found == pytest.approx(sorted([MEAN[place], before.mean[place]]))
        found = sorted(c.covariance[place, place] for c in result)
        assert found == pytest.approx([before.covariance[place, place], STDDEV[place] ** 2])
    assert all(c.mean[BIAS] == before.mean[BIAS] for c in result)


@pytest.mark.parametrize(("deviations", "explained"), [(3.2, True), (3.4, False)])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_one_case_in_a_thousand_is_the_limit_of_what_is_explained(
    deviations, explained, side
) -> None:
    """3.29 deviations, of belief and gauge together, if the belief is one Gaussian."""
    value, spread = lognormal(400.0, 20.0)
    belief = known(spread=0.08)
    belief.mean[TENSION] = value + side * deviations * math.hypot(spread, 0.08)
    message = maintained([belief], Maintenance(TENSION_MEASURED, 400.0, 20.0), MEAN, STDDEV).message
    assert ("does not explain" not in message) is explained


def test_a_measurement_between_two_members_that_both_exclude_it_is_not_explained() -> None:
    """Though it lies in the middle of the belief, and within its standard deviation."""
    apart = [known(250.0, 0.03), known(640.0, 0.03)]
    message = maintained(apart, Maintenance(TENSION_MEASURED, 400.0, 10.0), MEAN, STDDEV).message
    assert "does not explain" in message


# What is refused


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        ((RETENSIONED,), "missing; give it in N"),
        ((TENSION_MEASURED, math.nan, 5.0), "missing; give it in N"),
        ((TENSION_MEASURED, 400.0), "needs its standard deviation"),
        ((BELT_REPLACED, math.nan, 5.0), "5 N needs its tension"),
        ((RETENSIONED, 0.0), "0 N; it must lie between 0.001 and"),
        ((RETENSIONED, -400.0), "-400 N"),
        ((RETENSIONED, math.inf), "inf N"),
        ((RETENSIONED, 400.0, 0.0), "0 N; it must lie between 0.04 N"),
        ((RETENSIONED, 400.0, -1.0), "-1 N"),
        ((TENSION_MEASURED, 400.0, 500.0), "500 N; it must lie between 0.04 N and the tension"),
        ((TENSION_MEASURED, 400.0, math.inf), "inf N"),
    ],
)
def test_maintenance_that_makes_no_sense_is_refused_with_the_reason(arguments, reason) -> None:
    with pytest.raises(DriveError, match=reason):
        Maintenance(*arguments)


def test_kinds_have_the_numbers_of_the_service() -> None:
    assert [int(kind) for kind in MaintenanceKind] == [1, 2, 3]


def test_messages_say_what_was_done_in_numbers() -> None:
    def message(*what: float) -> str:
        return maintained([known(500.0, 0.05)], Maintenance(*what), MEAN, STDDEV).message

    assert message(RETENSIONED, 700.0, 35.0) == (
        "re-tensioned from 500.6 +/- 25.05 N to 700 +/- 35 N; friction and its stiffness are kept"
    )
    assert message(BELT_REPLACED).startswith("belt replaced; tension is 400 +/- 120 N")
    assert message(TENSION_MEASURED, 510.0, 10.0).startswith("tension measured as 510 +/- 10 N")
