import dataclasses
import json
import math
import subprocess
import sys
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
from bags import PERIOD_NS, Sample, steady_run, write_bag
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st
from rosbags.highlevel import AnyReader

from belt_ros.estimation import Measurement, Rejection
from belt_ros.message_fields import state_fields
from belt_ros.replay import BagError, ResultsError, replay

DATA = Path(__file__).parents[1] / "data"
STATE, ALARM = "/belt_node/state", "/belt_node/alarm"


def messages(out, topic):
    """Log time and message, decoded with the types that the bag itself carries."""
    with AnyReader([out / "estimates"]) as reader:
        chosen = [item for item in reader.connections if item.topic == topic]
        return [
            (log_ns, reader.deserialize(data, connection.msgtype))
            for connection, log_ns, data in reader.messages(chosen)
        ]


def stamp_ns(message):
    return message.header.stamp.sec * 1_000_000_000 + message.header.stamp.nanosec


def contents(out):
    return {path.relative_to(out): path.read_bytes() for path in out.rglob("*") if path.is_file()}


def test_states_are_those_of_the_monitor_bit_by_bit(make_bag, settings, tmp_path):
    samples = steady_run(40)
    replay(make_bag(samples), settings, tmp_path / "out")
    monitor = settings.monitor()
    for sample, (log_ns, message) in zip(samples, messages(tmp_path / "out", STATE), strict=True):
        measurement = Measurement(sample.stamp_ns, *sample.velocity, *sample.effort)
        fields = state_fields(settings.name, monitor.step(measurement).estimate)
        assert log_ns == sample.log_ns
        assert stamp_ns(message) == sample.stamp_ns
        for name, value in fields.items():
            np.testing.assert_array_equal(getattr(message, name), value, err_msg=name)


def test_table_and_bag_hold_the_same(make_bag, settings, tmp_path):
    replay(make_bag(steady_run(40)), settings, tmp_path / "out")
    table = pq.read_table(tmp_path / "out" / "estimates.parquet")
    states = messages(tmp_path / "out", STATE)
    columns = table.to_pydict()
    assert columns.pop("stamp_ns") == [stamp_ns(message) for _, message in states]
    assert columns.pop("log_time_ns") == [log_ns for log_ns, _ in states]
    for name, values in columns.items():
        if name.startswith("rejected_"):
            reason = Rejection[name.removeprefix("rejected_").upper()]
            assert values == [message.rejection_counts[reason] for _, message in states]
        else:
            np.testing.assert_array_equal(values, [getattr(state, name) for _, state in states])
    fields = {field.name for field in dataclasses.fields(states[0][1]) if field.name[0].islower()}
    assert fields - set(columns) == {"header", "drive_name", "rejection_counts"}
    assert table.schema.metadata[b"drive_name"] == settings.name.encode()


def test_columns_carry_their_units(make_bag, settings, tmp_path):
    replay(make_bag(steady_run(3)), settings, tmp_path / "out")
    schema = pq.read_schema(tmp_path / "out" / "estimates.parquet")
    units = {field.name: (field.metadata or {}).get(b"unit") for field in schema}
    assert units["driver_speed_stddev"] == b"rad/s"
    assert units["friction_stiffness"] == b"N/m2"
    assert units["margin"] == b"-"
    assert units["stamp_ns"] == b"ns"


def test_two_runs_are_identical_byte_by_byte(make_bag, settings, tmp_path):
    bag = make_bag(steady_run(30))
    replay(bag, settings, tmp_path / "first" / "out")
    replay(bag, settings, tmp_path / "second" / "out")
    assert contents(tmp_path / "first" / "out") == contents(tmp_path / "second" / "out")


def test_memory_holds_one_row_group_at_most(make_bag, settings, tmp_path, monkeypatch):
    monkeypatch.setattr("belt_ros.replay.tables._ROW_GROUP", 8)
    replay(make_bag(steady_run(20)), settings, tmp_path / "out")
    table = pq.ParquetFile(tmp_path / "out" / "estimates.parquet")
    assert [table.metadata.row_group(i).num_rows for i in range(3)] == [8, 8, 4]
    assert table.read()["accepted_count"].to_pylist() == list(range(1, 21))


