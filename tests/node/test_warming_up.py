"""What the node compiles before it listens."""

import subprocess
import sys

from node_harness import PAPER_DRIVE, ROOT

# A drive from the first message on: loads that change, positions that come and go, load cells, a
# gap, standstill, reversal, maintenance, memory, and one that is known well from the start.
LIFE = """
import dataclasses, math, sys
from pathlib import Path
from numba.core.registry import CPUDispatcher
from belt_ros.estimation import Maintenance, MaintenanceKind, Measurement
from belt_ros.node.warming_up import warm_up
from belt_ros.settings import load_settings

def compiled():
    return {
        (each.py_func.__module__, each.py_func.__name__, str(signature))
        for name, module in list(sys.modules.items()) if name.startswith("belt_ros")
        for each in vars(module).values() if isinstance(each, CPUDispatcher)
        for signature in each.signatures
    }

settings = load_settings(Path(sys.argv[1]))
odd = {"limits.greatest_speed": 0.5, "limits.greatest_gap": 0.01, "limits.pool_period": 1.0}
warm_up(load_settings(Path(sys.argv[1]), odd))
before = compiled()
narrow = dataclasses.replace(settings.prior, tension_stddev=1.0, friction_stiffness_decades=0.01)
for told in (settings, dataclasses.replace(settings, prior=narrow)):
    monitor = told.monitor()
    angle, now = 0.0, 0
    for sample in range(1500):
        speed = 0.0 if 540 < sample < 600 else -8.0 if sample > 1380 else 12.0
        torque = 3.0 * math.sin(sample / 40.0) if sample < 900 else 2.0
        angle, now = angle + 0.01 * speed, now + (10_000_000 if sample != 1200 else 3_000_000_000)
        position = angle % (2.0 * math.pi) if 120 < sample < 720 else math.nan
        hub, span = (900.0, math.nan) if sample % 2 else (math.nan, 400.0)
        cells = {"driver_hub_load": hub, "span_tension": span} if 240 < sample < 480 else {}
        creep = 1.0 if sample < 360 else 0.97
        monitor.step(
            Measurement(
                now, speed, creep * speed, torque, -torque, position, position, **cells
            )
        )
    monitor.maintain(Maintenance(MaintenanceKind.TENSION_MEASURED, 300.0, 10.0))
    learned = monitor.learned(0.0)
    again = told.monitor()
    if learned is not None:
        again.restore(learned, 1000.0)
    again.gross_slip_probability_at(again.load_at_probability(0.1))
    again.step(Measurement(1, 1.0, 1.0, 0.0, 0.0))
for each in sorted(compiled() - before):
    print(*each)
"""


def test_nothing_is_compiled_while_a_drive_runs() -> None:
    """Compiling takes seconds, for which nothing would be estimated, nor any alarm raised."""
    run = subprocess.run(
        [sys.executable, "-c", LIFE, str(PAPER_DRIVE)],
        capture_output=True,
        text=True,
        check=True,
        cwd=ROOT,
    )
    assert run.stdout == ""
