"""One pass through a bag: joint states in, estimates, alarms and a summary out."""

from collections.abc import Callable, Iterator
from contextlib import nullcontext
from pathlib import Path

from belt_ros.estimation import BeltMonitor, MonitorOutput, Rejection
from belt_ros.estimation.hindsight import HindsightReader
from belt_ros.estimation.smoother import Smoother
from belt_ros.replay.errors import BagError
from belt_ros.replay.reader import JointStateBag
from belt_ros.replay.results import ResultWriter
from belt_ros.replay.smoothed_summary import SmoothedSummary, SmoothedTally
from belt_ros.replay.smoothing import SmoothedRow, room_for_hindsight, smoothed_rows
from belt_ros.replay.summary import Summary, Tally
from belt_ros.settings import DriveSettings

Progress = Callable[[int, int], None]
_PROGRESS_EVERY = 100  # messages
_SECONDS = 1e-9


def replay(
    bag: str | Path,
    settings: DriveSettings,
    out: str | Path,
    *,
    topic: str | None = None,
    replace: bool = False,
    smooth: bool = True,
    progress: Progress | None = None,
) -> Summary:
    """Estimate the state of a drive from a bag of its joint states.

    The monitor is the one the live node runs, and it is given the same stamps in the order of the
    bag's log time, which is the order in which the node received them. Smoothing changes nothing
    in its estimates.

    Parameters
    ----------
    bag : path
        A rosbag2 directory (MCAP or sqlite3), or a bare .mcap or .db3 file.
    settings : DriveSettings
    out : path
        Directory for ``estimates/`` (a rosbag2 bag of belt_msgs/BeltState and SlipAlarm),
        ``estimates.parquet``, ``smoothed.parquet`` and ``summary.json``. It appears complete or
        not at all.
    topic : str, optional
        Topic of the joint states; found by itself where there is only one choice.
    replace : bool
        Whether earlier results at `out` may be replaced.
    smooth : bool
        Whether to go through the bag backwards too, for what is known with hindsight.
    progress : callable, optional
        Given the number of messages and smoothed moments done and their total, now and then.

    Raises
    ------
    BagError
        If the bag cannot be read, or not one of its messages can be used.
    ResultsError
        If `out` cannot be written, or holds anything else, or smoothing finds no room.
    """
    path = Path(bag)
    monitor = settings.monitor()
    tally = Tally(settings)
    with (
        JointStateBag(path, settings.driver, settings.driven, topic) as source,
        ResultWriter(Path(out), settings.name, replace=replace) as results,
        monitor.smoother() if smooth else nullcontext() as smoother,
    ):
        for log_ns, output in _outputs(source, monitor):
            tally.add(output, output.alarm)
            if output.fresh and output.estimate is not None:
                results.write_state(log_ns, output.estimate)
            if output.alarm is not None:
                results.write_alarm(log_ns, output.alarm)
            _tell(progress, tally.messages, source.count)
        if tally.accepted == 0:
            raise BagError(_nothing_usable(source, settings, tally))
        smoothed = None
        if smoother is not None:
            with room_for_hindsight():
                monitor.finish()
            total = tally.messages + smoother.beliefs
            smoothed = _smooth(
                smoother,
                settings,
                results,
                lambda count: _tell(progress, tally.messages + count, total),
            )
        summary = tally.summary(path.name, source.topic, source.note, smoothed)
        results.commit(summary.as_json())
    return summary


def _outputs(source: JointStateBag, monitor: BeltMonitor) -> Iterator[tuple[int, MonitorOutput]]:
    """Yield log time [ns] of every message, and what the monitor makes of it."""
    for log_ns, content in source.samples():
        if isinstance(content, Rejection):
            yield log_ns, monitor.reject(content)
            continue
        with room_for_hindsight():
            output = monitor.step(content)
        yield log_ns, output


def _tell(progress: Progress | None, done: int, total: int) -> None:
    if progress is not None and done % _PROGRESS_EVERY == 0:
        progress(done, total)


def _smooth(
    smoother: Smoother,
    settings: DriveSettings,
    results: ResultWriter,
    told: Callable[[int], None],
) -> SmoothedSummary:
    """Write what is known with hindsight, and sum it up."""
    reader = HindsightReader(settings.drive, settings.limits.standstill_speed)
    tally = SmoothedTally(smoother.block_ns * _SECONDS)

    def counted() -> Iterator[SmoothedRow]:
        for row in smoothed_rows(smoother, reader, told):
            tally.add(row)
            yield row

    results.write_smoothed(counted())
    return tally.summary()


def _nothing_usable(source: JointStateBag, settings: DriveSettings, tally: Tally) -> str:
    if tally.messages == 0:
        return f"{source.path}: {source.topic} holds no messages. Record while the drive runs."
    reasons = ", ".join(
        f"{count} {reason.name.lower()}" for reason, count in tally.rejected.items() if count
    )
    text = (
        f"{source.path}: none of the {tally.messages} messages on {source.topic} can be used "
        f"({reasons})."
    )
    if tally.rejected[Rejection.INCOMPLETE]:
        text += (
            f" The configuration asks for the joints {settings.driver.name} and "
            f"{settings.driven.name} with their velocities; the messages carry "
            f"{', '.join(source.joints_seen) or 'none'}. Set driver.joint and driven.joint."
        )
    return text
