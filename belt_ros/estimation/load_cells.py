"""Hub loads and span tension, which depend on the state by the mechanics, taken into the filter."""

import numpy as np

from belt_ros.estimation.population import Population
from belt_ros.estimation.sensing import LOADS, NO_LOADS, Sensed, Sensing

_WILD = 25.0  # squared innovation of a load, for every member, that is not believed ...
_REFUSED_AT_MOST = 3  # ... in a row


class LoadCells:
    """Take readings of load cells in, but for a few wild ones."""

    def __init__(self, sensing: Sensing) -> None:
        self._sensing = sensing
        self._refused = np.zeros(LOADS, dtype=np.int64)  # in a row, by the load

    def take_in(self, population: Population, sensed: Sensed) -> None:
        """Take in the loads that were sensed, if any were."""
        if sensed.loads is NO_LOADS:
            return
        for load in np.flatnonzero(~np.isnan(sensed.loads)).tolist():
            before = population.members()
            innovation, variance = population.observe_load(
                load, float(sensed.loads[load]), float(sensed.load_variances[load])
            )
            if np.min(innovation**2 / variance) > _WILD and self._refused[load] < _REFUSED_AT_MOST:
                population.go_back(before)
                self._refused[load] += 1
                self._sensing.ask_for_load(load)
                continue
            self._refused[load] = 0
            population.weigh(innovation**2 / float(population.weights @ variance))
        population.summarise()
