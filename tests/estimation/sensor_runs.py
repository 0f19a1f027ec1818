"""Runs through the monitor with some of the sensors, shared by the tests of each kind of sensor."""

import dataclasses
import math
from collections.abc import Callable

from runs import Run

from belt_ros.estimation import Measurement
from belt_ros.rig import measured
from belt_ros.rig.scenario import scenario_from_mapping
from belt_ros.settings import DriveSettings

LOADS = ("driver_hub_load", "driven_hub_load", "span_tension")
POSITIONS = {"driver_position": math.nan, "driven_position": math.nan}
SAMPLE_RATE = 50.0
Alter = Callable[[Measurement], Measurement]


def only(*names: str, gain: float = 1.0) -> Alter:
    """Keep some of the load sensors, with an error of their gain."""

    def alter(measurement: Measurement) -> Measurement:
        loads = {n: gain * getattr(measurement, n) if n in names else math.nan for n in LOADS}
        return dataclasses.replace(measurement, **loads)

    return alter


def play(settings: DriveSettings, alter: Alter, **scenario: object) -> Run:
    named = {name.replace("__", "."): value for name, value in scenario.items()}
    named = {"sample_rate": SAMPLE_RATE, "condition.friction_stiffness": 6e6} | named
    monitor = settings.monitor()
    pairs = [
        (alter(measurement), truth)
        for measurement, truth in measured(
            settings, scenario_from_mapping(named, settings), loads=True
        )
    ]
    outputs = [monitor.step(measurement) for measurement, _ in pairs]
    return Run(settings, [m for m, _ in pairs], [truth for _, truth in pairs], outputs)
