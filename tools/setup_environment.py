#!/usr/bin/env python3
"""Make `.venv`: ROS 2, belt_ros, its messages and its tools, ready without sourcing anything.

Four steps, each done again only when what it depends on has changed:

1. a virtual environment;
2. belt_ros in editable form, ROS 2 as Python wheels (not where a ROS 2 installation is sourced:
   that one is used), everything both need;
3. the messages in `msg_defs`, built by colcon and installed into the virtual environment;
4. the inner loops, compiled into numba's cache while the messages are built (`--leave-loops`: and
   beside what comes after, which does without).

`.venv` is thereby a complete ROS 2 prefix, and `ros_environment.py`, which every start of its
Python imports, sets the variables that sourcing would set. Needs only the standard library.
"""

from __future__ import annotations

import contextlib
import fcntl
import json
import os
import platform
import shutil
import signal
import sys
from pathlib import Path

from ros_environment import completed
from setup_machine import WHEELS, base_python, check_prerequisites, sourced_distribution
from setup_packages import install_packages, requirements
from setup_state import State, fingerprint
from setup_steps import (
    LOG,
    PATH_VARIABLES,
    ROOT,
    VENV,
    VENV_PYTHON,
    SetupError,
    Step,
    run_logged,
    run_quietly,
    venv_paths,
)

TOOLS = ROOT / "tools"
MESSAGES = ROOT / "msg_defs"
RECORD = VENV / "ros_environment.json"
PROGRAMS = ("belt_ros.cli.app", "belt_ros.node.main", "belt_ros.player.run", "belt_ros.rig.main")
ROS_VARIABLES = ("ROS_DISTRO", "ROS_VERSION", "ROS_PYTHON_VERSION")


def make_virtual_environment(ros: str) -> None:
    """Make an empty virtual environment that sees the sourced ROS 2, if there is one."""
    options = [] if ros == WHEELS else ["--system-site-packages"]
    run_logged("virtual environment", base_python(), "-m", "venv", *options, VENV)


def repair_wheels() -> None:
    """Put this machine's include directories where the wheels name those of their build machine."""
    paths = venv_paths()
    version = "{}.{}".format(*sys.version_info)
    built_in = "/opt/python/cp{0}{1}-cp{0}{1}".format(*sys.version_info)
    for file in (VENV / "share").glob("*/cmake/*generator_pyExport.cmake"):
        text = file.read_text()
        text = text.replace(f"{built_in}/include/python{version}", paths["include"])
        text = text.replace(f"{built_in}/lib/python{version}/site-packages", paths["purelib"])
        file.write_text(text)


def install_ros_environment(ros: str) -> None:
    """Record what sourcing sets, and have every start of the environment's Python set it."""
    site_packages = Path(venv_paths()["purelib"])
    recorded = {}
    if ros == WHEELS:
        recorded["LD_LIBRARY_PATH"] = [str(p) for p in sorted(site_packages.glob("ros_*.libs"))]
        # Our module does what the wheels' own start-up module would do after it.
        recorded["_ROS_WHEELS_BOOTSTRAP_COMPLETE"] = ["1"]
    else:
        for name in PATH_VARIABLES + ROS_VARIABLES:
            value = os.environ.get(name, "")
            own = str(VENV)
            recorded[name] = [p for p in value.split(os.pathsep) if p and not p.startswith(own)]
    for name in ("AMENT_PREFIX_PATH", "CMAKE_PREFIX_PATH"):
        recorded.setdefault(name, []).insert(0, str(VENV))
    recorded["LD_LIBRARY_PATH"].insert(0, str(VENV / "lib"))
    RECORD.write_text(json.dumps(recorded, indent=1) + "\n")
    shutil.copy(TOOLS / "ros_environment.py", site_packages / "belt_ros_environment.py")
    # Python reads these files in alphabetical order: before ros_wheels_bootstrapper.pth.
    (site_packages / "belt_ros_environment.pth").write_text("import belt_ros_environment\n")


def link_package() -> None:
    """Make belt_ros findable as a ROS 2 package: what colcon would install, as links."""
    links = {
        VENV / "share/ament_index/resource_index/packages/belt_ros": ROOT / "resource/belt_ros",
        VENV / "share/belt_ros/package.xml": ROOT / "package.xml",
        VENV / "share/belt_ros/config": ROOT / "config",
        VENV / "share/belt_ros/launch": ROOT / "launch_scripts",
    }
    for program in ("belt", "belt_node", "belt_rig"):
        links[VENV / "lib/belt_ros" / program] = VENV / "bin" / program
    for link, target in links.items():
        link.parent.mkdir(parents=True, exist_ok=True)
        with contextlib.suppress(FileNotFoundError):
            link.unlink()
        link.symlink_to(target)


