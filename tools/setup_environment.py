#!/usr/bin/env python3
"""Make `.venv`: ROS 2, belt_ros, its messages and its tools, ready without sourcing anything.

Four steps, each done again only when what it depends on has changed:

1. a virtual environment;
2. belt_ros in editable form, ROS 2 as Python wheels (not where a ROS 2 installation is sourced:
   that one is used), everything both need;
3. the messages in `msg_defs`, built by colcon and installed into the virtual environment;
4. the inner loops, compiled into numba's cache as soon as belt_ros is there, beside the rest.

`.venv` is thereby a complete ROS 2 prefix, and `ros_environment.py`, which every start of its
Python imports, sets the variables that sourcing would set. Needs only the standard library.
"""

from __future__ import annotations

import contextlib
import fcntl
import hashlib
import importlib.util
import json
import os
import platform
import shutil
import signal
import subprocess
import sys
import sysconfig
import time
from pathlib import Path

from ros_environment import completed

ROOT = Path(__file__).resolve().parent.parent
TOOLS = ROOT / "tools"
MESSAGES = ROOT / "msg_defs"
VENV = ROOT / ".venv"
VENV_PYTHON = VENV / "bin" / "python"
LOG = VENV / "setup.log"
STATE = VENV / "setup.json"
RECORD = VENV / "ros_environment.json"

OLDEST_PYTHON = (3, 10)
NEWEST_PYTHON_OF_WHEELS = (3, 14)
WHEELS = "wheels"
PATH_VARIABLES = ("AMENT_PREFIX_PATH", "CMAKE_PREFIX_PATH", "LD_LIBRARY_PATH", "PYTHONPATH")
ROS_VARIABLES = ("ROS_DISTRO", "ROS_VERSION", "ROS_PYTHON_VERSION")


class SetupError(Exception):
    """What went wrong, in words for the user."""


# --- What is here already ----------------------------------------------------------------------


def base_python() -> str:
    """Return the interpreter behind an active virtual environment or a pyenv shim."""
    name = "python{}.{}".format(*sys.version_info)
    behind = Path(sys.base_prefix) / "bin" / name
    return str(behind) if behind.exists() else sys.executable


def sourced_distribution() -> str | None:
    """Return the name of the ROS 2 distribution that is sourced, if it is and works."""
    if not os.environ.get("AMENT_PREFIX_PATH"):
        return None
    distribution = os.environ.get("ROS_DISTRO")
    if distribution and run_quietly(base_python(), "-c", "import rclpy").returncode == 0:
        return distribution
    return None


def unsuitable_machine(ros: str) -> str | None:
    """Return what no package can mend: the wrong Python, system or processor."""
    python = sys.version_info[:2]
    here = f"{sys.executable} is {platform.python_version()}"
    if python < OLDEST_PYTHON:
        return "Python >= {}.{}; {} (choose with PYTHON=...)".format(*OLDEST_PYTHON, here)
    if ros != WHEELS:
        return None
    system = f"{platform.system()} {platform.machine()}"
    if system != "Linux x86_64":
        return f"ROS 2, sourced: its Python wheels are for Linux x86_64, not {system}"
    if python > NEWEST_PYTHON_OF_WHEELS:
        newest = "{}.{}".format(*NEWEST_PYTHON_OF_WHEELS)
        return f"Python <= {newest} for the ROS 2 wheels; {here} (choose with PYTHON=...)"
    return None


def missing_packages() -> dict[str, str]:
    """Return what is missing in words, each with the system package that brings it."""
    version = "{}.{}".format(*sys.version_info)
    # Debian's packages serve Debian's Python; another one is to be completed by its own means.
    package = f"python{version}" if sys.base_prefix == "/usr" else "python3"
    missing = {}
    if not importlib.util.find_spec("venv") or not importlib.util.find_spec("ensurepip"):
        missing[f"the venv module of Python {version}"] = f"{package}-venv"
    if not (Path(sysconfig.get_paths()["include"]) / "Python.h").exists():
        missing[f"the C headers of Python {version} (Python.h)"] = f"{package}-dev"
    if not shutil.which(os.environ.get("CXX") or "g++"):
        missing["a C++ compiler (g++)"] = "g++"
    return missing


def check_prerequisites(ros: str) -> None:
    """Raise SetupError naming what is missing, and how to install it."""
    unsuitable = unsuitable_machine(ros)
    if unsuitable:
        raise SetupError(f"Cannot set up belt_ros here. It needs {unsuitable}.")
    missing = missing_packages()
    if missing:
        names = "\n".join(f"  - {thing}" for thing in missing)
        install = f"sudo apt install {' '.join(missing.values())}"
        raise SetupError(f"Cannot set up belt_ros yet. Missing:\n{names}\nInstall:\n  {install}")


# --- The four steps ----------------------------------------------------------------------------


def make_virtual_environment(ros: str) -> None:
    """Make an empty virtual environment that sees the sourced ROS 2, if there is one."""
    options = [] if ros == WHEELS else ["--system-site-packages"]
    run_logged("virtual environment", base_python(), "-m", "venv", *options, VENV)


