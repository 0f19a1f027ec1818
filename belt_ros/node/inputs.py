"""One drive's input: which topics, as what messages, and how they become measurements."""

import math
from collections.abc import Callable, Iterable
from functools import partial
from typing import Any

from belt_msgs.msg import PulleyState
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64

from belt_ros.drive_inputs import (
    FLOAT64,
    JOINT_STATE,
    PULLEY_STATE,
    Feed,
    feeds,
    stamp_of,
)
from belt_ros.estimation import Joint, Measurement, Rejection
from belt_ros.estimation.assembler import Assembler, Dropped
from belt_ros.estimation.joint_readings import JointReadings
from belt_ros.node.conversions import nanoseconds
from belt_ros.node.topic_hub import TopicHub
from belt_ros.node_tables import InputKind

Take = Callable[[Measurement | Rejection, str, int], None]
Heard = Callable[[str, int | None], None]
_ROUNDING = 1e-9  # [s]
_MOST_WAITING = 10_000  # samples: ten topics of 1 kHz for a second
_TYPES = {JOINT_STATE: JointState, PULLEY_STATE: PulleyState, FLOAT64: Float64}


class DriveInputs:
    """Subscribe to one drive's topics and make measurements of what comes.

    ============  =====================================================================
    kind          topics
    ============  =====================================================================
    JOINT_STATE   ``joint_states`` (sensor_msgs/JointState), without the prefix
    PULLEY_STATE  ``driver/state``, ``driven/state`` (belt_msgs/PulleyState)
    FLOAT64       ``driver/speed``, ``driver/torque``, ``driver/position`` and the same
                  of ``driven`` (std_msgs/Float64)
    ============  =====================================================================

    Names are relative. A Float64 has no stamp and gets the node's ROS time when it comes.

    Parameters
    ----------
    hub : TopicHub
    kind : InputKind
    prefix : str
        What stands before the names of the topics, e.g. ``drive_name/``.
    joints : tuple of Joint
        How driver and driven pulley appear in the messages, of whatever kind.
    window, slop : float
        As in `Assembler` [s].
    take : callable
        Called with a measurement, or with the reason why a message is none; the topic whose message
        this is or has released (empty: none has, but a `flush`); and the stamp [ns].
    disorder, gap : float
        As in `Assembler` [s].
    loads : bool
        Whether hub loads and span tension come as Float64 on ``driver/hub_load``,
        ``driven/hub_load`` and ``driven/span_tension``; a PulleyState carries them itself.
    heard : callable, optional
        Called with topic and stamp [ns] of every message as it comes, before `take` and also if
        it is another drive's; the stamp is None where it is no time.

    Raises
    ------
    SettingsError
        If a topic cannot be subscribed to.
    ValueError
        If a time is negative or not finite.
    """

    def __init__(
        self,
        hub: TopicHub,
        kind: InputKind,
        prefix: str,
        joints: tuple[Joint, Joint],
        window: float,
        slop: float,
        take: Take,
        *,
        disorder: float = 0.0,
        gap: float = 1.0,
        loads: bool = False,
        heard: Heard | None = None,
    ) -> None:
        self._hub = hub
        self._take = take
        self._heard = heard
        self._at_joints = kind is not InputKind.JOINT_STATE
        self._joints = joints
        found = feeds(kind, prefix, joints, loads=loads)
        self._assembler_of = partial(Assembler, window, slop, len(found), _MOST_WAITING, disorder)
        self._gap = gap
        self._patience = max(window, disorder) - _ROUNDING
        self.begin()
        self._sources = tuple(
            hub.subscribe(_TYPES[feed.type_name], feed.topic, partial(self._hear, place, feed))
            for place, feed in enumerate(found)
        )

    @property
    def sources(self) -> tuple[str, ...]:
        """Full names of the topics."""
        return self._sources

    @property
    def pending(self) -> int:
        """Number of messages that wait for others."""
        return self._assembler.pending

    def begin(self) -> None:
        """Forget what has come so far."""
        self._assembler = self._assembler_of(self._gap)
        self._readings = JointReadings(*self._joints)
        self._just_heard = False
        self._quiet = 0.0

    def retune(self, gap: float) -> None:
        """Take another `gap` [s] from now on."""
        self._gap = gap
        self._assembler.retune(gap)

    def flush(self, period: float = math.inf) -> None:
        """Release what waits once nothing has come for the window.

        To be called by a steady timer, every `period` [s]: then nothing waits for longer than the
        window and two periods, also when the stamps stand still.
        """
        if self._just_heard:
            self._just_heard, self._quiet = False, 0.0
            return
        self._quiet += period
        if self._quiet >= self._patience and self._assembler.pending:
            self._pass_on(self._assembler.flush(), "")

    def _hear(self, place: int, feed: Feed, message: Any) -> None:
        self._just_heard = True
        topic = self._sources[place]
        if feed.stamped:
            known = stamp_of(message)
            stamp_ns = nanoseconds(message.header.stamp) if known is None else known
        else:
            stamp_ns, known = self._hub.now_ns(), None  # tells nothing of the sender's clock
        if self._heard is not None:
            self._heard(topic, known)
        sample = feed.read(message, stamp_ns)
        if sample is None:
            return
        if isinstance(sample, Rejection):
            self._take(sample, topic, stamp_ns)
        else:
            self._pass_on(self._assembler.add(place, sample), topic)

    def _pass_on(self, ready: Iterable[Measurement | Dropped], topic: str) -> None:
        for item in ready:
            if isinstance(item, Dropped):
                self._take(Rejection.OUT_OF_ORDER, self._sources[item.source], item.stamp_ns)
                continue
            measured = self._readings.at_pulleys(item) if self._at_joints else item
            self._take(measured, topic, item.stamp_ns)
