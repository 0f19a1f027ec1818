"""One pass through a bag: measurements in; estimates, alarms, diagnostics and a summary out."""

from collections.abc import Callable, Iterator
from contextlib import nullcontext
from pathlib import Path
from typing import NamedTuple

from belt_ros.drive_inputs import InputSettings
from belt_ros.estimation import Rejection
from belt_ros.estimation.hindsight import HindsightReader
from belt_ros.estimation.smoother import Smoother
from belt_ros.replay.drive_bag import DriveBag
from belt_ros.replay.errors import BagError, DamagedInsideError
from belt_ros.replay.forward import Forward
from belt_ros.replay.results import ResultWriter
from belt_ros.replay.smoothed_summary import SmoothedSummary, SmoothedTally
from belt_ros.replay.smoothing import SmoothedRow, no_room_for_hindsight, smoothed_rows
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
    inputs: InputSettings | None = None,
    prefix: str = "",
    topic: str | None = None,
    replace: bool = False,
    smooth: bool = True,
    progress: Progress | None = None,
) -> Summary:
    """Estimate the state of a drive from a bag of its measurements.

    The monitor is the one the live node runs, and it is given the same stamps in the order of the
    bag's log time, which is the order in which the node received them. Smoothing changes nothing
    in its estimates. A bag that turns out to be damaged inside is read again, chunk by chunk.

    Parameters
    ----------
    bag : path
        A rosbag2 directory (MCAP or sqlite3), or a bare .mcap or .db3 file.
    settings : DriveSettings
    out : path
        Directory for ``estimates/`` (a rosbag2 bag of belt_msgs/BeltState, SlipAlarm and
        diagnostics), ``estimates.parquet``, ``smoothed.parquet`` and ``summary.json``. It
        appears complete or not at all.
    inputs : InputSettings, optional
        How its measurements arrive; by default as joint states.
    prefix : str
        What the drive's topics begin with, where there are several drives: ``drive_name/``.
    topic : str, optional
        Topic of the joint states, or namespace of other topics; found by itself where there is only
        one choice.
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
    task = _Task(Path(bag), settings, Path(out), inputs, prefix, topic, replace, smooth)
    try:
        return _pass(task, progress, salvage=False)
    except DamagedInsideError:
        return _pass(task, progress, salvage=True)


class _Task(NamedTuple):
    """The arguments of `replay`."""

    bag: Path
    settings: DriveSettings
    out: Path
    inputs: InputSettings | None
    prefix: str
    topic: str | None
    replace: bool
    smooth: bool


def _pass(task: _Task, progress: Progress | None, *, salvage: bool) -> Summary:
    settings = task.settings
    monitor = settings.monitor()
    tally = Tally(settings)
    with (
        DriveBag(
            task.bag,
            settings,
            task.inputs,
            prefix=task.prefix,
            topic=task.topic,
            salvage=salvage,
        ) as source,
        ResultWriter(task.out, settings.name, replace=task.replace, prefix=task.prefix) as results,
        monitor.smoother() if task.smooth else nullcontext() as smoother,
    ):
        forward = Forward(source, monitor, tally, results)
        for sample in source.samples():
            forward.take(sample)
            _tell(progress, tally.messages, source.count)
        forward.end(source.end_ns)
        if tally.accepted == 0:
            raise BagError(_nothing_usable(source, settings, tally))
        smoothed = None
        if smoother is not None:
            try:
                monitor.finish()
            except OSError as error:
                raise no_room_for_hindsight(error) from error
            total = tally.messages + smoother.beliefs
            smoothed = _smooth(
                smoother,
                settings,
                results,
                lambda count: _tell(progress, tally.messages + count, total),
            )
        summary = tally.summary(task.bag.name, ", ".join(source.topics), source.note, smoothed)
        results.commit(summary.as_json())
    return summary


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


def _nothing_usable(source: DriveBag, settings: DriveSettings, tally: Tally) -> str:
    topics = ", ".join(source.topics)
    asked = settings.driver.name, settings.driven.name
    joints = (
        f" The configuration asks for the joints {' and '.join(asked)} with their velocities; the "
        f"messages carry {', '.join(source.joints_seen)}. Set driver.joint and driven.joint."
    )
    if tally.messages == 0 and source.joints_seen:
        return f"{source.path}: no message on {topics} is of this drive.{joints}"
    if tally.messages == 0:
        return f"{source.path}: {topics} holds no messages. Record while the drive runs."
    reasons = ", ".join(
        f"{count} {reason.name.lower()}" for reason, count in tally.rejected.items() if count
    )
    text = (
        f"{source.path}: none of the {tally.messages} messages on {topics} can be used ({reasons})."
    )
    if tally.rejected[Rejection.INCOMPLETE] and source.joints_seen:
        there = set(asked) <= set(source.joints_seen)
        text += " Velocities are missing or NaN: check what records them." if there else joints
    return text
