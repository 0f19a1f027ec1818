"""The message types of belt_msgs for reading and writing bags without ROS."""

import os
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from rosbags.typesys.store import Typestore

_PACKAGE = Path(__file__).resolve().parent
_KNOWN_BY = "BeltState.msg"


def _candidates() -> Iterator[Path]:
    """Where the message texts may lie: installed with this package, in a checkout, in ROS."""
    yield _PACKAGE / "message_texts"
    yield _PACKAGE.parent / "msg_defs" / "msg"
    for prefix in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep):
        if prefix:
            yield Path(prefix) / "share" / "belt_msgs" / "msg"


def message_texts() -> dict[str, str]:
    """Return the definitions of belt_msgs by type name, e.g. ``belt_msgs/msg/BeltState``.

    Raises
    ------
    FileNotFoundError
        If neither this package, nor the checkout, nor a sourced ROS workspace holds them.
    """
    places = list(_candidates())
    for place in places:
        if (place / _KNOWN_BY).is_file():
            return {
                f"belt_msgs/msg/{path.stem}": path.read_text(encoding="utf-8")
                for path in sorted(place.glob("*.msg"))
            }
    looked = ", ".join(str(place) for place in places)
    raise FileNotFoundError(
        f"no definition of belt_msgs/BeltState in {looked}; install belt_ros anew, "
        "or source a workspace that holds belt_msgs"
    )


@cache
def belt_typestore() -> Typestore:
    """Return the message types of ROS 2 Jazzy and belt_msgs. One store for the process.

    Raises
    ------
    FileNotFoundError
        As `message_texts`.
    """
    store = get_typestore(Stores.ROS2_JAZZY)
    for name, text in message_texts().items():
        store.register(get_types_from_msg(text, name))
    return store
