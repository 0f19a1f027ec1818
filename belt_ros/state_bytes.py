"""A drive's states as the bytes of their messages, on DDS and in bags. No ROS.

Those who write messages field by field take their time. Of a state all numbers keep their places,
for its strings are the same as long as the drive is: so one `struct` packs it, much faster.
"""

import sys
from collections.abc import Mapping
from operator import attrgetter
from struct import Struct

from belt_ros.estimation import BeltEstimate
from belt_ros.message_fields import STATE_SOURCES

PLAIN_CDR = b"\x00\x01\x00\x00" if sys.byteorder == "little" else b"\x00\x00\x00\x00"
_STRINGS = ("header", "drive_name")
_CODES = {"uint8": "B", "uint32": "I", "uint64": "Q", "double": "d", "float64": "d"}
_FRAME = b"\x00"  # no frame: an empty string, ended by zero
_SECOND_NS = 1_000_000_000


class StateBytes:
    """Writes the estimates of one drive as belt_msgs/BeltState.

    Parameters
    ----------
    drive_name : str
    kinds : mapping
        Names and types of the message's fields, e.g. ``float64`` or ``uint64[8]``, in their order.
    """

    def __init__(self, drive_name: str, kinds: Mapping[str, str]) -> None:
        numbers = {name: kind for name, kind in kinds.items() if name not in _STRINGS}
        text = drive_name.encode() + b"\x00"
        self._strings = (len(_FRAME), _FRAME, len(text), text)
        # CDR aligns as C does.
        self._struct = Struct(f"@iI I1s I{len(text)}s" + "".join(map(_code, numbers.values())))
        self._values = attrgetter(*(STATE_SOURCES[name] for name in numbers))

    def write(self, estimate: BeltEstimate) -> bytes:
        """Return an estimate as a message, with its stamp."""
        stamp = divmod(estimate.stamp_ns, _SECOND_NS)
        *numbers, rejections = self._values(estimate)
        return PLAIN_CDR + self._struct.pack(*stamp, *self._strings, *numbers, *rejections)


def _code(kind: str) -> str:
    """Return the format of a number, or of an array such as ``uint64[8]``."""
    name, _, count = kind.rstrip("]").partition("[")
    return count + _CODES[name]
