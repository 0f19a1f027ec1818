import json
import re
import subprocess
import sys
from pathlib import Path

import pytest
import yaml
from typer.testing import CliRunner

import belt_ros
from belt_ros.cli import app
from belt_ros.node_tables import ALL_PARAMETERS

ROOT = Path(__file__).parents[1]
CONFIG = ROOT / "config" / "paper_drive.yaml"
SEVERAL = ROOT / "config" / "several_drives.yaml"


def belt(*words):
    return CliRunner().invoke(app, [str(word) for word in words])


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    """A bag of the rig, made by the command itself."""
    place = tmp_path_factory.mktemp("rig")
    scenario = place / "scenario.yaml"
    scenario.write_text("{duration: 0.5, speed: [[0.0, 50.0]], load: [[0.0, 10.0]]}")
    result = belt("rig", "--config", CONFIG, "--scenario", scenario, "--bag", place / "bag")
    assert result.exit_code == 0, result.output
    assert "51 joint states" in result.stdout
    return place / "bag"


def config_with(tmp_path, **changes):
    """The example configuration with flat parameters changed; None leaves one out."""
    parameters = yaml.safe_load(CONFIG.read_text())["/**"]["ros__parameters"]
    for name, value in changes.items():
        *groups, last = name.split("__")
        group = parameters
        for key in groups:
            group = group[key]
        if value is None:
            del group[last]
        else:
            group[last] = value
    path = tmp_path / "drive.yaml"
    path.write_text(yaml.safe_dump(parameters))
    return path


def assert_one_line(result, *patterns):
    assert result.exit_code == 1
    (line,) = result.stderr.strip().splitlines()
    for pattern in patterns:
        assert re.search(pattern, line), line
    assert "Traceback" not in result.output


def test_replay_prints_what_it_found_and_where_it_is(bag, tmp_path):
    result = belt("replay", bag, "--config", CONFIG, "--out", tmp_path / "out")
    assert result.exit_code == 0, result.output
    assert "51 of 51 messages on /joint_states used, 0.500 s" in result.stdout
    assert "mean tension" in result.stdout
    assert "worst margin" in result.stdout
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == [
        "estimates",
        "estimates.parquet",
        "smoothed.parquet",
        "summary.json",
    ]