def pip_install(ros: str) -> list[str | Path]:
    """Return the command that installs, with what it may not change where ROS 2 is sourced."""
    command: list[str | Path]
    command = [VENV_PYTHON, "-m", "pip", "install", "--disable-pip-version-check", "--no-input"]
    if ros != WHEELS:
        # The messages of the installation were compiled for its numpy, and run with no other.
        constraints = VENV / "constraints.txt"
        numpy = run_quietly(VENV_PYTHON, "-c", "import numpy; print(numpy.__version__)")
        constraints.write_text(f"numpy=={numpy.stdout.strip()}\n" if numpy.returncode == 0 else "")
        command += ["-c", constraints]
    return command


def install_package(ros: str) -> None:
    """Install belt_ros with what it computes with, and what builds it."""
    pip = pip_install(ros)
    run_logged("build tools", *pip, "-r", TOOLS / "requirements-build.txt")
    # With the setuptools just installed.
    run_logged("belt_ros", *pip, "--no-build-isolation", "-e", ".")


def install_ros_and_tools(ros: str) -> None:
    """Install ROS 2 wheels and what tests and checks need, and let the environment find them."""
    requirements: list[str | Path]
    requirements = ["-r", TOOLS / "requirements-ros.txt"] if ros == WHEELS else []
    name = "ROS 2, tests and checks" if ros == WHEELS else f"tests and checks beside ROS 2 {ros}"
    run_logged(name, *pip_install(ros), *requirements, "--no-build-isolation", "-e", ".[dev]")
    if ros == WHEELS:
        repair_wheels()
    install_ros_environment(ros)
    link_package()


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


def build_messages() -> None:
    """Build belt_msgs from nothing (seconds), so that no removed message stays behind."""
    build = VENV / "build"
    for leftover in (build, VENV / "share/belt_msgs", Path(venv_paths()["purelib"]) / "belt_msgs"):
        shutil.rmtree(leftover, ignore_errors=True)
    run_logged(
        *("messages (belt_msgs)", VENV_PYTHON, "-m", "colcon", "--log-base", build / "log"),
        *("build", "--base-paths", MESSAGES, "--build-base", build),
        *("--merge-install", "--install-base", VENV, "--event-handlers", "console_direct+"),
        *("--cmake-args", "-DBUILD_TESTING=OFF", f"-DPython3_EXECUTABLE={VENV_PYTHON}"),
    )
    check = "import rclpy; from belt_msgs.msg import BeltState; BeltState.__import_type_support__()"
    outcome = run_quietly(VENV_PYTHON, "-c", check)
    if outcome.returncode:
        raise SetupError(f"{outcome.stderr}\nThe messages were built, but do not load. Log: {LOG}")


def compile_kernels() -> Step:
    """Begin to compile the inner loops."""
    log = VENV / "setup-kernels.log"
    return Step("inner loops", VENV_PYTHON, TOOLS / "compile_kernels.py", log=log)


# --- How a step is run -------------------------------------------------------------------------


def venv_paths() -> dict[str, str]:
    """Return where the virtual environment keeps headers and modules."""
    scheme = "venv" if "venv" in sysconfig.get_scheme_names() else "posix_prefix"
    modules = sysconfig.get_path("purelib", scheme, {"base": str(VENV), "platbase": str(VENV)})
    return {"include": sysconfig.get_paths()["include"], "purelib": modules}


def child_environment() -> dict[str, str]:
    """Return the caller's environment without traces of another virtual environment or colcon."""
    environment = dict(os.environ)
    if environment.pop("_ROS_WHEELS_BOOTSTRAP_COMPLETE", None):
        for name in PATH_VARIABLES:
            environment.pop(name, None)
    for name in list(environment):
        if name.startswith(("COLCON_", "_BELT_ROS_")) or name in ("VIRTUAL_ENV", "PYTHONHOME"):
            del environment[name]
    environment["PATH"] = f"{VENV / 'bin'}{os.pathsep}{environment.get('PATH', os.defpath)}"
    return environment


def run_quietly(*command: str | Path) -> subprocess.CompletedProcess[str]:
    """Run a command for its answer."""
    arguments = [str(part) for part in command]
    environment = child_environment()
    return subprocess.run(arguments, env=environment, capture_output=True, text=True, check=False)