def build_messages(ros: str) -> None:
    """Build belt_msgs from nothing (seconds), so that no removed message stays behind.

    For nodes in C++ only where a ROS 2 installation is sourced: wheels are for Python.
    """
    build = VENV / "build"
    for leftover in (build, VENV / "share/belt_msgs", Path(venv_paths()["purelib"]) / "belt_msgs"):
        shutil.rmtree(leftover, ignore_errors=True)
    run_logged(
        *("messages (belt_msgs)", VENV_PYTHON, "-m", "colcon", "--log-base", build / "log"),
        *("build", "--base-paths", MESSAGES, "--build-base", build),
        *("--merge-install", "--install-base", VENV, "--event-handlers", "console_direct+"),
        *("--cmake-args", "-DBUILD_TESTING=OFF", f"-DPython3_EXECUTABLE={VENV_PYTHON}"),
        f"-DBELT_MSGS_WITHOUT_CPP={'ON' if ros == WHEELS else 'OFF'}",
    )
    check = "import rclpy; from belt_msgs.msg import BeltState; BeltState.__import_type_support__()"
    outcome = run_quietly(VENV_PYTHON, "-c", check)
    if outcome.returncode:
        raise SetupError(f"{outcome.stderr}\nThe messages were built, but do not load. Log: {LOG}")
    # Compiles what they import; sources in the middle of an edit are no matter of set-up's.
    run_quietly(VENV_PYTHON, "-c", f"import {', '.join(PROGRAMS)}")


def compile_kernels() -> Step:
    """Begin to compile the inner loops."""
    log = VENV / "setup-kernels.log"
    return Step("inner loops", VENV_PYTHON, TOOLS / "compile_kernels.py", log=log)


class Kernels:
    """The inner loops, which one processor compiles while the other does what comes after."""

    def __init__(self, state: State, key: str, *, awaited: bool) -> None:
        self._state = state
        self._key = key
        self._awaited = awaited
        self._step: Step | None = None

    def finish(self) -> None:
        """Wait for them, if they are being compiled and awaited."""
        step, self._step = self._step, None
        if step is None or not (self._awaited or step.ended):
            return  # it goes on; the next set-up waits for its lock, and finds all compiled
        try:
            step.wait()
        except SetupError as error:
            # Sources in the middle of an edit must not keep anyone from checking and testing them.
            print(error, "They will be compiled when they are first used.", sep="\n")
        else:
            self._state.finish("kernels", self._key)

    def __enter__(self) -> Kernels:
        if self._state.done.get("kernels") != self._key:
            self._state.begin("kernels")
            self._step = compile_kernels()
        return self

    def __exit__(self, *_: object) -> None:
        if self._step is not None:  # what came after them failed
            self._step.stop()


def set_up(*, loops_awaited: bool) -> None:
    """Bring the virtual environment up to date."""
    state = State()
    sourced = sourced_distribution()
    ros = sourced or state.done.get("ros", WHEELS)
    if not sourced and ros != WHEELS and RECORD.exists():
        # An environment made with a sourced ROS 2 goes on working where it is not sourced.
        os.environ.update(completed(dict(os.environ), json.loads(RECORD.read_text())))
    named = requirements(WHEELS)
    hook = TOOLS / "ros_environment.py"
    sources = sorted(file for file in MESSAGES.rglob("*") if file.is_file())
    modules = sorted((ROOT / "belt_ros").rglob("*.py"))
    loops = [file for file in modules if b"compiled" in file.read_bytes()]
    keys = {
        "ros": ros,
        "venv": f"{base_python()} {platform.python_version()} in {ROOT}",
        "packages": fingerprint(ROOT / "setup.py", ROOT / "setup.cfg", hook, *named),
        "messages": fingerprint(*named, *sources),
        "kernels": fingerprint(TOOLS / "compile_kernels.py", *loops),
    }
    if state.done == keys and VENV_PYTHON.exists():
        print("The environment is up to date: .venv")
        return

    check_prerequisites(ros)
    source = "Python wheels" if ros == WHEELS else f"the sourced {ros}"
    print(f"Setting up .venv with Python {platform.python_version()}, ROS 2 from {source}:")
    same = all(state.done.get(name) == keys[name] for name in ("ros", "venv"))
    # Where pip was interrupted, nobody knows what it left: start again from nothing.
    if not (same and "packages" in state.done and VENV_PYTHON.exists()):
        shutil.rmtree(VENV, ignore_errors=True)
        VENV.mkdir()
        state.done = {}
        make_virtual_environment(ros)
        state.finish("ros", keys["ros"])
        state.finish("venv", keys["venv"])
    if state.done.get("packages") != keys["packages"]:
        install(state, keys["packages"], ros)
    with Kernels(state, keys["kernels"], awaited=loops_awaited) as kernels:
        if state.done.get("messages") != keys["messages"]:
            state.begin("messages")
            build_messages(ros)
            state.finish("messages", keys["messages"])
        kernels.finish()


def install(state: State, key: str, ros: str) -> None:
    """Install all packages; let the environment find them."""
    state.begin("packages")
    try:
        install_packages(ros)
    except SetupError:
        # pip that gives up (no network, say) has changed nothing: no reason to start again.
        state.finish("packages", "failed")
        raise
    if ros == WHEELS:
        repair_wheels()
    install_ros_environment(ros)
    link_package()
    state.finish("packages", key)


def main() -> int:
    """Set up, one at a time, and say in words what went wrong."""
    # Also where it is terminated, the running step is ended before this script.
    signal.signal(signal.SIGTERM, signal.default_int_handler)
    checkout = os.open(str(ROOT), os.O_RDONLY)
    fcntl.fcntl(checkout, fcntl.F_SETFD, 0)  # inherited by the steps
    try:
        try:
            fcntl.flock(checkout, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            print("Waiting for the set-up that is running here ...", flush=True)
            fcntl.flock(checkout, fcntl.LOCK_EX)
        set_up(loops_awaited="--leave-loops" not in sys.argv[1:])
    except SetupError as error:
        print(error, file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("\nInterrupted. Run make setup again to go on.", file=sys.stderr)
        return 130
    return 0


if __name__ == "__main__":
    sys.exit(main())
