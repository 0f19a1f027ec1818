"""A drive's bag read as a list, and what is to be found in one of joint states."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from bags import Sample as Recorded

from belt_ros.drive_inputs import InputSettings
from belt_ros.estimation import Measurement
from belt_ros.replay.drive_bag import DriveBag, Sample
from belt_ros.settings import DriveSettings


def read(
    bag: Path, settings: DriveSettings, inputs: InputSettings | None = None, **options: Any
) -> list[Sample]:
    with DriveBag(bag, settings, inputs, **options) as source:
        return list(source.samples())


def measured(samples: Iterable[Sample]) -> list[Measurement]:
    return [sample.content for sample in samples if isinstance(sample.content, Measurement)]


def expected(recorded: Iterable[Recorded]) -> list[Sample]:
    """Joints of gear ratio 1 without drag, of which no position was recorded."""
    return [
        Sample(
            each.log_ns,
            Measurement(each.stamp_ns, *each.velocity, *each.effort),
            (each.log_ns - each.stamp_ns) * 1e-9,
        )
        for each in recorded
    ]
