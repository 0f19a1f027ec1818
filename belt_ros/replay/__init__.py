"""Bags in, results out, on machines with or without ROS: the monitor of the live node, offline."""

from belt_ros.replay.errors import BagError, ResultsError
from belt_ros.replay.results import ALARM_TOPIC, STATE_TOPIC
from belt_ros.replay.run import replay
from belt_ros.replay.summary import Summary

__all__ = [
    "ALARM_TOPIC",
    "STATE_TOPIC",
    "BagError",
    "ResultsError",
    "Summary",
    "replay",
]
