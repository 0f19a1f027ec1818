"""Launch files: they compile, start programs that exist, and describe their arguments.

What needs `launch` is skipped without it; the rest is read off the text.
"""

import ast
import importlib.util
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest
from node_harness import ROOT

FILES = sorted((ROOT / "launch_scripts").glob("*.launch.py"))
OF_THE_NODE = {"params_file", "namespace", "joint_states_topic", "log_level"}
ARGUMENTS = {
    "belt_node.launch.py": OF_THE_NODE
    | {"name", "autostart", "use_sim_time", "use_memory", "memory_file", "respawn"},
    "demo.launch.py": {"params_file", "scenario_file", "namespace"},
    "monitor.launch.py": OF_THE_NODE
    | {"name", "use_sim_time", "memory_file", "aggregate", "analyzers_file"},
    "replay_bag.launch.py": OF_THE_NODE | {"bag", "topics", "rate", "loop", "clock_rate"},
    "rig.launch.py": {"params_file", "scenario_file", "namespace", "joint_states_topic"}
    | {"output", "drives", "driver_rate", "driven_rate", "truth_rate", "loads", "fault", "loop"}
    | {"rate_factor", "subscribers", "wait_for_subscriber"},
}
MUST_BE_GIVEN = {
    "belt_node.launch.py": {"params_file"},
    "demo.launch.py": set(),
    "monitor.launch.py": {"params_file"},
    "replay_bag.launch.py": {"params_file", "bag"},
    "rig.launch.py": set(),
}
OTHERS_PACKAGES = {"monitor.launch.py": {"aggregator_node"}}
each_file = pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)


def load(path: Path) -> ModuleType:
    specification = importlib.util.spec_from_file_location("launch_file", path)
    assert specification is not None
    assert specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


def arguments(path: Path) -> list[Any]:
    """Those that the launch file declares itself."""
    pytest.importorskip("launch_ros", reason="launch comes with a ROS 2 installation only")
    from launch.actions import DeclareLaunchArgument  # noqa: PLC0415

    entities = load(path).generate_launch_description().entities
    return [entity for entity in entities if isinstance(entity, DeclareLaunchArgument)]


def keywords(path: Path, name: str) -> list[str]:
    """The values that a keyword argument is given anywhere in the file."""
    return [
        node.value.value
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.keyword)
        and node.arg == name
        and isinstance(node.value, ast.Constant)
    ]


def calls(path: Path, name: str) -> list[ast.Call]:
    return [
        node
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == name
    ]


def texts(node: ast.AST) -> list[str]:
    return [
        each.value
        for each in ast.walk(node)
        if isinstance(each, ast.Constant) and isinstance(each.value, str)
    ]


def test_every_launch_file_is_known_here() -> None:
    assert {path.name for path in FILES} == set(ARGUMENTS)


@each_file
def test_it_compiles(path: Path) -> None:
    compile(path.read_text(), str(path), "exec")


@each_file
def test_what_it_starts_is_installed(path: Path) -> None:
    setup = (ROOT / "setup.py").read_text()

    started = set(keywords(path, "executable")) - OTHERS_PACKAGES.get(path.name, set())
    for executable in started:
        assert f'"{executable} = belt_ros.' in setup
    assert set(keywords(path, "package")) <= {"belt_ros"}


@each_file
def test_files_of_the_package_that_it_names_are_installed(path: Path) -> None:
    setup = (ROOT / "setup.py").read_text()
    places = {"config": "config", "launch": "launch_scripts"}

    for call in calls(path, "PathJoinSubstitution"):
        place, *rest = texts(call)
        source = ROOT.joinpath(places[place], *rest)
        assert source.is_file(), f"{path.name} names {source}"
        assert f'glob("{source.relative_to(ROOT).parent}/*{"".join(source.suffixes)}")' in setup


@each_file
def test_every_declaration_has_a_description(path: Path) -> None:
    for call in calls(path, "DeclareLaunchArgument"):
        assert "description" in {keyword.arg for keyword in call.keywords}


@each_file
def test_what_it_reads_it_declares(path: Path) -> None:
    read = {text for call in calls(path, "LaunchConfiguration") for text in texts(call)}

    assert read <= ARGUMENTS[path.name]


@each_file
def test_its_arguments_are_described(path: Path) -> None:
    declared = arguments(path)

    assert {argument.name for argument in declared} == ARGUMENTS[path.name]
    assert all(argument.description for argument in declared)
    needed = {argument.name for argument in declared if argument.default_value is None}
    assert needed == MUST_BE_GIVEN[path.name]


def test_the_rig_is_given_parameters_that_it_has() -> None:
    pytest.importorskip("launch_ros", reason="launch comes with a ROS 2 installation only")
    source = (ROOT / "belt_ros" / "rig" / "node_parameters.py").read_text()

    names = load(ROOT / "launch_scripts" / "rig.launch.py")._PARAMETERS
    assert names
    for name in set(names) - {"fault"}:
        assert f'"{name}"' in source


def test_the_node_is_given_parameters_that_it_has() -> None:
    from belt_ros.node_tables import DRIVE_PARAMETERS, NODE_PARAMETERS  # noqa: PLC0415

    replay = ast.parse((ROOT / "launch_scripts" / "replay_bag.launch.py").read_text())
    given = {
        text
        for node in ast.walk(replay)
        if isinstance(node, ast.Dict)
        for key in node.keys
        if key is not None
        for text in texts(key)
    }
    assert given == {"autostart", "input_depth", "use_sim_time", "use_memory"}
    given |= ARGUMENTS["belt_node.launch.py"] & {
        "autostart",
        "use_sim_time",
        "use_memory",
        "memory_file",
    }
    assert given <= {*NODE_PARAMETERS, *DRIVE_PARAMETERS, "use_sim_time"}
