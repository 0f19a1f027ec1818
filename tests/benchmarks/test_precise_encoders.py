"""Drives whose encoders are told to be as good as they are, through the steps of a load."""

import numpy as np
import pytest

from benchmarks.estimation import life
from benchmarks.estimation.cells import cell_settings
from benchmarks.estimation.life_scripts import SCRIPTS

STEP = 5e-5  # [rad], that of the rig's encoders
LOAD_STEPS = next(script for script in SCRIPTS if script.name == "load steps")


@pytest.mark.parametrize("seed", [1, 4, 5])
def test_what_rims_run_within_a_step_is_not_taken_for_slip(seed: int) -> None:
    settings = cell_settings(LOAD_STEPS.cell(seed), noise__position_absolute=STEP)
    monitor = settings.monitor()
    begin, end = LOAD_STEPS.span
    off = []
    for measurement, truth in life.life_samples(LOAD_STEPS, settings, seed):
        monitor.step(measurement)
        estimate = monitor.estimate
        if estimate is not None and begin < measurement.stamp_ns * 1e-9 < end:
            off.append((estimate.slip.value - truth.slip) / estimate.slip.stddev)
    assert np.sqrt(np.mean(np.square(off))) < 1.5
    assert sum(monitor.health.rejections) == 0
