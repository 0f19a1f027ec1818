"""Arguments of the programs that are ROS 2 nodes: they take none but ROS's own, and help."""

import sys
from collections.abc import Sequence

from rclpy.utilities import remove_ros_args

_HELP = frozenset({"-h", "--help"})


def ends_at_once(program: str, args: Sequence[str] | None, usage: str) -> int | None:
    """Print `usage` if it is asked for, or what is wrong with the arguments.

    Parameters
    ----------
    program : str
        Its name.
    args : sequence of str, optional
        Without the program's name; those of the process if not given.
    usage : str

    Returns
    -------
    int or None
        The exit code with which to end; None to go on.
    """
    given = sys.argv[1:] if args is None else list(args)
    try:
        unknown = remove_ros_args([program, *given])[1:]
    except RuntimeError as error:  # a parameter file that is not there, a misspelt argument
        sys.stderr.write(f"{program}: {error}\n")
        return 1
    if _HELP & set(unknown):
        sys.stdout.write(f"{usage}\n")
        return 0
    if unknown:
        sys.stderr.write(
            f"{program}: {unknown[0]} is unknown; what is for a ROS 2 node follows --ros-args\n"
        )
        return 2
    return None
