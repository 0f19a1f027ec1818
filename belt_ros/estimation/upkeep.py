"""What keeps a filter's members few, and narrow enough that the model is straight within each."""

from belt_ros.estimation.gaussian_sum import Component, narrowed
from belt_ros.estimation.modes import few, parted
from belt_ros.estimation.reduction import reduced
from belt_ros.estimation.state import Index

SPLIT_AXES = (Index.LOG_TENSION, Index.LOG_STIFFNESS)
MERGE_AXES = (*SPLIT_AXES, Index.LOG_FRICTION)
# A load at one level leaves tension and mu open along a curve. A wide member sees it bent, follows
# its tangent, and gains certainty along it that no sensor gave.
_FRICTION_WIDTH = 0.1  # of a member in ln mu, once that has become uncertain ...
_CHANGING_WIDER = 2.0  # ... and so many times that while it is blurred by a change of traction ...
_MOST_BY_FRICTION = 40  # ... while there are no more members than this


def tended(components: list[Component]) -> list[Component]:
    """Return members of the same sum: those alike merged, those that have become wide split.

    Members of negligible weight are dropped; of an unlikely mode few remain.
    """
    likely, unlikely = parted(reduced(components, MERGE_AXES))
    return few(unlikely, MERGE_AXES) + narrowed(
        likely, (Index.LOG_FRICTION,), (_FRICTION_WIDTH,), _MOST_BY_FRICTION, _CHANGING_WIDER
    )