def test_replay_names_its_results_after_the_bag(bag, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert belt("replay", bag, "-c", CONFIG).exit_code == 0
    summary = json.loads((tmp_path / "bag_belt" / "summary.json").read_text(encoding="utf-8"))
    assert summary["accepted"] == 51


def test_quiet_says_nothing(bag, tmp_path):
    result = belt("replay", bag, "-c", CONFIG, "-o", tmp_path / "out", "--quiet")
    assert (result.exit_code, result.output) == (0, "")


def test_force_replaces_earlier_results(bag, tmp_path):
    words = ("replay", bag, "-c", CONFIG, "-o", tmp_path / "out", "-q")
    assert belt(*words).exit_code == 0
    assert_one_line(belt(*words), "holds earlier results", "--force")
    assert belt(*words, "--force").exit_code == 0


def test_a_wrong_topic_is_one_line(bag, tmp_path):
    result = belt("replay", bag, "-c", CONFIG, "-o", tmp_path / "out", "--topic", "/nothing")
    assert_one_line(result, "no joint states on /nothing", "--topic: /joint_states")


def test_missing_joints_are_one_line_and_leave_nothing(bag, tmp_path):
    config = config_with(tmp_path, driver__joint="motor_joint")
    result = belt("replay", bag, "-c", config, "-o", tmp_path / "out")
    assert_one_line(result, "51 incomplete", "motor_joint", "driver_pulley_joint")
    assert not (tmp_path / "out").exists()


def test_what_is_no_bag_is_one_line(tmp_path):
    assert_one_line(belt("replay", tmp_path, "-c", CONFIG), "rosbag2 directory")
    assert_one_line(belt("replay", tmp_path / "gone", "-c", CONFIG), "no such file")


def test_what_a_pattern_matches_beside_bags_is_told_and_no_failure(bag, tmp_path):
    (bag.parent / "notes.txt").touch()
    pattern = f"{bag.parent}/*[gt]"
    for words in (("replay", pattern, "--no-smooth"), ("fleet", pattern, "--workers", "1")):
        out = tmp_path / words[0]
        result = belt(*words, "-c", CONFIG, "-o", out)
        assert result.exit_code == 0, result.output
        assert "1 of 2 matches are no bags and are left alone: notes.txt" in result.stderr
        quiet = belt(*words, "-c", CONFIG, "-o", tmp_path / f"{words[0]}_quiet", "--quiet")
        assert (quiet.exit_code, quiet.output) == (0, "")
    nothing = belt("replay", f"{bag.parent}/*.txt", "-c", CONFIG)
    assert_one_line(nothing, r"nothing that matches it is a bag: notes\.txt")
    assert_one_line(belt("replay", bag.parent / "notes.txt", "-c", CONFIG), "rosbag2 directory")


@pytest.mark.parametrize("words", [("replay",), ("replay", "bag"), ("check",), ("mistyped",)])
def test_wrong_usage_exits_with_2(words):
    result = belt(*words)
    assert result.exit_code == 2
    assert "Usage" in result.stderr


def test_check_says_what_the_drive_can_do():
    result = belt("check", CONFIG)
    assert result.exit_code == 0, result.output
    assert "critical belt speed: 879.1 m/s" in result.stdout  # sqrt(EA / m)
    capacity, low, high = map(
        float,
        re.search(r"435 N: (\S+) N m, 95 % interval (\S+) to (\S+) N m", result.stdout).groups(),
    )
    assert low < capacity < high
    assert all(share in result.stdout for share in ("25%", "50%", "75%"))


def test_check_of_a_massless_belt_knows_no_critical_speed(tmp_path):
    result = belt("check", config_with(tmp_path, belt__mass_per_length=0.0))
    assert "critical belt speed: none" in result.stdout


@pytest.mark.parametrize(
    ("changes", "patterns"),
    [
        ({"driver__radius": -1.0}, ["driver.radius is -1 m", "between"]),
        ({"driver__radius": None}, ["driver.radius is missing"]),
        ({"driver__radios": 1.0}, ["driver.radios", "did you mean driver.radius"]),
        ({"span_length": "long"}, ["span_length is 'long'", "number"]),
    ],
)
def test_check_names_what_is_wrong(tmp_path, changes, patterns):
    assert_one_line(belt("check", config_with(tmp_path, **changes)), *patterns)


def test_a_file_may_hold_every_parameter_that_the_node_takes(tmp_path):
    given = yaml.safe_load(CONFIG.read_text())["/**"]["ros__parameters"]
    defaults = {
        name: parameter.default
        for name, parameter in ALL_PARAMETERS.items()
        if parameter.default is not None and name.partition(".")[0] not in given
    }
    path = tmp_path / "drive.yaml"
    path.write_text(yaml.safe_dump({**given, **defaults, "use_sim_time": True}))
    assert len(defaults) > 15
    assert belt("check", path).exit_code == 0


@pytest.mark.parametrize(
    ("changes", "pattern"),
    [
        ({"input": "bogus"}, "input is 'bogus'; it must be one of"),
        ({"input_depth": 0}, "input_depth is 0 messages"),
        ({"state_period": -1.0}, "state_period is -1 s"),
        ({"autostart": "maybe"}, "autostart is 'maybe'"),
        ({"memory_perod": 5.0}, "did you mean memory_period"),
        ({"longest_pol": 0.1}, "did you mean longest_pool"),
    ],
)
def test_what_the_node_would_refuse_is_refused_by_all(tmp_path, changes, pattern):
    assert_one_line(belt("check", config_with(tmp_path, **changes)), pattern)


def test_parameters_lists_every_one():
    result = belt("parameters", "--markdown")
    assert result.exit_code == 0
    header, rule, *rows = result.stdout.strip().splitlines()
    assert re.fullmatch(r"\| parameter .*", header)
    assert re.fullmatch(r"(\| --- )+\|", rule)
    assert [row.split("`")[1] for row in rows] == list(ALL_PARAMETERS)
    assert len({len(re.findall(r"(?<!\\)\|", row)) for row in (header, rule, *rows)}) == 1
    for columns in ("80", "200"):
        shown = CliRunner().invoke(app, ["parameters"], env={"COLUMNS": columns})
        assert shown.exit_code == 0
        assert all(name in shown.stdout for name in ALL_PARAMETERS), "names are whole"


def test_rig_does_not_overwrite(bag):
    scenario = bag.parent / "scenario.yaml"
    assert_one_line(belt("rig", "-c", CONFIG, "-s", scenario, "--bag", bag), "exists already")


def test_version():
    assert belt("--version").stdout.split() == ["belt", belt_ros.__version__]


@pytest.mark.parametrize("command", ["replay", "check", "parameters", "demo", "node", "rig"])
def test_help_has_an_example(command):
    result = belt(command, "--help")
    assert result.exit_code == 0
    assert f"Example: belt {command}" in result.stdout


def test_help_imports_nothing_heavy():
    code = (
        "import sys, belt_ros.cli;"
        "print(sorted({'numpy', 'numba', 'rosbags', 'pyarrow', 'rclpy'} & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize(
    ("name", "size", "reason"),
    [
        (
            "polyamide-rubber",
            "25",
            "size is 25 m of width; it must lie between .*25 mm are 0.025 m",
        ),
        ("v-belt-spa", "2.5", "size is 2.5 belts; it must be a whole number"),
    ],
)
def test_figures_of_a_belt_that_there_cannot_be_are_refused(name, size, reason):
    assert_one_line(belt("materials", "--belt", name, "--size", size), reason)


def test_live_commands_say_where_ros_is_missing(monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    assert_one_line(belt("node"), "needs ROS 2", "make setup")


def test_materials_are_listed_in_tables():
    for table in ("belts", "limits", "friction", "laggings", "sections", "evidence", "sources"):
        result = belt("materials", table)
        assert result.exit_code == 0, result.output
        assert "low / typical / high" in result.stdout
    assert "polyamide" in belt("materials").stdout


def test_a_named_belt_comes_as_yaml_that_a_drive_takes_as_it_is(tmp_path):
    result = belt("materials", "--belt", "polyamide-rubber", "--size", "0.05")
    assert result.exit_code == 0, result.output
    values = yaml.safe_load(result.stdout)
    others, replaced = re.subn(r"(?m)^    (belt|prior):\n(      .*\n)+", "", CONFIG.read_text())
    assert replaced == len(values)
    path = tmp_path / "drive.yaml"
    path.write_text(others + result.stdout)
    assert yaml.safe_load(path.read_text())["/**"]["ros__parameters"].items() >= values.items()
    checked = belt("check", path)
    assert checked.exit_code == 0, checked.output
    assert values["belt"]["axial_stiffness"] == pytest.approx(0.05 * 8e5)


@pytest.mark.parametrize(
    ("words", "pattern"),
    [
        (["--belt", "HTD 5M"], "toothed.*drives by form"),
        (["--belt", "leather-strap"], "choose from.*polyamide"),
        (["--belt", "polyamide-rubber"], "--size is missing: m of width"),
        (
            ["--belt", "polyamide-rubber", "--size", "-1"],
            "size is -1 m of width; it must lie between",
        ),
        (
            ["--belt", "polyamide-rubber", "--size", "0.1", "--state", "icy"],
            "one of dry, wet, dirty",
        ),
        (["--belt", "polyamide-rubber", "--size", "0.1", "--on", "butter"], "butter"),
    ],
)
def test_what_a_material_cannot_be_is_one_line_with_the_choices(words, pattern):
    assert_one_line(belt("materials", *words), pattern)


def test_finite_elements_write_a_bag_that_replay_reads(tmp_path):
    scenario = tmp_path / "scenario.yaml"
    scenario.write_text(
        "{duration: 0.1, sample_rate: 500, speed: [[0.0, 20.0], [0.05, 40.0]], load: 5.0}"
    )
    words = ("--config", CONFIG, "--scenario", scenario)
    result = belt("rig", *words, "--bag", tmp_path / "bag", "--finite-elements")
    assert result.exit_code == 0, result.output
    assert "51 joint states" in result.stdout
    result = belt("replay", tmp_path / "bag", "--config", CONFIG, "--out", tmp_path / "out")
    assert result.exit_code == 0, result.output


def test_finite_elements_are_not_simulated_for_a_bag_that_is_there(bag, tmp_path, monkeypatch):
    monkeypatch.setattr("belt_ros.rig.simulate_finite_elements", None)  # it takes minutes
    scenario = tmp_path / "scenario.yaml"
    scenario.write_text("{duration: 60.0}")
    words = ("--config", CONFIG, "--scenario", scenario, "--bag", bag, "--finite-elements")
    assert_one_line(belt("rig", *words), "exists already; choose another name")


def test_finite_elements_are_not_played_live(tmp_path):
    scenario = tmp_path / "scenario.yaml"
    scenario.write_text("{duration: 0.1}")
    result = belt("rig", "--config", CONFIG, "--scenario", scenario, "--finite-elements")
    assert result.exit_code == 2
    assert "give --bag" in result.stderr


def test_check_says_it_of_each_of_several_drives():
    result = belt("check", SEVERAL)
    assert result.exit_code == 0, result.output
    for name in ("infeed", "outfeed", "lift"):
        assert name in result.stdout


def test_what_is_of_the_whole_node_is_not_of_one_drive(tmp_path):
    path = tmp_path / "drives.yaml"
    path.write_text(SEVERAL.read_text() + "\n    outfeed.autostart: true\n")
    assert_one_line(belt("check", path), "autostart is of the whole node")


def test_of_several_drives_the_rig_writes_the_bag_of_the_one_that_is_named(tmp_path):
    scenario = tmp_path / "scenario.yaml"
    scenario.write_text("{duration: 0.2, speed: [[0.0, 20.0]]}")
    words = ("rig", "--config", SEVERAL, "--scenario", scenario, "--bag", tmp_path / "bag")
    assert_one_line(belt(*words), "name one of infeed, outfeed, lift")
    result = belt(*words, "--drive", "outfeed")
    assert result.exit_code == 0, result.output


@pytest.mark.parametrize(
    ("more", "pattern"),
    [
        (("--bga", "out"), "--bga"),
        (("--bag", "out", "--ros-args", "-p", "output:=float64"), "--ros-args"),
        (("--drive", "outfeed"), "give --bag"),
    ],
)
def test_what_the_rig_cannot_take_is_refused(tmp_path, more, pattern):
    scenario = tmp_path / "scenario.yaml"
    scenario.write_text("{duration: 0.2}")
    result = belt("rig", "--config", SEVERAL, "--scenario", scenario, *more)
    assert result.exit_code == 2
    assert pattern in result.stderr


def test_units_are_in_the_help():
    """Rich takes what stands in square brackets for markup."""
    written = "".join(path.read_text() for path in (ROOT / "belt_ros" / "cli").glob("*.py"))
    assert not re.findall(r'help="[^"]*\[[a-z][^"]*"', written)
    shown = " ".join(re.sub("[│╭╮╰╯─]", " ", belt("init", "--help").stdout).split())
    assert shown.count("inertia (kg m2)") == 2
    assert "pulley (m)" in shown


def test_a_belt_that_changed_meanwhile_is_not_written_as_identified(tmp_path):
    demo = ROOT / "config" / "demo_drive.yaml"  # whose scenario takes 40 % of the tension away
    script = ROOT / "config" / "scenarios" / "demo.yaml"
    made = belt("rig", "--config", demo, "--scenario", script, "--bag", tmp_path / "bag")
    assert made.exit_code == 0, made.output
    words = ("identify", tmp_path / "bag", "--config", demo, "--out", tmp_path / "found.yaml")
    assert_one_line(belt(*words), "not written: the model does not fit")
    assert not (tmp_path / "found.yaml").exists()
    assert belt(*words, "--force").exit_code == 0
    assert belt("check", tmp_path / "found.yaml").exit_code == 0


def test_a_first_description_is_written_to_a_folder_that_is_not_there_yet(tmp_path):
    """All that was asked on the way to it would be lost otherwise."""
    flags = {
        "driver-radius": 0.08, "driven-radius": 0.12, "centre-distance": 0.6, "size": 0.05,
        "belt": "polyamide-rubber", "driver-inertia": 0.02, "driven-mass": 3,
    }  # fmt: skip
    words = [word for name, value in flags.items() for word in (f"--{name}", value)]
    made = belt("init", tmp_path / "new" / "drive.yaml", *words)
    assert made.exit_code == 0, made.output
    assert belt("check", tmp_path / "new" / "drive.yaml").exit_code == 0
    assert_one_line(belt("init", CONFIG / "drive.yaml", *words), "cannot write .*drive.yaml: ")


def test_a_fleet_with_a_drive_that_failed_says_so_by_page_summary_and_exit_code(bag, tmp_path):
    """One drive of the two is in the bag, so that the bag did not fail as a whole."""
    config = config_with(
        tmp_path,
        drives=["here", "elsewhere"],
        elsewhere={"driver": {"joint": "head"}, "driven": {"joint": "tail"}},
    )
    words = ("fleet", bag, "--out", tmp_path / "out", "--workers", "1", "--config")
    failed = belt(*words, config)
    told = "1 of 2 results (one for each drive in each bag) failed"
    assert (failed.exit_code, told in failed.stdout) == (1, True), failed.output
    assert told in (tmp_path / "out" / "fleet.html").read_text(encoding="utf-8")
    good = belt(*words, CONFIG)
    assert (good.exit_code, "0 of 1 results" in good.stdout) == (0, True), good.output


def test_figures_are_drawn_one_by_one_and_named(tmp_path):
    result = belt("figures", "--out", tmp_path / "figures", "--only", "10", "--only", "table1")
    assert result.exit_code == 0, result.output
    for line in result.stdout.split():
        assert Path(line).stat().st_size > 100
    assert {Path(line).suffix for line in result.stdout.split()} == {".png", ".md"}


def test_an_unknown_figure_is_refused_with_the_names_there_are(tmp_path):
    result = belt("figures", "--out", tmp_path / "figures", "--only", "99")
    assert result.exit_code == 2
    assert "99" in result.stderr
    assert "table2" in result.stderr
    assert not (tmp_path / "figures").exists()
