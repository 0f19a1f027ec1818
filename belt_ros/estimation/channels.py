"""Which of the measured quantities used to come and no longer do."""

import math

from belt_ros.estimation.measurement import Measurement, Sensor

_SECONDS = 1e-9
_KNOWN = 10  # samples from which on a quantity counts as one that comes
_EACH = (0, 0, *(_KNOWN,) * (len(Sensor) - 2))  # without its speed, nothing is known of a pulley
_USUAL = 3.0  # times the usual absence of one that comes rarely
_AT_FIRST = 3.0  # gaps that a speed may be away before it is known how often it comes


class Channels:
    """Keeps when each quantity was last there.

    A quantity that comes rarely, such as a load at 1 Hz among speeds at 100 Hz, may stay away for
    as long as it usually does, three times over, and the greatest gap beyond that. Both speeds have
    to come from the beginning.
    """

    def __init__(self) -> None:
        self._missing = [True] * len(Sensor)
        self._steps = 0  # since presence has last changed
        self._seen = [0] * len(Sensor)
        self._last_ns = [0] * len(Sensor)
        self._usual = [0.0] * len(Sensor)  # absence [s]
        self._stamp_ns = 0
        self._any_absent = False

    def take(self, measurement: Measurement, longest: float) -> None:
        """Note what is there; `longest`: time between measurements beyond which it is a gap [s]."""
        m = measurement
        readings = (*m.speeds, *m.torques, *m.positions, *m.loads)
        missing = list(map(math.isnan, readings))
        if not 0.0 <= (m.stamp_ns - self._stamp_ns) * _SECONDS <= longest:
            self._forgive(m.stamp_ns)
        if missing != self._missing:
            self._change(missing, m.stamp_ns)
        self._steps += 1
        self._stamp_ns = m.stamp_ns

    def _forgive(self, stamp_ns: int) -> None:
        """Let a gap, in which nothing came, not count for any."""
        self._last_ns = [stamp_ns] * len(Sensor)

    def _change(self, missing: list[bool], stamp_ns: int) -> None:
        for place, (was_missing, is_missing) in enumerate(zip(self._missing, missing, strict=True)):
            if not was_missing:
                self._seen[place] += self._steps
                if is_missing:
                    self._last_ns[place] = self._stamp_ns
            elif not is_missing and self._seen[place]:
                away = max((stamp_ns - self._last_ns[place]) * _SECONDS, 0.0)
                self._usual[place] += 0.3 * (away - self._usual[place])
        self._missing, self._steps = missing, 0
        self._any_absent = any(
            seen >= known and is_missing
            for seen, known, is_missing in zip(self._seen, _EACH, missing, strict=True)
        )

    def absent(self, longest: float) -> tuple[Sensor, ...]:
        """Return what has been away for too long; `longest` as in `take`."""
        if not self._any_absent:
            return ()
        return tuple(
            sensor
            for sensor in Sensor
            if self._seen[sensor] >= _EACH[sensor]
            and self._missing[sensor]
            and (self._stamp_ns - self._last_ns[sensor]) * _SECONDS
            > longest * self._patience(sensor) + _USUAL * self._usual[sensor]
        )

    def _patience(self, sensor: Sensor) -> float:
        return 1.0 if self._seen[sensor] >= _KNOWN else _AT_FIRST
