"""What the demonstration plays of a bag: its joint states as they were recorded, or nothing."""

import time

import pytest
from bags import cdr, steady_run, write_bag
from recordings import pulleys, record

from belt_ros.demo.player import Player
from belt_ros.replay import BagError


def test_joint_states_are_played_byte_by_byte_and_when_they_are_due(settings, tmp_path):
    samples = steady_run(20)
    bag = write_bag(tmp_path / "bag", {"/robot/joint_states": samples})
    published = []
    with Player(bag, settings, published.append, lambda: len(published)) as player:
        begin = time.monotonic()
        while player.play():
            time.sleep(0.001)
        elapsed = time.monotonic() - begin
    assert published == [cdr(sample) for sample in samples]
    assert player.sent == len(samples)
    assert elapsed >= (samples[-1].log_ns - samples[0].log_ns) * 1e-9


def test_a_bag_without_joint_states_is_refused_though_it_could_be_replayed(settings, tmp_path):
    bag = record(tmp_path / "bag", pulleys(3))
    with pytest.raises(BagError, match=r"no topic of type sensor_msgs/JointState"):
        Player(bag, settings, lambda _: None, lambda: 0)
