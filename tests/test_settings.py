"""A drive description is what a node would take from the same parameter file."""

import textwrap
from pathlib import Path

import pytest
import yaml

from belt_ros.identify.written import _edited
from belt_ros.parameter_table import SettingsError
from belt_ros.replay.drives import load_drives
from belt_ros.settings import load_settings, read_parameters

CONFIG = Path(__file__).resolve().parents[1] / "config" / "paper_drive.yaml"
TALKER = {"talker": {"ros__parameters": {"rate": 10}}}


def drive() -> dict[str, object]:
    """Parameters of the paper's drive, which has a prior tension of 435 N."""
    found = yaml.safe_load(CONFIG.read_text())["/**"]["ros__parameters"]
    assert isinstance(found, dict)
    return found


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "bring_up.yaml"


def tension(file: Path, *sections: dict[str, object]) -> float:
    """Prior tension of a file with these sections, one after the other."""
    file.write_text("".join(yaml.safe_dump(section) for section in sections))
    return load_settings(file).prior.tension


@pytest.mark.parametrize(
    "name", ["belt_node", "/belt_node", "/cell_3/belt_node", "/**/belt_node", "/*"]
)
def test_parameters_of_the_node_go_before_those_of_every_node(file: Path, name: str) -> None:
    own = {name: {"ros__parameters": {"prior": {"tension": 777.0}}}}
    assert tension(file, {"/**": {"ros__parameters": drive()}}, own) == 777.0


def test_parameters_of_a_namespace_are_found(file: Path) -> None:
    assert tension(file, {"cell_3": {"belt_node": {"ros__parameters": drive()}}}, TALKER) == 435.0


@pytest.mark.parametrize("name", ["/**", "belt_node"])
def test_other_nodes_may_be_in_the_same_file(file: Path, name: str) -> None:
    assert tension(file, TALKER, {name: {"ros__parameters": drive()}}) == 435.0


def test_what_every_node_has_may_stand_apart(file: Path) -> None:
    common = {"/**": {"ros__parameters": {"use_sim_time": True}}}
    assert tension(file, common, {"belt_node": {"ros__parameters": drive()}}) == 435.0


def test_a_node_of_another_name_may_be_alone(file: Path) -> None:
    assert tension(file, {"press_belt": {"ros__parameters": drive()}}) == 435.0


def test_file_for_other_nodes_only_is_refused_with_their_names(file: Path) -> None:
    with pytest.raises(SettingsError, match=r"bring_up.yaml: .*talker, listener, .*belt_node"):
        tension(file, TALKER, {"listener": {"ros__parameters": {"rate": 1}}})


def test_nodes_of_several_namespaces_are_not_mixed_into_one(file: Path) -> None:
    with pytest.raises(SettingsError, match=r"belt_node in cell_3, cell_4; give each"):
        tension(
            file,
            {"/cell_3/belt_node": {"ros__parameters": drive()}},
            {"cell_4": {"belt_node": {"ros__parameters": {"prior": {"tension": 777.0}}}}},
        )


def test_values_are_edited_where_they_have_the_last_word(file: Path) -> None:
    both = {"/**": {"ros__parameters": drive()}} | {
        "belt_node": {"ros__parameters": {"prior": {"tension": 777.0}}}
    }
    file.write_text(_edited(yaml.safe_dump(both, sort_keys=False), {"prior.tension": "500.0"}))
    assert read_parameters(file)["prior.tension"] == 500.0


def several(file: Path, **drives: dict[str, object]) -> Path:
    """Describe drives like the paper's, each with what is its own."""
    parameters = {**drive(), "drives": list(drives), **drives}
    parameters.pop("name", None)
    file.write_text(yaml.safe_dump({"/**": {"ros__parameters": parameters}}))
    return file


def test_both_pulleys_cannot_be_the_same_joint(file: Path) -> None:
    with pytest.raises(SettingsError, match=r"driver.joint and driven.joint are both 'roller'"):
        load_drives(several(file, a={"driver.joint": "roller", "driven.joint": "roller"}))


