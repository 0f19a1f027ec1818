"""What set-up says and does, without setting anything up."""

import importlib.util
import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
TOOLS = ROOT / "tools"


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """A checkout whose path has a space, without an environment."""
    copy = tmp_path / "a checkout"
    (copy / "tools").mkdir(parents=True)
    (copy / "msg_defs").mkdir()
    (copy / "belt_ros").mkdir()
    for file in (*TOOLS.glob("*.py"), *TOOLS.glob("*.txt")):
        (copy / "tools" / file.name).write_text(file.read_text())
    for name in ("setup.py", "setup.cfg"):
        (copy / name).write_text((ROOT / name).read_text())
    return copy


def set_up(
    checkout: Path, prelude: str = "", **environment: str
) -> subprocess.CompletedProcess[str]:
    """Run the set-up script of a checkout, after a prelude that changes what it finds."""
    script = (
        f"import sys; sys.path.insert(0, {str(checkout / 'tools')!r})\n"
        f"import setup_environment as setup\n{prelude}\nsys.exit(setup.main())"
    )
    return subprocess.run(
        [sys.executable, "-c", script],
        env={**os.environ, "ROS_DISTRO": "", **environment},
        capture_output=True,
        text=True,
        timeout=30,
        check=False,
    )


def test_missing_compiler_is_named_with_the_line_that_installs_it(checkout: Path) -> None:
    result = set_up(checkout, PATH="", CXX="")

    assert result.returncode == 1
    assert "a C++ compiler (g++)" in result.stderr
    assert "sudo apt install g++" in result.stderr
    assert not (checkout / ".venv").exists()


def test_all_that_is_missing_is_named_at_once(checkout: Path) -> None:
    prelude = (
        "import importlib.util, sysconfig\n"
        "importlib.util.find_spec = lambda name: None\n"
        "sysconfig.get_paths = lambda: {'include': '/nowhere'}\n"
        "sys.base_prefix = '/usr'"
    )
    result = set_up(checkout, prelude, PATH="", CXX="")

    version = "{}.{}".format(*sys.version_info)
    assert f"sudo apt install python{version}-venv python{version}-dev g++" in result.stderr


@pytest.mark.parametrize(
    ("prelude", "words"),
    [
        ("setup.platform.machine = lambda: 'aarch64'", "not Linux aarch64"),
        ("setup.platform.system = lambda: 'Darwin'", "not Darwin x86_64"),
        ("setup.sys.version_info = (3, 9, 2)", "Python >= 3.10"),
        ("setup.sys.version_info = (3, 99, 0)", "Python <= 3.14"),
    ],
)
def test_unsuitable_machine_is_told_why(checkout: Path, prelude: str, words: str) -> None:
    result = set_up(checkout, prelude)

    assert result.returncode == 1
    assert words in result.stderr
    assert "Traceback" not in result.stderr


def test_failed_step_names_the_log_with_its_output(checkout: Path) -> None:
    prelude = (
        "setup.make_virtual_environment = lambda ros: setup.run_logged("
        "'virtual environment', sys.executable, '-c', 'raise SystemExit(\"no disk left\")')"
    )
    result = set_up(checkout, prelude)

    assert result.returncode == 1
    assert "no disk left" in result.stderr
    log = checkout / ".venv" / "setup.log"
    assert f"Full log: {log}" in result.stderr
    assert "no disk left" in log.read_text()


STEPS_THAT_ONLY_TELL = """
def tell(name):
    def step(*arguments):
        print('step:', name)
        if name == {interrupted!r}:
            raise KeyboardInterrupt
    return step
def make(ros):
    (setup.VENV / 'bin').mkdir()
    setup.VENV_PYTHON.touch()
    print('step: venv')
setup.make_virtual_environment = make
setup.install_packages = tell('packages')
setup.repair_wheels = setup.link_package = lambda: None
setup.install_ros_environment = lambda ros: None
setup.build_messages = tell('messages')
class Compiling:
    ended = False
    def __init__(self):
        print('begun: kernels')
    def stop(self):
        print('stopped: kernels')
    def wait(self):
        print('step: kernels')
        if not {compiles}:
            raise setup.SetupError('no such kernel')
setup.compile_kernels = Compiling
"""