class Step:
    """A step that has begun, with its output in a log."""

    def __init__(self, name: str, *command: str | Path, log: Path = LOG) -> None:
        self._name = name
        self._log = log
        self._began = time.monotonic()
        arguments = [str(part) for part in command]
        with log.open("a") as output:
            output.write(f"\n$ {' '.join(arguments)}\n")
            output.flush()
            # A step that outlives a killed set-up keeps the lock that it inherits.
            self._process = subprocess.Popen(
                arguments,
                cwd=ROOT,
                env=child_environment(),
                stdout=output,
                stderr=subprocess.STDOUT,
                close_fds=False,
            )

    def wait(self) -> None:
        """Show the step's name and how long it takes; raise SetupError where it fails."""
        moving = sys.stdout.isatty()
        print(f"  {self._name} ...", end="", flush=True)
        try:
            while self._process.poll() is None:
                with contextlib.suppress(subprocess.TimeoutExpired):
                    self._process.wait(timeout=1.0)
                if moving:
                    print(f"\r  {self._name} ... {self._seconds()} s", end="", flush=True)
        except BaseException:
            self.stop()
            raise
        if self._process.returncode:
            print(" failed")
            last = self._log.read_text(errors="replace").splitlines()[-12:]
            advice = f"Step '{self._name}' failed. Full log: {self._log}"
            raise SetupError("\n".join([*last, "", advice]))
        print(f"\r  {self._name} ..." if moving else "", f"{self._seconds()} s")

    def stop(self) -> None:
        """End the step, done or not."""
        self._process.terminate()
        self._process.wait()

    def _seconds(self) -> int:
        return round(time.monotonic() - self._began)


def run_logged(name: str, *command: str | Path) -> None:
    """Run one step with its output in the log; show its name and how long it takes."""
    Step(name, *command).wait()


def fingerprint(*files: Path) -> str:
    """Return a digest of the files' names and contents."""
    digest = hashlib.sha256()
    for file in files:
        name = file.relative_to(ROOT).as_posix()
        digest.update(b"%s\0%s\0" % (name.encode(), file.read_bytes()))
    return digest.hexdigest()


class State:
    """The steps that are done, and for what; kept in the virtual environment."""

    def __init__(self) -> None:
        try:
            self.done: dict[str, str] = json.loads(STATE.read_text())
        except (OSError, ValueError):
            self.done = {}

    def begin(self, step: str) -> None:
        """Forget a step: should it be interrupted, it counts as not done."""
        self.done.pop(step, None)
        self._save()

    def finish(self, step: str, key: str) -> None:
        """Remember for what a step was done."""
        self.done[step] = key
        self._save()

    def _save(self) -> None:
        STATE.write_text(json.dumps(self.done, indent=1) + "\n")


class Kernels:
    """The inner loops, which one processor compiles while the other does what comes after."""

    def __init__(self, state: State, key: str) -> None:
        self._state = state
        self._key = key
        self._step: Step | None = None

    def begin(self) -> None:
        """Begin to compile them, unless that is done or has begun."""
        if self._step is None and self._state.done.get("kernels") != self._key:
            self._state.begin("kernels")
            self._step = compile_kernels()

    def finish(self) -> None:
        """Wait for them, if they are being compiled."""
        step, self._step = self._step, None
        if step is None:
            return
        try:
            step.wait()
        except SetupError as error:
            # Sources in the middle of an edit must not keep anyone from checking and testing them.
            print(error, "They will be compiled when they are first used.", sep="\n")
        else:
            self._state.finish("kernels", self._key)

    def __enter__(self) -> Kernels:
        return self

    def __exit__(self, *_: object) -> None:
        if self._step is not None:  # what came after them failed
            self._step.stop()


def set_up() -> None:
    """Bring the virtual environment up to date."""
    state = State()
    sourced = sourced_distribution()
    ros = sourced or state.done.get("ros", WHEELS)
    if not sourced and ros != WHEELS and RECORD.exists():
        # An environment made with a sourced ROS 2 goes on working where it is not sourced.
        os.environ.update(completed(dict(os.environ), json.loads(RECORD.read_text())))
    requirements = [TOOLS / "requirements-ros.txt", TOOLS / "requirements-build.txt"]
    hook = TOOLS / "ros_environment.py"
    sources = sorted(file for file in MESSAGES.rglob("*") if file.is_file())
    modules = sorted((ROOT / "belt_ros").rglob("*.py"))
    loops = [file for file in modules if b"compiled" in file.read_bytes()]
    keys = {
        "ros": ros,
        "venv": f"{base_python()} {platform.python_version()} in {ROOT}",
        "packages": fingerprint(ROOT / "setup.py", ROOT / "setup.cfg", hook, *requirements),
        "messages": fingerprint(*requirements, *sources),
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
    with Kernels(state, keys["kernels"]) as kernels:
        if state.done.get("packages") != keys["packages"]:
            install(state, keys["packages"], ros, kernels)
        kernels.begin()
        if state.done.get("messages") != keys["messages"]:
            state.begin("messages")
            build_messages()
            state.finish("messages", keys["messages"])
        kernels.finish()


def install(state: State, key: str, ros: str, kernels: Kernels) -> None:
    """Install all packages; begin to compile the inner loops once theirs are there."""
    state.begin("packages")
    try:
        install_package(ros)
        kernels.begin()
        install_ros_and_tools(ros)
    except SetupError:
        # pip that gives up (no network, say) has changed nothing: no reason to start again.
        state.finish("packages", "failed")
        raise
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
        set_up()
    except SetupError as error:
        print(error, file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("\nInterrupted. Run make setup again to go on.", file=sys.stderr)
        return 130
    return 0


if __name__ == "__main__":
    sys.exit(main())
