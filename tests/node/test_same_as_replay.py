"""The node fed from a bag over DDS, and `belt replay` of that bag: the same bits."""

from pathlib import Path

import numpy as np
from node_harness import PAPER_DRIVE, Client, NodeProcess
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore

from belt_ros.message_types import belt_typestore
from belt_ros.replay import STATE_TOPIC, replay
from belt_ros.settings import load_settings

BAG = Path(__file__).resolve().parents[1] / "data" / "rig_bag"


def joint_states() -> list[bytes]:
    with AnyReader([BAG], default_typestore=get_typestore(Stores.ROS2_JAZZY)) as reader:
        chosen = [item for item in reader.connections if item.topic == "/joint_states"]
        return [bytes(data) for _, _, data in reader.messages(chosen)]


def replayed(out: Path) -> list[object]:
    with AnyReader([out / "estimates"], default_typestore=belt_typestore()) as reader:
        chosen = [item for item in reader.connections if item.topic == STATE_TOPIC]
        return [
            reader.deserialize(data, connection.msgtype)
            for connection, _, data in reader.messages(chosen)
        ]


def test_node_and_replay_give_the_same_bits(ros_domain: int, tmp_path: Path) -> None:
    messages = joint_states()
    client = Client(ros_domain)
    with NodeProcess(
        ros_domain, tmp_path / "node.log", PAPER_DRIVE, input_reliability="reliable"
    ) as node:
        node.wait_for_log("active")
        client.until(lambda: client.node.count_subscribers("joint_states") > 0)
        client.until(lambda: client.node.count_publishers("belt_node/state") > 0)
        client.spin(1.0)
        for k, message in enumerate(messages):
            client.send_raw(message)
            if k % 50 == 49:
                client.until(lambda k=k: len(client.states) > k - 20)
        client.until(lambda: len(client.states) >= len(messages), timeout=60.0)
    live = client.states
    client.close()
    replay(BAG, load_settings(PAPER_DRIVE), tmp_path / "out")
    offline = replayed(tmp_path / "out")
    assert len(live) == len(offline) == len(messages)
    for ours, theirs in zip(offline, live, strict=True):
        for name in theirs.get_fields_and_field_types():
            if name == "header":
                assert ours.header.stamp.sec == theirs.header.stamp.sec
                assert ours.header.stamp.nanosec == theirs.header.stamp.nanosec
            else:
                np.testing.assert_array_equal(
                    getattr(ours, name), getattr(theirs, name), err_msg=name
                )