def test_bad_messages_are_counted_by_their_reason(make_bag, settings, tmp_path):
    samples = [*steady_run(20)]
    speeds, torques = samples[0].velocity, samples[0].effort

    def spoil(place, **changes):
        samples[place] = samples[place]._replace(**changes)

    spoil(3, velocity=(math.nan, math.nan), effort=(math.nan, math.nan))
    spoil(5, velocity=(speeds[0], math.inf))
    spoil(7, effort=(-math.inf, torques[1]))
    spoil(9, stamp_ns=samples[8].stamp_ns)
    spoil(11, stamp_ns=samples[8].stamp_ns - PERIOD_NS)
    spoil(13, velocity=(1e9, speeds[1]))
    spoil(15, velocity=(1.0,))
    summary = replay(make_bag(samples), settings, tmp_path / "out")
    assert summary.rejected == {
        "not_finite": 3,
        "out_of_range": 1,
        "stale": 0,
        "out_of_order": 2,
        "gated": 0,
        "incomplete": 0,
        "malformed": 1,
    }
    assert summary.accepted == len(messages(tmp_path / "out", STATE)) == 13


def test_summary_reads_like_the_states(make_bag, settings, tmp_path):
    samples = steady_run(30)
    summary = replay(make_bag(samples), settings, tmp_path / "out")
    states = [message for _, message in messages(tmp_path / "out", STATE)]
    assert summary.duration == pytest.approx(29 * PERIOD_NS * 1e-9)
    assert summary.worst_margin.value == min(state.margin for state in states)
    assert summary.greatest_slip.value == max((state.slip for state in states), key=abs)
    assert sum(summary.time_in_phase.values()) == pytest.approx(summary.duration)
    assert sum(summary.time_in_severity.values()) == pytest.approx(summary.duration)
    final = summary.final["mean_tension"]
    assert (final.value, final.stddev) == (states[-1].mean_tension, states[-1].mean_tension_stddev)
    assert final.low == final.value - 1.96 * final.stddev
    stiffness = summary.final["friction_stiffness"]
    spread = states[-1].friction_stiffness_log_stddev
    assert stiffness.high == pytest.approx(stiffness.value * math.exp(1.96 * spread))
    assert stiffness.unit == "N/m2"


def test_summary_is_strict_json(make_bag, settings, tmp_path):
    replay(make_bag(steady_run(5)), settings, tmp_path / "out")

    def refuse(constant):
        raise AssertionError(constant)

    text = (tmp_path / "out" / "summary.json").read_text(encoding="utf-8")
    summary = json.loads(text, parse_constant=refuse)
    assert summary["config"]["prior"]["tension"] == settings.prior.tension
    assert summary["config"]["drive"]["kinematics"] == settings.drive.kinematics.value
    assert summary["versions"]["belt_ros"]
    assert str(tmp_path) not in text


def test_alarm_is_told_at_the_start_and_after_a_reset(make_bag, settings, tmp_path):
    once = steady_run(10)
    again = [
        sample._replace(log_ns=sample.log_ns + 10**9, stamp_ns=sample.stamp_ns - 10**10)
        for sample in once
    ]
    summary = replay(make_bag([*once, *again]), settings, tmp_path / "out")
    alarms = messages(tmp_path / "out", ALARM)
    assert summary.resets == 1
    assert summary.rejected["out_of_order"] == 2
    assert [message.severity for _, message in alarms] == [0, 0]
    assert [log_ns for log_ns, _ in alarms] == [once[0].log_ns, again[2].log_ns]


