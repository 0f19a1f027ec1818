import pytest

from belt_ros.report.alarm_history import AlarmHistory, Interval
from belt_ros.report.alarm_totals import AlarmTotal, alarm_totals
from belt_ros.report.result_directory import ReportError, SummaryValues

LOW, GROSS = 1, 3
HISTORY = AlarmHistory(
    (
        Interval(LOW, 1, 2.0, 3.0, "low"),
        Interval(LOW, 2, 3.0, 5.0, "lower"),
        Interval(LOW, 1, 8.0, 8.5, "low again"),
        Interval(GROSS, 3, 4.0, 5.0, "gross"),
    ),
    complete=True,
)
NOTHING = AlarmHistory((), complete=True)


def event(condition, severity, raised, duration):
    return {
        "condition": condition,
        "severity": severity,
        "raised_ns": round(raised * 1e9),
        "duration": duration,
    }


def totals(values, history=HISTORY):
    return alarm_totals(SummaryValues("summary.json", values), history)


EVENTS = [
    event("gross_slip", "trip", 14.0, 1.0),
    event("low_margin", "alarm", 12.0, 3.0),
    event("low_margin", "warning", 18.0, 0.5),
]


def test_events_of_the_summary_add_up_by_condition_in_the_order_of_their_first_time():
    assert totals({"alarms": EVENTS}) == (
        AlarmTotal("low margin", "alarm", 2, 3.5, 3.0, 2.0),
        AlarmTotal("gross slip", "trip", 1, 1.0, 1.0, 4.0),
    )


def test_older_results_are_added_up_from_their_bag():
    assert totals({}) == (
        AlarmTotal("low margin", "alarm", 2, 3.5, 3.0, 2.0),
        AlarmTotal("gross slip", "trip", 1, 1.0, 1.0, 4.0),
    )


def test_when_an_alarm_was_raised_is_not_known_without_the_bag():
    assert [total.first for total in totals({"alarms": EVENTS}, NOTHING)] == [None, None]


def test_without_alarms_there_are_no_totals():
    assert totals({"alarms": []}, NOTHING) == totals({}, NOTHING) == ()


def test_what_is_newer_than_this_program_is_named_as_it_calls_itself():
    (found,) = totals({"alarms": [event("belt_on_fire", "worst_of_all", 1.0, 2.0)]}, NOTHING)
    assert (found.condition, found.severity) == ("belt on fire", "worst of all")


@pytest.mark.parametrize("alarms", [3, {"x": 1}, [1], [{"condition": 3}], [{}]])
def test_damaged_events_are_refused(alarms):
    with pytest.raises(ReportError, match="is missing or damaged"):
        totals({"alarms": alarms})
