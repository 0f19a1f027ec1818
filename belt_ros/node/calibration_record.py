"""What is told of one drive's calibrations: that one goes on, and what came of the last."""

from diagnostic_msgs.msg import DiagnosticStatus

from belt_ros.estimation.calibration import CalibrationResult
from belt_ros.node.diagnostics import calibration_status

_LOST = CalibrationResult("ratio not calibrated: the estimate was started anew")


class CalibrationRecord:
    """Knows of a calibration by what the estimator says, and by how often that was reset."""

    def __init__(self) -> None:
        self._began: int | None = None  # the number of resets when the one that goes on began
        self._last: CalibrationResult | None = None

    def begin(self, resets: int) -> None:
        """Take note that a calibration begins, after so many resets."""
        self._began = resets

    def ended(self, result: CalibrationResult | None, resets: int) -> CalibrationResult | None:
        """Return the result of a calibration that has ended with an estimate, after `resets`.

        `result` is what the estimator says of it, None if nothing.
        """
        if self._began is None:
            return None
        told = _LOST if self._lost(resets) else result
        if told is not None:
            self._began, self._last = None, told
        return told

    def forget(self) -> None:
        """Take note that the ratio is back at its prior, whatever was calibrated."""
        if self._last is not None and self._last.ratio_bias is not None:
            self._last = _LOST

    def _lost(self, resets: int) -> bool:
        """Whether estimation has started anew under the calibration that was going on."""
        return self._began not in {None, resets}

    def status(self, node_name: str, drive_name: str, resets: int) -> DiagnosticStatus | None:
        """Return the diagnostics after so many resets; None if there never was a calibration."""
        if self._began is None and self._last is None:
            return None
        # What has ended is told at once, though the drive may not speak for long.
        result = self._last if self._began is None else None
        return calibration_status(node_name, drive_name, _LOST if self._lost(resets) else result)
