"""Random places for pulleys, shared by the tests of layouts and of loops."""

import math

from hypothesis import strategies as st

from belt_ros.mechanics.drive import DriveError
from belt_ros.mechanics.layout import Disc, Layout, Side, trace


@st.composite
def ring_discs(draw: st.DrawFn, least: int = 2, most: int = 6) -> list[Disc]:
    """Discs round the origin in the order of their angle; not all need be on the hull."""
    count = draw(st.integers(least, most))
    step = 2.0 * math.pi / count
    discs = []
    for i in range(count):
        angle = step * (i + draw(st.floats(-0.2, 0.2)))
        away = draw(st.floats(0.6, 1.4))
        radius = draw(st.floats(0.05, 0.55 * math.sin(min(step, math.pi) * 0.3)))
        discs.append(Disc(away * math.cos(angle), away * math.sin(angle), radius))
    return discs


@st.composite
def serpentines(draw: st.DrawFn, least: int = 3, most: int = 6) -> Layout:
    """A layout of `least` to `most` discs, some of them outside and pressed into a span."""
    inside = draw(st.integers(2, max(2, most - 1)))
    outside = draw(st.integers(max(0, least - inside), max(0, min(inside, most - inside))))
    ring = draw(ring_discs(inside, inside).filter(_runs))
    layout = trace(ring)
    pressed = draw(st.permutations(range(inside)))[:outside]
    discs = []
    for i, disc in enumerate(ring):
        discs.append(disc)
        if i in pressed:
            x, y = 0.5 * (layout.begin[i] + layout.end[i])
            right_x, right_y = layout.direction[i, 1], -layout.direction[i, 0]
            radius = draw(st.floats(0.04, 0.15)) * layout.span_length[i]
            off = radius * draw(st.floats(0.3, 0.95))
            discs.append(Disc(x + off * right_x, y + off * right_y, radius, Side.CLOCKWISE))
    if not _runs(discs):
        return layout if least <= inside else draw(serpentines(least, most))
    return trace(discs)


def _runs(discs: list[Disc]) -> bool:
    try:
        trace(discs)
    except DriveError:
        return False
    return True
