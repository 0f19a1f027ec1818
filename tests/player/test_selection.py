"""Topics of a bag get the names that they are asked to have, if these are names."""

import pytest

from belt_ros.player.selection import remappings
from belt_ros.replay.errors import BagError


def test_names_may_be_relative() -> None:
    given = ["/joint_states:=/cell_3/joint_states", "clock:=old_clock"]
    assert remappings(given) == {"/joint_states": "/cell_3/joint_states", "/clock": "/old_clock"}


@pytest.mark.parametrize(
    "text", ["/a", "/a:=", ":=/b", "/a:=/b c", "/a:=/9b", "/a:=/b//c", "/a:=~/b"]
)
def test_what_is_no_topic_is_refused(text: str) -> None:
    with pytest.raises(BagError, match="is no renaming of a topic; write /old:=/new"):
        remappings([text])
