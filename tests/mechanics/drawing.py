"""How random numbers of mechanics are drawn, shared by all its tests."""

import functools
import math

from hypothesis import strategies as st


@functools.cache  # hypothesis looks through every strategy that it has not met before
def spread(low: float, high: float) -> st.SearchStrategy[float]:
    """Numbers of which the logarithm is spread evenly."""
    return st.floats(math.log(low), math.log(high)).map(math.exp)
