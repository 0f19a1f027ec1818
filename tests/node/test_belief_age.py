"""A belt ages while nobody measures it, and what is recorded then is of then."""

from pathlib import Path

import pytest
from belt_msgs.srv import RecordMaintenance
from node_harness import PAPER_DRIVE

from belt_ros.estimation import Measurement, Quantity, Rejection
from belt_ros.node import services
from belt_ros.node.memory import Memory
from belt_ros.node.pipeline import Pipeline
from belt_ros.settings import load_settings

DATE = 1.7e9
DAY = 86400.0
STEP_NS = 10_000_000


class Machine:
    """A node's drive, on clocks that go on together: wall, steady and ROS time."""

    def __init__(self, path: Path, now: float = 0.0) -> None:
        self.now = now
        self._path = path
        self._start()

    def _start(self) -> None:
        settings = load_settings(PAPER_DRIVE)
        self.pipeline = Pipeline("node", ("/joint_states",), settings, steady=lambda: self.now)
        self.memory = Memory(
            self._path, self.pipeline, pytest.fail, lambda: DATE + self.now, lambda: self.now
        )
        self.said = self.memory.restore()

    def run(self, samples: int = 300) -> Quantity:
        """Turn without load; return the tension [N]."""
        for _ in range(samples):
            self.now += STEP_NS * 1e-9
            outcome = self.take(self.now)
        assert outcome.estimate is not None
        return outcome.estimate.mean_tension

    def take(self, stamp: float):
        stamp_ns = round(stamp * 1e9)
        measurement = Measurement(stamp_ns, 120.0, 120.0, 1.0, -1.0)
        return self.pipeline.take(measurement, stamp_ns, round(self.now * 1e9))

    def stand(self, seconds: float) -> "Machine":
        self.now += seconds
        return self

    def retension(self, value: float = 300.0, stddev: float = 5.0) -> None:
        request = RecordMaintenance.Request(
            action=RecordMaintenance.Request.RE_TENSIONED, value=value, value_stddev=stddev
        )
        assert services.record_maintenance(self.pipeline, self.memory, request).success

    def restart(self) -> "Machine":
        self.memory.close()
        self._start()
        return self


def assert_as_set(tension: Quantity) -> None:
    assert tension.value == pytest.approx(300.0, abs=10.0)
    assert tension.stddev < 15.0


@pytest.mark.parametrize("days", [0.5, 3.0, 30.0])
def test_a_tension_set_while_the_drive_stands_is_not_forgotten_by_the_stop(
    tmp_path: Path, days: float
) -> None:
    machine = Machine(tmp_path / "belt.json")
    machine.run()
    machine.stand(days * DAY).retension()
    assert_as_set(machine.stand(2.0).run(50))


def test_it_is_remembered_as_of_then(tmp_path: Path) -> None:
    machine = Machine(tmp_path / "belt.json")
    machine.run()
    machine.stand(3.0 * DAY).retension()
    machine.restart()
    assert "learned 0 s ago" in machine.said
    assert_as_set(machine.stand(60.0).run(50))


def test_a_file_and_a_wait_for_the_first_message_age_a_belt_alike(tmp_path: Path) -> None:
    spreads = []
    for before in (0.0, 7.0, 3.5):
        machine = Machine(tmp_path / f"{before}.json")
        machine.run()
        machine.retension()
        machine.stand(before * DAY).restart()
        spreads.append(machine.stand((7.0 - before) * DAY).run(50).stddev)
    assert min(spreads) > 20.0
    assert max(spreads) < 1.1 * min(spreads)


def test_what_stands_active_or_inactive_is_as_old_as_it_is(tmp_path: Path) -> None:
    """Activating a node again measures nothing."""
    machine = Machine(tmp_path / "belt.json")
    machine.run()
    machine.stand(3.0 * DAY)
    machine.pipeline.begin()
    learned = machine.pipeline.learned(DATE + machine.now)
    assert learned is not None
    assert learned.date == pytest.approx(DATE + machine.now - 3.0 * DAY, abs=1.0)


def test_an_odd_stamp_after_activation_does_not_throw_the_run_away(tmp_path: Path) -> None:
    machine = Machine(tmp_path / "belt.json")
    machine.run()
    machine.retension()
    machine.stand(2.0).pipeline.begin()
    assert machine.take(machine.now + 300.0).reason is Rejection.OUT_OF_ORDER
    assert machine.stand(0.01).take(machine.now).reason is Rejection.NONE
    assert_as_set(machine.run(50))
    assert machine.pipeline.health.resets == 0


def test_what_was_restored_is_as_old_as_its_file(tmp_path: Path) -> None:
    """The time before it was restored, by the same clocks, counts once."""
    machine = Machine(tmp_path / "belt.json")
    machine.run()
    machine.retension()
    machine.memory.close()
    later = Machine(tmp_path / "belt.json", machine.now)
    later.stand(5.0 * DAY)
    assert "2 d" not in later.said
    late = later.pipeline.learned(DATE + later.now)
    assert late is not None
    assert late.date == pytest.approx(DATE + machine.now, abs=1.0)
