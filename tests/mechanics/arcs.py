"""Random arcs by their dimensionless groups, shared by the tests of arcs."""

import math
from dataclasses import dataclass

import numpy as np
from drawing import spread
from hypothesis import settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from belt_ros.mechanics import ArcSolution, solve_arc

Floats = NDArray[np.float64]
REPEATABLE = settings(derandomize=True, deadline=None, max_examples=200)


@dataclass(frozen=True)
class Arc:
    """An arc by its dimensionless groups, its size and its load."""

    role: int
    growth: float  # a = mu / (R lambda)
    friction: float
    wrap: float
    load: float  # share of mu phi
    radius: float = 0.1
    axial: float = 1e5
    strain: float = 5e-3  # at the inlet
    lift: float = 0.0  # share of the inlet tension that inertia takes up
    speed: float = 10.0

    @property
    def b(self) -> float:
        return self.friction / self.growth

    @property
    def lengths(self) -> float:
        return self.b * self.wrap

    @property
    def inlet_tension(self) -> float:
        return self.axial * self.strain

    @property
    def lifted(self) -> float:
        return self.lift * self.inlet_tension

    @property
    def net(self) -> float:
        return self.axial - self.lifted

    @property
    def traction(self) -> float:
        return self.load * self.friction * self.wrap

    @property
    def outlet_tension(self) -> float:
        return self.outlet_at(math.expm1(self.role * self.traction))

    def outlet_at(self, rise: float) -> float:
        """Outlet tension where W has risen by `rise` along the arc."""
        w_in = self.inlet_tension - self.lifted
        return self.inlet_tension + rise * w_in * self.axial / self.net

    @property
    def rounding(self) -> float:
        """Error of the traction from rounding of the tensions it is computed from."""
        least = min(1.0, math.exp(self.role * self.traction)) * (1.0 - self.lift)
        return 1e-15 * max(1.0, self.outlet_tension / self.inlet_tension * least) / least

    def solve(
        self, inlet: float | Floats | None = None, outlet: float | Floats | None = None
    ) -> ArcSolution:
        return solve_arc(
            self.role,
            self.radius,
            self.wrap,
            self.friction,
            self.net * (self.b / self.radius) ** 2,
            self.axial,
            self.lifted / self.speed**2,
            self.speed,
            self.inlet_tension if inlet is None else inlet,
            self.outlet_tension if outlet is None else outlet,
        )

    def gradient(self, solution: ArcSolution) -> float:
        """D = K |u'(0)| / w_in."""
        w_in = self.inlet_tension - self.lifted
        return abs(float(solution.inlet_strain_gradient)) * self.net / w_in


EITHER = st.sampled_from([1, -1])
GROWTHS = spread(2e-2, 30.0) | st.floats(0.999, 1.001)
LOADS = st.floats(1e-3, 0.999)


def arcs(
    role: st.SearchStrategy[int] = EITHER,
    growth: st.SearchStrategy[float] = GROWTHS,
    load: st.SearchStrategy[float] = LOADS,
) -> st.SearchStrategy[Arc]:
    return st.builds(
        Arc,
        role=role,
        growth=growth,
        friction=st.floats(0.05, 2.0),
        wrap=st.floats(0.1, 6.2),
        load=load,
        radius=spread(5e-3, 1.0),
        axial=spread(1e3, 1e7),
        strain=spread(1e-5, 0.1),
        lift=st.floats(0.0, 0.8),
    )
