"""Joint states, decoded without looking at their strings each time.

From one message to the next, names and lengths hardly ever change. Where they are those of the
message before, all numbers have the same places, and one `struct` reads them. All else is left to
rosbags.
"""

import struct
from collections.abc import Sequence
from operator import itemgetter
from typing import Any, NamedTuple, Protocol

_HEAD = b"\x00\x01\x00\x00"  # plain CDR, little endian
_STAMP = 8  # [bytes]
_MOST_NUMBERS = 1000  # per array, for which a layout is worth having
_MOST_LAYOUTS = 16


class Reader(Protocol):
    """Decodes messages of one type."""

    def read(self, data: bytes) -> Any:
        """Return a message; None if the bytes are none."""


class _Stamp(NamedTuple):
    sec: int
    nanosec: int


class _Header(NamedTuple):
    stamp: _Stamp


class _JointState(NamedTuple):
    """As much of a sensor_msgs/JointState as anyone asks for."""

    header: _Header
    name: Sequence[str]
    position: tuple[float, ...]
    velocity: tuple[float, ...]
    effort: tuple[float, ...]


class JointStateReader:
    """Decodes joint states as sensor_msgs defines them.

    Parameters
    ----------
    whole : Reader
        Decodes a message whose layout is not known.
    """

    def __init__(self, whole: Reader) -> None:
        self._whole = whole
        self._layouts: dict[int, _Layout] = {}  # by length: arms may share a topic with the drive

    def read(self, data: bytes) -> Any:
        """Return a message; None if the bytes are none."""
        layout = self._layouts.get(len(data))
        message = None if layout is None else layout.read(data)
        if message is not None:
            return message
        message = self._whole.read(data)
        layout = None if message is None else _layout_of(data, message)
        if layout is not None:
            if len(self._layouts) >= _MOST_LAYOUTS:
                self._layouts.clear()
            self._layouts[len(data)] = layout
        return message


class _Layout:
    """Where the numbers are in joint states of the same names and lengths."""

    def __init__(self, data: bytes, names: Sequence[str], strings: int, counts: list[int]) -> None:
        self._names = names
        self._struct = struct.Struct(_format(len(data), strings, counts))
        first, second, third = counts
        self._fixed = itemgetter(0, 3, 4, 5 + first, 6 + first + second)
        self._same = self._fixed(self._struct.unpack(data))
        self._position = slice(5, 5 + first)
        self._velocity = slice(6 + first, 6 + first + second)
        self._effort = slice(7 + first + second, 7 + first + second + third)

    def read(self, data: bytes) -> _JointState | None:
        """Return a message; None if it is laid out otherwise."""
        if len(data) != self._struct.size:
            return None
        values = self._struct.unpack(data)
        if self._fixed(values) != self._same:
            return None
        return _JointState(
            _Header(_Stamp(values[1], values[2])),
            self._names,
            values[self._position],
            values[self._velocity],
            values[self._effort],
        )


def _layout_of(data: bytes, message: Any) -> _Layout | None:
    """Return the layout of a message that has been decoded; None if it is not worth having."""
    counts = [len(message.position), len(message.velocity), len(message.effort)]
    if data[: len(_HEAD)] != _HEAD or max(counts) > _MOST_NUMBERS:
        return None
    end = _after(_STAMP, message.header.frame_id)
    end = _aligned(end, 4) + 4  # how many names
    for name in message.name:
        end = _after(_aligned(end, 4), name)
    return _Layout(data, message.name, _aligned(end, 4) - _STAMP, counts)


def _format(size: int, strings: int, counts: Sequence[int]) -> str:
    """Head, stamp, all strings as one, and three arrays with their lengths; `size` in all."""
    text, end = f"<4siI{strings}s", _STAMP + strings
    for count in counts:
        start = _aligned(end + 4, 8) if count else end + 4
        text += f"I{start - end - 4}x{count}d"
        end = start + 8 * count
    return f"{text}{size - len(_HEAD) - end}x"


def _after(start: int, text: str) -> int:
    """Return where a string that starts somewhere ends: its length, the text, a zero."""
    return start + 4 + len(text.encode()) + 1


def _aligned(position: int, size: int) -> int:
    return -(-position // size) * size
