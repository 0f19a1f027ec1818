"""The demonstration's picture."""

from typing import Any

import pytest
from belt_msgs.msg import BeltState, SlipAlarm
from builtin_interfaces.msg import Time
from matplotlib.figure import Figure

from belt_ros.demo.plot import _alarms


def at(kind: type, seconds: int, **fields: object) -> Any:
    message = kind(**fields)
    message.header.stamp = Time(sec=seconds)
    return message


@pytest.mark.parametrize(
    ("raised", "over", "shown"), [(2, 5, (2.0, 5.0)), (2, 14, (2.0, 10.0)), (12, 14, None)]
)
def test_alarms_are_shaded_as_long_as_there_are_states(
    raised: int, over: int, shown: tuple[float, float] | None
) -> None:
    """The rig falls silent at the end, which is no alarm of the drive that is shown."""
    axis = Figure().add_subplot()
    states = [at(BeltState, second) for second in range(11)]
    alarms = [
        at(SlipAlarm, raised, active=True, severity=SlipAlarm.SEVERITY_ALARM),
        at(SlipAlarm, over, active=False),
    ]
    _alarms(axis, 0, states, alarms)
    spans = [(patch.get_x(), patch.get_x() + patch.get_width()) for patch in axis.patches]
    assert spans == ([] if shown is None else [pytest.approx(shown)])