def test_foreign_joints_are_named(make_bag, settings, tmp_path):
    bag = make_bag(steady_run(4), joints=("shoulder", "elbow"))
    with pytest.raises(BagError, match=r"no message on /joint_states is of this.*shoulder, elbow"):
        replay(bag, settings, tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_velocities_that_are_missing_are_not_blamed_on_the_names_of_joints(
    make_bag, settings, tmp_path
):
    samples = [
        sample._replace(velocity=(sample.velocity[0], math.nan)) for sample in steady_run(20)
    ]
    with pytest.raises(BagError, match="Velocities are missing or NaN") as error:
        replay(make_bag(samples), settings, tmp_path / "out")
    assert "driver.joint" not in str(error.value)


def test_an_empty_topic_is_named(make_bag, settings, tmp_path):
    with pytest.raises(BagError, match="/joint_states holds no messages"):
        replay(make_bag([]), settings, tmp_path / "out")


class StopError(Exception):
    pass


def stop(_done, _total):
    raise StopError


def test_a_failing_run_leaves_nothing(make_bag, settings, tmp_path):
    bag = make_bag(steady_run(120))
    with pytest.raises(StopError):
        replay(bag, settings, tmp_path / "out", progress=stop)
    assert [path.name for path in tmp_path.iterdir()] == ["bag"]


def test_a_failing_run_keeps_earlier_results(make_bag, settings, tmp_path):
    bag = make_bag(steady_run(120))
    replay(bag, settings, tmp_path / "out")
    before = contents(tmp_path / "out")
    with pytest.raises(StopError):
        replay(bag, settings, tmp_path / "out", replace=True, progress=stop)
    assert contents(tmp_path / "out") == before
    assert sorted(path.name for path in tmp_path.iterdir()) == ["bag", "out"]


def test_earlier_results_are_replaced_on_request_only(make_bag, settings, tmp_path):
    bag = make_bag(steady_run(5))
    replay(bag, settings, tmp_path / "out")
    with pytest.raises(ResultsError, match="--force"):
        replay(bag, settings, tmp_path / "out")
    replay(bag, settings, tmp_path / "out", replace=True)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["bag", "out"]


def test_foreign_files_are_never_replaced(make_bag, settings, tmp_path):
    bag = make_bag(steady_run(5))
    with pytest.raises(ResultsError, match="other things"):
        replay(bag, settings, tmp_path, replace=True)
    with pytest.raises(ResultsError, match="no directory"):
        replay(bag, settings, bag / "metadata.yaml", replace=True)


def test_progress_counts_to_the_total(make_bag, settings, tmp_path):
    told = []
    replay(
        make_bag(steady_run(220)),
        settings,
        tmp_path / "out",
        progress=lambda done, total: told.append((done, total)),
    )
    assert told == [(100, 220), (200, 220)]


any_float = st.floats(allow_nan=True, allow_infinity=True)
pairs = st.one_of(st.tuples(any_float, any_float), st.just(()), st.tuples(any_float))
anything = st.builds(
    Sample, st.integers(1, 2**40), st.integers(0, 2**33), velocity=pairs, effort=pairs
)


@hypothesis_settings(max_examples=15, deadline=None)
@given(samples=st.lists(anything, min_size=1, max_size=8))
def test_whatever_a_bag_says_is_counted_and_no_state_is_nan(settings, tmp_path_factory, samples):
    place = tmp_path_factory.mktemp("any")
    bag = write_bag(place / "bag", {"/joint_states": [*steady_run(3), *samples]})
    summary = replay(bag, settings, place / "out")
    assert summary.messages == 3 + len(samples)
    assert summary.accepted + sum(summary.rejected.values()) == summary.messages
    json.loads((place / "out" / "summary.json").read_text(encoding="utf-8"))
    for _, state in messages(place / "out", STATE):
        assert math.isfinite(state.margin)
        assert math.isfinite(state.mean_tension)


@pytest.mark.skipif(not (DATA / "rig_bag").is_dir(), reason="tests/data/rig_bag is not there")
def test_rig_bag_raises_its_alarm_and_recovers(settings, tmp_path):
    summary = replay(DATA / "rig_bag", settings, tmp_path / "out")
    assert summary.accepted == summary.messages == 701
    assert summary.duration == pytest.approx(7.0)
    assert summary.time_in_phase["standstill"] > 0.1
    assert summary.alarms_raised >= 1
    severities = [message.severity for _, message in messages(tmp_path / "out", ALARM)]
    assert max(severities) >= 2


def test_needs_no_ros():
    code = "import sys, belt_ros.replay; print('rclpy' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"