def steps(
    checkout: Path, interrupted: str = "", *, compiles: bool = True, prelude: str = ""
) -> list[str]:
    prelude += STEPS_THAT_ONLY_TELL.format(interrupted=interrupted, compiles=compiles)
    result = set_up(checkout, prelude)
    assert result.returncode == (130 if interrupted else 0), result.stderr
    return [line.split()[1] for line in result.stdout.splitlines() if line.startswith("step:")]


INSTALLERS_THAT_ONLY_TELL = """
import subprocess, setup_packages
def run(name, *command):
    print('step:', ' '.join(str(part) for part in command))
    if name in {failing!r}:
        raise setup.SetupError(f'{{name}} failed')
setup_packages.run_logged = run
answer = subprocess.CompletedProcess([], 0, {configured!r}, '')
setup_packages.run_quietly = lambda *command: answer
setup.VENV.mkdir()
setup.main = lambda: setup_packages.install_packages({ros!r})
"""


def installers(
    checkout: Path, ros: str = "wheels", configured: str = "", failing: tuple[str, ...] = ()
) -> list[str]:
    """Return what installs, in turn, up to what is no failure."""
    prelude = INSTALLERS_THAT_ONLY_TELL.format(ros=ros, configured=configured, failing=failing)
    result = set_up(checkout, prelude)
    assert result.returncode == 0, result.stderr
    commands = [line for line in result.stdout.splitlines() if line.startswith("step:")]
    return ["uv" if "bin/uv" in command else "pip" for command in commands]


def test_packages_are_installed_by_uv_which_pip_brings(checkout: Path) -> None:
    assert installers(checkout) == ["pip", "uv"]


@pytest.mark.parametrize(
    ("failing", "turns"),
    [("uv", ["pip", "pip"]), ("belt_ros, ROS 2 and tools", ["pip", "uv", "pip"])],
)
def test_pip_installs_what_uv_cannot(checkout: Path, failing: str, turns: list[str]) -> None:
    assert installers(checkout, failing=(failing,)) == turns


@pytest.mark.parametrize(
    ("configured", "turns"),
    [
        ("global.index-url='https://index.example'", ["pip"]),
        (":env:.no-index='1'", ["pip"]),
        ("global.extra-index-url='https://more.example'", ["pip", "uv"]),
    ],
)
def test_pip_installs_where_it_is_told_of_an_index_of_its_own(
    checkout: Path, configured: str, turns: list[str]
) -> None:
    assert installers(checkout, configured=configured) == turns


def test_pip_installs_beside_a_sourced_ros(checkout: Path) -> None:
    assert installers(checkout, ros="jazzy") == ["pip"]


def test_second_set_up_has_nothing_to_do(checkout: Path) -> None:
    assert steps(checkout) == ["venv", "packages", "messages", "kernels"]
    assert steps(checkout) == []


def test_each_step_is_done_again_when_what_it_depends_on_changes(checkout: Path) -> None:
    steps(checkout)
    (checkout / "msg_defs" / "New.msg").write_text("float64 x\n")
    assert steps(checkout) == ["messages"]
    (checkout / "setup.py").write_text("# changed\n")
    assert steps(checkout) == ["packages"]
    (checkout / "belt_ros" / "arc.py").write_text("@compiled\ndef arc(): ...\n")
    assert steps(checkout) == ["kernels"]
    (checkout / "belt_ros" / "table.py").write_text("changed\n")
    (checkout / "README.md").write_text("changed\n")
    assert steps(checkout) == []


def test_set_up_interrupted_while_installing_starts_again_from_nothing(checkout: Path) -> None:
    assert steps(checkout, interrupted="packages") == ["venv", "packages"]
    assert steps(checkout) == ["venv", "packages", "messages", "kernels"]


def test_set_up_interrupted_while_building_messages_goes_on_there(checkout: Path) -> None:
    steps(checkout, interrupted="messages")
    assert steps(checkout) == ["messages", "kernels"]


def test_kernels_end_with_a_set_up_that_is_interrupted(checkout: Path) -> None:
    prelude = STEPS_THAT_ONLY_TELL.format(interrupted="messages", compiles=True)
    assert "stopped: kernels" in set_up(checkout, prelude).stdout


def test_kernels_are_compiled_while_messages_are_built(checkout: Path) -> None:
    prelude = STEPS_THAT_ONLY_TELL.format(interrupted="", compiles=True)
    told = [line.split()[-1] for line in set_up(checkout, prelude).stdout.splitlines()[1:]]

    assert told == ["venv", "packages", "kernels", "messages", "kernels"]


