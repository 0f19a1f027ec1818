"""A monitor that says again what another has said: replaying with it costs all but the filter."""

import dataclasses
from collections.abc import Iterable

from belt_ros.estimation import BeltMonitor, Measurement, MonitorOutput
from belt_ros.settings import DriveSettings


class _Playback(BeltMonitor):
    """Says what `monitor` made of the same measurements."""

    def __init__(self, monitor: BeltMonitor, outputs: Iterable[MonitorOutput]) -> None:
        self.__dict__.update(monitor.__dict__)
        self._outputs = iter(outputs)

    def step(self, measurement: Measurement, *, timely: bool = True) -> MonitorOutput:
        """Return what was made of the measurement that came in its place."""
        del measurement, timely
        return next(self._outputs)


def played_back(
    settings: DriveSettings, monitor: BeltMonitor, outputs: Iterable[MonitorOutput]
) -> DriveSettings:
    """Return settings of the same drive whose monitor says what `monitor` said."""

    class Played(DriveSettings):
        def monitor(self) -> BeltMonitor:
            return _Playback(monitor, outputs)

    fields = dataclasses.fields(settings)
    return Played(**{field.name: getattr(settings, field.name) for field in fields})
