"""The YAML of a drive from its entries: nested, aligned, and plain about what was guessed."""

from collections.abc import Sequence

from belt_ros.mechanics import DriveError
from belt_ros.parameter_table import SettingsError
from belt_ros.rating import rate
from belt_ros.settings import settings_from_parameters, without_nodes_own
from belt_ros.starter.answers import Answers
from belt_ros.starter.entries import Entry, entries
from belt_ros.yaml_text import yaml_number, yaml_string

_COMMENTS_AT = 43
_INDENT = "  "
_TOLD, _GUESSED = 7, 4  # digits


def drive_yaml(answers: Answers) -> str:
    """Return the YAML of a drive, which the node, replay and rig take as it is.

    Parameters
    ----------
    answers : Answers
        From `answers_from`.

    Raises
    ------
    SettingsError
        If the answers describe no drive that can be, or one that cannot run.
    """
    try:
        lines = entries(answers)
        _check(lines)
    except DriveError as error:
        raise SettingsError(str(error)) from error
    return "\n".join([*_head(answers), *_nested(lines)]) + "\n"


def _check(lines: Sequence[Entry]) -> None:
    """Raise unless `belt check` would be content."""
    values: dict[str, object] = {line.name: line.value for line in lines}
    rate(settings_from_parameters(without_nodes_own(values)))


def _head(answers: Answers) -> list[str]:
    head = [
        f"# {answers.name}: made by `belt init`. What is guessed is to be measured or looked up.",
        "# `belt check` says what the mechanics makes of it; `belt identify` finds friction and",
        "# tension in a bag with loads; `belt parameters` lists every parameter.",
    ]
    if not answers.driven_torque:
        head.append(
            "# The driven torque is not measured: its effort must be NaN or left out, not 0."
        )
    if answers.crossed:
        head.append("# A crossed belt: the driven pulley's own sense of rotation is positive.")
    return head


def _nested(lines: Sequence[Entry]) -> list[str]:
    """Return the entries as a ROS 2 parameter file, those of one group together."""
    out = ["/**:", f"{_INDENT}ros__parameters:"]
    groups: dict[str, list[Entry]] = {}
    for line in lines:
        group, point, _ = line.name.rpartition(".")
        groups.setdefault(group if point else f"={line.name}", []).append(line)
    for group, members in groups.items():
        if group.startswith("="):
            out.append(_line(2, members[0].name, members[0]))
            continue
        out.append(f"{2 * _INDENT}{group}:")
        out += [_line(3, one.name.rpartition(".")[2], one) for one in members]
    return out


def _line(depth: int, name: str, entry: Entry) -> str:
    value = entry.value
    digits = _GUESSED if entry.guessed else _TOLD
    shown = yaml_string(value) if isinstance(value, str) else yaml_number(value, digits)
    text = f"{depth * _INDENT}{name}: {shown}"
    remark = "; ".join(part for part in (entry.comment, "guessed" if entry.guessed else "") if part)
    return f"{text:<{_COMMENTS_AT - 2}}  # {remark}" if remark else text
