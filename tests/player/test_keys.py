"""Keys are taken from a terminal that listens to the program, and from no other."""

import contextlib
import os
import pty
import subprocess
import sys

import pytest

KEYS = """
from belt_ros.player.keys import Keys
with Keys() as keys:
    print("there", keys.there, "space", keys.space())
"""
# A shell with job control puts a program into a process group of its own, and only one of them
# into the foreground.
SHELL = f"""
import fcntl, os, signal, subprocess, sys, termios
fcntl.ioctl(0, termios.TIOCSCTTY, 0)
signal.signal(signal.SIGTTOU, signal.SIG_IGN)
program = subprocess.Popen([sys.executable, "-c", {KEYS!r}], preexec_fn=os.setpgrp)
if sys.argv[1] == "foreground":
    os.tcsetpgrp(0, program.pid)
try:
    sys.exit(program.wait(timeout=20.0))
except subprocess.TimeoutExpired:
    program.kill()
    sys.exit(3)
"""


def said_in_terminal(place: str) -> tuple[int, str]:
    """Run the program in a terminal of its own; return its exit code and what it said."""
    terminal, other_end = pty.openpty()
    shell = subprocess.Popen(
        [sys.executable, "-c", SHELL, place],
        stdin=other_end,
        stdout=other_end,
        stderr=other_end,
        start_new_session=True,
    )
    os.close(other_end)
    said = b""
    with contextlib.suppress(OSError):  # the other end is closed
        while some := os.read(terminal, 1000):
            said += some
    os.close(terminal)
    return shell.wait(timeout=30.0), said.decode()


@pytest.mark.parametrize(("place", "there"), [("foreground", True), ("background", False)])
def test_a_program_in_the_background_leaves_the_terminal_alone(place: str, there: bool) -> None:
    code, said = said_in_terminal(place)
    assert code == 0
    assert f"there {there} space False" in said
