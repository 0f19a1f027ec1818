"""What each topic brings: rates, latencies, and clocks that do not agree."""

import itertools
import math

import pytest

from belt_ros.estimation import Rejection
from belt_ros.node.input_meter import InputMeter
from belt_ros.node.source_meter import SourceReport, clock_skew, clock_trouble

NAN = math.nan


def source(topic: str, offset: float) -> SourceReport:
    return SourceReport(topic, 100.0, offset, offset, offset, 0.0)


def test_every_topic_has_its_rate_and_latency() -> None:
    meter = InputMeter(10.0, ["/a", "/silent"])
    for number in range(4):
        meter.heard("/a", 0.001 * number, 10.0 + number)
    meter.heard("/b", NAN, 13.0)
    a, silent, b = meter.report(14.0).sources

    assert (a.topic, a.rate, a.silence) == ("/a", 1.0, 1.0)
    assert a.latency_mean == pytest.approx(0.0015)
    assert (a.latency_max, a.clock_offset) == (0.003, 0.0)
    assert (silent.topic, silent.rate, silent.silence) == ("/silent", 0.0, 4.0)
    assert math.isnan(silent.latency_mean)
    assert math.isnan(silent.clock_offset)
    assert (b.topic, b.rate) == ("/b", 0.25)
    assert math.isnan(b.latency_max)


def test_a_new_period_begins_anew() -> None:
    meter = InputMeter(0.0)
    meter.heard("/a", 0.5, 0.5)
    meter.report(1.0)
    (a,) = meter.report(2.0).sources

    assert a.rate == 0.0
    assert math.isnan(a.latency_max)
    assert a.silence == 1.5


def test_topics_do_not_change_what_is_counted_of_measurements() -> None:
    meter = InputMeter(0.0)
    meter.heard("/a", 0.5, 0.5)
    meter.heard("/b", 0.5, 0.5)
    meter.count(Rejection.NONE, 0.5, 0.5, 0.6)
    report = meter.report(1.0)

    assert (report.received, report.accepted) == (1, 1)
    assert report.silence == 0.5


def test_a_clock_that_is_ahead_is_seen_through_delays_within_eight_periods() -> None:
    meter = InputMeter(0.0)
    delays = itertools.cycle([0.03, 0.002, 0.2, 0.011])
    for period in range(8):
        for part in range(5):
            now = period + 0.1 * part
            meter.heard("/ahead", next(delays) - 0.5, now)
            meter.heard("/right", next(delays), now)
        sources = meter.report(period + 1.0).sources
    skew = clock_skew(sources)

    assert skew is not None
    assert skew.seconds == pytest.approx(0.5, abs=0.03)
    assert (skew.ahead, skew.behind) == ("/ahead", "/right")


def test_a_clock_that_has_been_put_right_is_so_after_eight_periods() -> None:
    meter = InputMeter(0.0)
    trouble = []
    for period in range(10):
        meter.heard("/a", -0.5 if period == 0 else 0.001, period)
        meter.heard("/b", 0.001, period)
        trouble.append(bool(clock_trouble(meter.report(period + 1.0).sources)))

    assert trouble == [True] * 8 + [False] * 2


@pytest.mark.parametrize("offsets", [(), (0.1,), (0.1, NAN)])
def test_one_clock_has_no_skew(offsets: tuple[float, ...]) -> None:
    assert clock_skew([source(f"/{place}", o) for place, o in enumerate(offsets)]) is None


@pytest.mark.parametrize(
    ("offsets", "words"),
    [
        ((0.001, 0.015), ()),
        ((0.001, 0.100), ("/0 are 0.099 s ahead of those of /1", "synchronise")),
        ((-3.0,), ("/0 are 3 s in the future", "use_sim_time")),
        ((-3.0, -3.001), ("in the future",)),
        ((1.7e9,), ("/0 are 1.7e+09 s old", "stamp its messages", "--clock")),
        ((NAN, NAN), ()),
    ],
)
def test_trouble_is_told_in_a_sentence(offsets: tuple[float, ...], words: tuple[str, ...]) -> None:
    told = clock_trouble([source(f"/{place}", offset) for place, offset in enumerate(offsets)])

    assert bool(told) == bool(words)
    assert all(word in told for word in words)


def test_limits_can_be_chosen() -> None:
    sources = [source("/a", 0.0), source("/b", 5.0)]

    assert clock_trouble(sources, skew_limit=6.0) == ""
    assert "old" in clock_trouble(sources, skew_limit=6.0, age_limit=4.0)