def test_drives_that_read_the_same_joints_are_refused_with_their_names(file: Path) -> None:
    with pytest.raises(SettingsError, match=r"a and b both read the joints .*set driver.joint"):
        load_drives(several(file, a={}, b={}))


@pytest.mark.parametrize(
    "own", [{"input": "pulley_state"}, {"driven.joint": "tail"}, {"driver.joint": "head"}]
)
def test_drives_may_share_a_joint_or_have_topics_of_their_own(
    file: Path, own: dict[str, object]
) -> None:
    assert len(load_drives(several(file, a={}, b=own))) == 2


def test_drives_of_one_name_are_refused(file: Path) -> None:
    own = {"input": "pulley_state", "name": "press"}
    with pytest.raises(SettingsError, match="name is 'press' for several drives"):
        load_drives(several(file, a=own, b=dict(own)))


def test_a_single_drive_goes_by_no_other_name_than_its_own(file: Path) -> None:
    file.write_text(yaml.safe_dump(drive()))
    assert load_settings(file, drive="paper_drive").name == "paper_drive"
    with pytest.raises(SettingsError, match="no drive 'press', but one called 'paper_drive'"):
        load_settings(file, drive="press")


@pytest.mark.parametrize(
    ("entry", "reason"),
    [
        ("name: 2024-31-12", "no valid YAML: month must be in 1..12"),
        ("prior: &a {x: *a}", r"\*a in line 3: ROS 2 takes no aliases"),
    ],
)
def test_odd_yaml_is_refused_with_the_reason(file: Path, entry: str, reason: str) -> None:
    file.write_text(f"belt_node:\n  ros__parameters:\n    {entry}\n", encoding="utf-8")
    with pytest.raises(SettingsError, match=reason):
        load_settings(file)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        (
            """
            /**: {ros__parameters: {driver: {radius: 0.1}}}
            /**: {ros__parameters: {driven: {radius: 0.1}}}
            """,
            r"/\*\* is given in line 2 and again in line 3",
        ),
        (
            """
            belt_node:
              ros__parameters:
                prior:
                  tension: 435.0
                noise: {speed_absolute: 0.01}
                prior:
                  friction_coefficient: 1.2
            """,
            "prior is given in line 4 and again in line 7",
        ),
        ("prior: {tension: 435.0, 'tension': 436.0}", "tension is given in line 1 and again in"),
        ("drives:\n  - {1: infeed,\n    '1': outfeed}", "1 is given in line 2 and again in line 3"),
        ("prior.tension: 435.0\nprior: {tension: 436.0}", r"prior\.tension is given twice"),
    ],
)
def test_what_is_given_twice_is_refused_with_its_name_and_lines(
    file: Path, text: str, reason: str
) -> None:
    """Of two blocks of one name, the last would count here, and a node would take both."""
    file.write_text(textwrap.dedent(text), encoding="utf-8")
    with pytest.raises(SettingsError, match=rf"bring_up\.yaml.*{reason}"):
        read_parameters(file)


def test_nested_aliases_are_refused_at_once(file: Path) -> None:
    """Of this size they would stand for 10^30 entries."""
    levels = "".join(f"a{n}: &x{n} [{', '.join([f'*x{n - 1}'] * 10)}]\n" for n in range(1, 31))
    file.write_text(f"a0: &x0 1\n{levels}", encoding="utf-8")
    with pytest.raises(SettingsError, match=r"\*x0 in line 2: ROS 2 takes no aliases"):
        read_parameters(file)


def test_sections_of_one_node_count_together_however_they_are_nested(file: Path) -> None:
    own = {"cell_3/belt_node": {"ros__parameters": {"prior": {"tension": 777.0}}}}
    assert tension(file, {"cell_3": {"belt_node": {"ros__parameters": drive()}}}, own) == 777.0


def test_a_torque_scale_of_zero_is_refused() -> None:
    """It would make a measured torque of none out of one that is not measured."""
    with pytest.raises(SettingsError, match=r"driven\.torque_scale is 0"):
        load_settings(CONFIG, {"driven.torque_scale": 0.0})
