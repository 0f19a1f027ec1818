"""Through a bag in the order of its log: measurements in; states, alarms and diagnostics out."""

from belt_ros.estimation import BeltMonitor, MonitorOutput, Rejection
from belt_ros.replay.diagnostics import DiagnosticsLog
from belt_ros.replay.drive_bag import DriveBag, Sample
from belt_ros.replay.results import ResultWriter
from belt_ros.replay.silence import Silence, Silent
from belt_ros.replay.smoothing import no_room_for_hindsight
from belt_ros.replay.summary import Tally


class Forward:
    """Gives measurements to the monitor one by one, and time as it passes between them.

    Parameters
    ----------
    source : DriveBag
    monitor : BeltMonitor
    tally : Tally
    results : ResultWriter
    """

    def __init__(
        self, source: DriveBag, monitor: BeltMonitor, tally: Tally, results: ResultWriter
    ) -> None:
        self._monitor = monitor
        self._tally = tally
        self._results = results
        self._silence = Silence(monitor)
        self._heard_ns = 0
        self._diagnostics = DiagnosticsLog(
            monitor.name,
            ", ".join(source.topics),
            monitor.limits.greatest_gap,
            lambda: monitor.health,
        )

    def take(self, sample: Sample) -> None:
        """Take in a sample, after what falls due before it."""
        self._heard_ns = sample.log_ns
        self._tell(self._silence.before(sample.log_ns))
        self._report(sample.log_ns)
        output = self._output(sample)
        self._silence.take(sample, output.rejection)
        self._tally.add(output, output.alarm)
        fresh = output.estimate if output.fresh else None
        if fresh is not None:
            self._results.write_state(sample.log_ns, fresh)
        if output.alarm is not None:
            self._results.write_alarm(sample.log_ns, output.alarm)
        row = self._diagnostics.add(sample, output.rejection, fresh, output.alarm)
        if row is not None:
            self._results.write_diagnostics(sample.log_ns, (row,))

    def end(self, log_ns: int) -> None:
        """Take in that nothing more comes until the bag ends at `log_ns`."""
        if log_ns > self._heard_ns:
            self._tell(self._silence.before(log_ns))
        if self._silence.too_long:
            self._tally.outlast(self._silence.stamp_at(max(log_ns, self._heard_ns)))
        last = self._diagnostics.end()
        if last is not None:
            self._results.write_diagnostics(*last)

    def _report(self, log_ns: int) -> None:
        for report in self._diagnostics.before(log_ns):
            self._results.write_diagnostics(*report)

    def _tell(self, silent: Silent | None) -> None:
        """Write that silence has changed the alarms, after what falls due before that."""
        if silent is None:
            return
        self._report(silent.log_ns)
        self._tally.add_alarm(silent.alarm)
        self._results.write_alarm(*silent)
        row = self._diagnostics.add_alarm(*silent)
        if row is not None:
            self._results.write_diagnostics(silent.log_ns, (row,))

    def _output(self, sample: Sample) -> MonitorOutput:
        if isinstance(sample.content, Rejection):
            return self._monitor.reject(sample.content)
        try:
            return self._monitor.step(sample.content)
        except OSError as error:
            raise no_room_for_hindsight(error) from error