def test_kernels_that_do_not_compile_are_no_obstacle_and_are_tried_again(checkout: Path) -> None:
    assert steps(checkout, compiles=False)[-1] == "kernels"
    assert steps(checkout) == ["kernels"]


def test_who_needs_no_kernels_does_not_wait_for_them(checkout: Path) -> None:
    left = steps(checkout, prelude="sys.argv.append('--leave-loops')\n")

    assert left == ["venv", "packages", "messages"]
    assert steps(checkout) == ["kernels"]


def test_kernels_that_are_left_are_compiled_to_their_end(checkout: Path) -> None:
    steps(checkout)
    script = checkout / "tools" / "compile_kernels.py"
    script.write_text(
        "import time; from pathlib import Path\n"
        "end = time.monotonic() + 60.0\n"
        "while not Path('go').exists() and time.monotonic() < end: time.sleep(0.1)\n"
        "time.sleep(0.5)\n"
        "Path('done').touch()\n"
    )
    python = "setup.VENV_PYTHON = setup.Path(sys.executable)"

    set_up(checkout, f"sys.argv.append('--leave-loops')\n{python}")
    assert not (checkout / "done").exists()
    result = set_up(checkout, f"{python}\n(setup.ROOT / 'go').touch()")

    assert "Waiting for the set-up that is running here" in result.stdout
    assert "inner loops" in result.stdout
    assert (checkout / "done").exists()


def test_failure_to_compile_is_shown(checkout: Path) -> None:
    steps(checkout)
    script = checkout / "tools" / "compile_kernels.py"
    script.write_text("raise SystemExit('no such kernel')\n")
    result = set_up(checkout, "setup.VENV_PYTHON = setup.Path(sys.executable)")

    assert result.returncode == 0
    assert "inner loops ... failed" in result.stdout
    assert "no such kernel" in result.stdout
    assert "compiled when they are first used" in result.stdout


def test_only_the_latest_machine_code_is_kept(tmp_path: Path) -> None:
    pytest.importorskip("belt_msgs", reason="belt_msgs is not built")
    name = "compile_kernels"
    specification = importlib.util.spec_from_file_location(name, TOOLS / f"{name}.py")
    assert specification is not None
    assert specification.loader is not None
    kernels = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(kernels)
    for age, digit in enumerate("abcdef"):
        place = tmp_path / (digit * 16)
        place.mkdir()
        os.utime(place, (1e9 - age, 1e9 - age))
    (tmp_path / "something else").mkdir()

    kernels.remove_outdated(tmp_path / ("e" * 16))

    left = {place.name for place in tmp_path.iterdir()}
    assert left == {"e" * 16, "a" * 16, "b" * 16, "something else"}


def test_environment_is_completed_in_front_and_once() -> None:
    script = (
        f"import sys; sys.path.insert(0, {str(TOOLS)!r})\n"
        "from ros_environment import completed\n"
        "recorded = {'LD_LIBRARY_PATH': ['/venv', '/ros'], 'ROS_DISTRO': ['kilted']}\n"
        "first = completed({'LD_LIBRARY_PATH': '/ros:/mine', 'ROS_DISTRO': 'jazzy'}, recorded)\n"
        "assert first == {'LD_LIBRARY_PATH': '/venv:/ros:/mine', 'ROS_DISTRO': 'jazzy'}, first\n"
        "assert completed(first, recorded) == first\n"
        "assert completed({}, recorded)['ROS_DISTRO'] == 'kilted'\n"
    )
    subprocess.run([sys.executable, "-c", script], check=True, timeout=30)


def test_environment_needs_no_sourcing() -> None:
    """From a bare environment, messages load and packages are found."""
    if not (Path(sys.prefix) / "ros_environment.json").exists():
        pytest.skip("not in an environment made by make setup")
    script = (
        "from belt_msgs.msg import BeltState; BeltState.__import_type_support__()\n"
        "from ament_index_python import get_package_share_directory as share\n"
        "print(share('belt_msgs'), share('belt_ros'))"
    )
    subprocess.run(
        [sys.executable, "-c", script], env={"HOME": str(Path.home())}, check=True, timeout=30
    )
