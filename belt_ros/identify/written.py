"""The drive's YAML with what was identified: everything else of it stays, comments too."""

import tempfile
from datetime import datetime, timezone
from pathlib import Path
from typing import NamedTuple

from belt_ros.appearing import appearing
from belt_ros.identify.result import QUANTITIES, Identified, Interval
from belt_ros.parameter_table import SettingsError
from belt_ros.settings import (
    DriveSettings,
    load_settings,
    names_belt_node,
    names_of_drives,
    read_parameters,
)
from belt_ros.yaml_text import MappingNode, ScalarNode, yaml_node, yaml_number


class _Edit(NamedTuple):
    """Text that takes the place of that between two positions."""

    begin: int
    end: int
    text: str


def with_identified(
    path: str | Path, identified: Identified, settings: DriveSettings, drive: str = ""
) -> str:
    """Return the text of a drive's YAML with its priors replaced by what a bag says.

    Only what the data tell is replaced. The ratio bias goes into ``driven.radius``, since R1/R2 is
    what it is the error of, and a prior of it has no other place.

    Parameters
    ----------
    path : path
        The YAML that `settings` come from.
    identified : Identified
    settings : DriveSettings
    drive : str
        Which drive, where the file describes several.

    Raises
    ------
    SettingsError
        If the file cannot be read, or is written so that it cannot be edited.
    """
    path = Path(path)
    before = read_parameters(path)
    text = path.read_text(encoding="utf-8")
    names = names_of_drives(before)
    own = drive or (names[0] if len(names) == 1 else "")
    values: dict[str, float] = {
        f"prior.{name}": value for name, value in identified.prior(settings.prior).items()
    }
    if identified.ratio_bias.told:
        radius = settings.drive.driven.radius
        values["driven.radius"] = radius * (1.0 + identified.ratio_bias.median)
    prefix = f"{own}." if own else ""
    texts = {f"{prefix}{name}": yaml_number(value, 7) for name, value in values.items()}
    edited = _remarks(identified) + _edited(text, texts)
    _check(edited, {**before, **{name: float(value) for name, value in texts.items()}}, path)
    return edited


def write_identified(
    path: str | Path,
    out: str | Path,
    identified: Identified,
    settings: DriveSettings,
    drive: str = "",
) -> None:
    """Write the YAML of `with_identified` to `out`, once it has been read back.

    Raises
    ------
    SettingsError
        As `with_identified`, or if what was written is not accepted.
    OSError
        If `out` cannot be written.
    """
    text = with_identified(path, identified, settings, drive)
    with appearing(Path(out)) as part:
        part.write_text(text, encoding="utf-8")
        load_settings(part, drive=drive)


def _remarks(identified: Identified) -> str:
    """Comment on where the values come from."""
    when = datetime.fromtimestamp(identified.begin_ns * 1e-9, tz=timezone.utc)
    loads = identified.goodness.loads
    lines = [
        f"Identified by `belt identify` from {identified.bag}, recorded {when:%Y-%m-%d %H:%M} UTC:",
        f"{loads} loads, up to {identified.greatest_torque:.3g} N m. With 95 % intervals:",
    ]
    lines += [f"  {_described(name, getattr(identified, name))}" for name in QUANTITIES]
    capacity = identified.capacity
    lines.append(
        f"  capacity {capacity.value:.4g} N m, {capacity.low:.4g} to {capacity.high:.4g} N m"
    )
    lines += [f"Note: {warning}." for warning in identified.warnings]
    return "".join(f"# {line}\n" for line in lines)


def _described(name: str, interval: Interval) -> str:
    unit = "" if interval.unit == "-" else f" {interval.unit}"
    text = f"{name} {interval.value:.4g}{unit}, {interval.low:.4g} to {interval.high:.4g}{unit}"
    if name == "ratio_bias" and interval.told:
        return f"{text}, now in driven.radius"
    return text if interval.told else f"{text}: not told by the data, left as it was"


def _edited(text: str, values: dict[str, str]) -> str:
    """Return YAML text with values replaced or added, by flat names."""
    for name, value in values.items():
        edit = _edit(text, _parameters(text), name.split("."), value)
        text = text[: edit.begin] + edit.text + text[edit.end :]
    return text


def _parameters(text: str) -> MappingNode:
    """Return the node of the mapping with the parameters, see `settings`."""
    root = yaml_node(text)
    if not isinstance(root, MappingNode):
        raise SettingsError("a drive description is a YAML mapping; see config/ for examples")
    sections = [
        (str(name.value), inner)
        for name, content in root.value
        if isinstance(content, MappingNode)
        for key, inner in content.value
        if key.value == "ros__parameters" and isinstance(inner, MappingNode)
    ]
    own = [inner for name, inner in sections if names_belt_node(name)]
    # The last one has the last word.
    return (own or [inner for _, inner in sections] or [root])[-1]


def _edit(text: str, node: MappingNode, keys: list[str], value: str) -> _Edit:
    """Return the edit that gives the entry `keys` under `node` a value."""
    for key, content in node.value:
        parts = str(key.value).split(".")
        if keys[: len(parts)] != parts:
            continue
        rest = keys[len(parts) :]
        if not rest and isinstance(content, ScalarNode):
            return _Edit(content.start_mark.index, content.end_mark.index, value)
        if rest and isinstance(content, MappingNode) and content.value:
            return _edit(text, content, rest, value)
    name = ".".join(keys)
    if node.flow_style:
        first = node.value[0][0].start_mark.index
        return _Edit(first, first, f"{name}: {value}, ")
    return _new_line(text, node, name, value)


def _new_line(text: str, node: MappingNode, name: str, value: str) -> _Edit:
    """Give the entry a line of its own before the first one of a block mapping."""
    key = node.value[0][0].start_mark
    begin = key.index - key.column
    indent = text[begin : key.index]
    return _Edit(begin, begin, f"{indent}{name}: {value}\n")


def _check(edited: str, wanted: dict[str, object], path: Path) -> None:
    """Raise unless the edited text says what is wanted, and nothing else."""
    with tempfile.TemporaryDirectory() as place:
        copy = Path(place) / path.name
        copy.write_text(edited, encoding="utf-8")
        if read_parameters(copy) != wanted:
            raise SettingsError(
                f"{path} cannot be edited as it is written; put the values of the "
                "report into it by hand"
            )
