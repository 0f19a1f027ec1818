"""Launch files: they compile, start programs that exist, and describe their arguments."""

import ast
import importlib.util
from pathlib import Path
from types import ModuleType

import pytest
from node_harness import ROOT

FILES = sorted((ROOT / "launch_scripts").glob("*.launch.py"))
ARGUMENTS = {
    "belt_node.launch.py": {"params_file", "namespace", "joint_states_topic", "memory_file"},
    "demo.launch.py": {"params_file", "scenario_file", "namespace"},
}
each_file = pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)


def load(path: Path) -> ModuleType:
    specification = importlib.util.spec_from_file_location("launch_file", path)
    assert specification is not None
    assert specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


def keywords(path: Path, name: str) -> list[str]:
    """The values that a keyword argument is given anywhere in the file."""
    return [
        node.value.value
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.keyword)
        and node.arg == name
        and isinstance(node.value, ast.Constant)
    ]


def test_every_launch_file_is_known_here() -> None:
    assert {path.name for path in FILES} == set(ARGUMENTS)


@each_file
def test_it_compiles(path: Path) -> None:
    compile(path.read_text(), str(path), "exec")


@each_file
def test_what_it_starts_is_installed(path: Path) -> None:
    setup = (ROOT / "setup.py").read_text()

    for executable in keywords(path, "executable"):
        assert f'"{executable} = belt_ros.' in setup
    assert set(keywords(path, "package")) == {"belt_ros"}


@each_file
def test_its_arguments_are_described(path: Path) -> None:
    pytest.importorskip("launch_ros", reason="launch comes with a ROS 2 installation only")
    arguments = load(path).generate_launch_description().get_launch_arguments()

    assert {argument.name for argument in arguments} >= ARGUMENTS[path.name]
    assert all(argument.description for argument in arguments)
