"""What the package says of itself, and what of it is installed."""

import ast
import os
import shutil
import subprocess
import sys
import xml.etree.ElementTree as ET
import zipfile
from pathlib import Path

import pytest

import belt_ros

ROOT = Path(__file__).resolve().parents[2]
COPIED = ("LICENSE", "MANIFEST.in", "package.xml", "pyproject.toml", "setup.cfg", "setup.py")
COPIED_WHOLE = ("belt_ros", "config", "launch_scripts", "msg_defs", "resource")


def keyword_of_setup(name: str) -> str:
    """What setup.py gives setup() as a keyword argument."""
    tree = ast.parse((ROOT / "setup.py").read_text())
    (value,) = (
        node.value.value
        for node in ast.walk(tree)
        if isinstance(node, ast.keyword)
        and node.arg == name
        and isinstance(node.value, ast.Constant)
    )
    return str(value)


def in_package_xml(directory: str, name: str) -> str | None:
    return ET.parse(ROOT / directory / "package.xml").findtext(name)


def test_version_is_the_same_everywhere() -> None:
    versions = {
        "belt_ros": belt_ros.__version__,
        "setup.py": keyword_of_setup("version"),
        "package.xml": in_package_xml(".", "version"),
        "msg_defs/package.xml": in_package_xml("msg_defs", "version"),
    }

    assert set(versions.values()) == {belt_ros.__version__}, versions


def test_licence_is_the_same_everywhere() -> None:
    licences = {in_package_xml(".", "license"), in_package_xml("msg_defs", "license")}

    assert licences == {keyword_of_setup("license")}


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A wheel made of a copy, so that building leaves nothing in the checkout."""
    place = tmp_path_factory.mktemp("wheel")
    copy = place / "copy"
    for name in COPIED_WHOLE:
        shutil.copytree(ROOT / name, copy / name)
    for name in COPIED:
        shutil.copy(ROOT / name, copy)
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "wheel", "--no-index"]
    subprocess.run(
        [*pip, "--no-deps", "--no-build-isolation", "-w", place, copy],
        check=True,
        capture_output=True,
        timeout=100,
    )
    (wheel,) = place.glob("*.whl")
    return wheel


def names(directory: Path, pattern: str) -> set[str]:
    return {file.name for file in directory.glob(pattern)}


@pytest.mark.parametrize(
    ("installed", "source", "pattern"),
    [
        ("belt_ros/message_texts", "msg_defs/msg", "*.msg"),
        ("share/belt_ros", ".", "package.xml"),
        ("share/belt_ros/config", "config", "*.yaml"),
        ("share/belt_ros/config/scenarios", "config/scenarios", "*.yaml"),
        ("share/belt_ros/launch", "launch_scripts", "*.launch.py"),
        ("share/ament_index/resource_index/packages", "resource", "belt_ros"),
    ],
)
def test_files_are_installed(wheel: Path, installed: str, source: str, pattern: str) -> None:
    with zipfile.ZipFile(wheel) as archive:
        paths = [Path(name) for name in archive.namelist()]
    there = {path.name for path in paths if path.parent.as_posix().endswith(installed)}

    assert there == names(ROOT / source, pattern)


def test_installed_package_knows_its_messages_without_ros_and_checkout(
    wheel: Path, tmp_path: Path
) -> None:
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(tmp_path)
    script = (
        "from belt_ros import message_types\n"
        "print(message_types.__file__, *message_types.message_texts())\n"
        "message_types.belt_typestore()"
    )
    result = subprocess.run(
        [sys.executable, "-c", script],
        env={**os.environ, "PYTHONPATH": str(tmp_path), "AMENT_PREFIX_PATH": ""},
        cwd=tmp_path,
        check=True,
        capture_output=True,
        text=True,
        timeout=60,
    )
    file, *types = result.stdout.split()

    assert Path(file).is_relative_to(tmp_path)
    assert types == [
        f"belt_msgs/msg/{name}"
        for name in ("AlarmCondition", "BeltState", "PulleyState", "SlipAlarm")
    ]
