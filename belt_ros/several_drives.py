"""One parameter file for several drives: what all share, and what is one drive's own.

``drives`` names them. A value ``<drive>.<parameter>`` is that drive's own; a value without a
drive's name is the default of all.
"""

import re
from collections.abc import Mapping

_NAME = re.compile(r"[a-zA-Z][a-zA-Z0-9_]{0,63}")
_MOST_DRIVES = 500


class DriveNamesError(ValueError):
    """Names that cannot be used; the message says which and why."""


def drive_names(drives: object, reserved: frozenset[str]) -> tuple[str, ...]:
    """Return the names in the parameter ``drives``, none if there is but one nameless drive.

    Parameters
    ----------
    drives : object
        As it was given: a sequence of text, or None.
    reserved : frozenset of str
        Names that parameters begin with, so that no drive can have them.

    Raises
    ------
    DriveNamesError
        If they are no names, not unique, too many, or reserved.
    """
    if drives is None or isinstance(drives, str) or not hasattr(drives, "__iter__"):
        if not drives:
            return ()
        raise DriveNamesError(f"drives is {drives!r}; it must be a list of names")
    names = tuple(drives)
    if len(names) > _MOST_DRIVES:
        raise DriveNamesError(f"drives has {len(names)} names; at most {_MOST_DRIVES} can be used")
    for name in names:
        if not isinstance(name, str) or not _NAME.fullmatch(name):
            raise DriveNamesError(
                f"drives holds {name!r}; a name begins with a letter and has letters, digits and _"
            )
        if name in reserved:
            raise DriveNamesError(f"drives holds {name!r}, which is the name of a parameter")
    for name in names:
        if names.count(name) > 1:
            raise DriveNamesError(f"drives holds {name!r} more than once")
    return names


def values_of_drive(
    values: Mapping[str, object], name: str, names: tuple[str, ...]
) -> dict[str, object]:
    """Return one drive's values, flat: the shared ones, and its own in preference to them.

    Unless it has a ``name`` of its own, the drive is named as in `names`.
    """
    prefixes = tuple(f"{other}." for other in names)
    shared = {key: value for key, value in values.items() if not key.startswith(prefixes)}
    prefix = f"{name}."
    own = {
        key.removeprefix(prefix): value for key, value in values.items() if key.startswith(prefix)
    }
    shared.pop("drives", None)
    return shared | {"name": name} | own
