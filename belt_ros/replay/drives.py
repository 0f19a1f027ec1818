"""All drives of one description, replayed from one bag."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from belt_ros.drive_inputs import InputSettings, load_inputs, refuse_confused
from belt_ros.parameter_table import SettingsError
from belt_ros.replay.errors import BagError
from belt_ros.replay.run import Progress, replay
from belt_ros.replay.summary import Summary
from belt_ros.settings import DriveSettings, load_settings, names_of_drives, read_parameters


class Described(NamedTuple):
    """One drive of a description. `key` names it there; "" if it is the only one."""

    key: str
    settings: DriveSettings
    inputs: InputSettings

    @property
    def prefix(self) -> str:
        """What its topics begin with."""
        return f"{self.key}/" if self.key else ""


class Outcome(NamedTuple):
    """What came of one drive in one bag: a summary and where its results are, or an error."""

    drive: str
    place: Path
    summary: Summary | None = None
    error: str = ""


def load_drives(config: str | Path) -> tuple[Described, ...]:
    """Read all drives of a description.

    Raises
    ------
    SettingsError
        If it cannot be used.
    """
    names = names_of_drives(read_parameters(config)) or ("",)
    drives = tuple(
        Described(name, load_settings(config, drive=name), load_inputs(config, name))
        for name in names
    )
    try:
        refuse_confused((drive.settings, drive.inputs.kind) for drive in drives)
    except SettingsError as error:
        raise SettingsError(f"{config}: {error}") from error
    return drives


def replay_drives(
    bag: str | Path,
    drives: Sequence[Described],
    out: str | Path,
    *,
    topic: str | None = None,
    replace: bool = False,
    smooth: bool = True,
    progress: Progress | None = None,
) -> Iterator[Outcome]:
    """Replay a bag for each drive; yield what came of it.

    Results are in `out` itself for a drive without a key, otherwise in a directory named by it. A
    drive that the bag does not hold, or that cannot be replayed, does not hinder the others.
    Arguments are those of `replay`.

    Raises
    ------
    ResultsError
        If results cannot be written.
    """
    for drive in drives:
        place = Path(out) / drive.key
        try:
            summary = replay(
                bag,
                drive.settings,
                place,
                inputs=drive.inputs,
                prefix=drive.prefix,
                topic=topic,
                replace=replace,
                smooth=smooth,
                progress=progress,
            )
        except BagError as error:
            yield Outcome(drive.settings.name, place, error=str(error))
        else:
            yield Outcome(drive.settings.name, place, summary)
