"""A drive's YAML from a few answers: accepted as it is, and plain about what was guessed."""

import io
import math
from pathlib import Path

import pytest
import yaml
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st
from rich.console import Console

from belt_ros.mechanics.materials import BELTS
from belt_ros.parameter_table import SettingsError
from belt_ros.rating import rate
from belt_ros.settings import load_settings, read_parameters
from belt_ros.starter import QUESTIONS, answers_from, drive_yaml
from belt_ros.starter.asking import ask

FEW = {
    "driver_radius": 0.08,
    "driven_radius": 0.12,
    "centre_distance": 0.6,
    "belt": "polyamide-rubber",
    "size": 0.05,
    "driver_inertia": 0.02,
    "driven_inertia": 0.05,
}
LARGE = {"driver_radius": 0.2, "driven_radius": 0.3, "centre_distance": 2.0}


def loaded(text: str, tmp_path: Path):
    path = tmp_path / "drive.yaml"
    path.write_text(text, encoding="utf-8")
    return load_settings(path)


def line(text: str, name: str) -> str:
    (found,) = (one for one in text.splitlines() if one.strip().startswith(f"{name}:"))
    return found


@pytest.mark.parametrize("belt", BELTS)
def test_every_belt_gives_a_drive_that_check_is_content_with(belt, tmp_path):
    told = {**FEW, "belt": belt, "size": 0.01 if "round" in belt else 1.0}
    if belt.startswith("v-"):
        told |= {**LARGE, "size": 2}
    answers = answers_from(told)
    read = loaded(drive_yaml(answers), tmp_path)
    assert rate(read).capacity > 0.0


def test_wraps_and_spans_are_those_of_the_geometry(tmp_path):
    drive = loaded(drive_yaml(answers_from(FEW)), tmp_path).drive
    lean = math.asin((0.12 - 0.08) / 0.6)
    assert drive.driver.wrap_angle == pytest.approx(math.pi - 2 * lean, rel=1e-6)
    assert drive.driven.wrap_angle == pytest.approx(math.pi + 2 * lean, rel=1e-6)
    assert drive.span_length == pytest.approx(0.6 * math.cos(lean), rel=1e-6)


def test_a_crossed_belt_wraps_more_of_both_pulleys(tmp_path):
    drive = loaded(drive_yaml(answers_from({**FEW, "crossed": True})), tmp_path).drive
    more = math.pi + 2 * math.asin(0.2 / 0.6)
    assert drive.driver.wrap_angle == pytest.approx(more, rel=1e-6)
    assert drive.driven.wrap_angle == pytest.approx(more, rel=1e-6)


def test_what_was_told_stands_there_and_is_not_called_guessed(tmp_path):
    told = {
        **FEW,
        "tension": 500,
        "tension_tolerance": 80,
        "axial_stiffness": 60000,
        "mass_per_length": 0.12,
        "driver_joint": "elbow: motor",
        "driver_gear_ratio": 5,
        "driver_sign": -1,
        "driver_counts": 8192,
        "driven_counts": 131072,
        "torque": "current",
        "torque_constant": 0.35,
        "input": "joint_state",
        "tensioning": "constant_slack",
    }
    text = drive_yaml(answers_from(told))
    read = loaded(text, tmp_path)
    assert (read.prior.tension, read.prior.tension_stddev) == (500.0, 40.0)
    assert read.drive.belt.axial_stiffness == 60000.0
    assert (read.driver.name, read.driver.gear_ratio, read.driver.sign) == (
        "elbow: motor",
        5.0,
        -1.0,
    )
    assert read.driver.torque_scale == 0.35
    assert read.drive.tensioning.value == "constant_slack"
    coarser = 2 * math.pi / (8192 * 5)
    assert read.noise.position_quantum == pytest.approx(
        max(coarser, 2 * math.pi / 131072), rel=1e-6
    )
    for name in (
        "tension",
        "axial_stiffness",
        "mass_per_length",
        "torque_scale",
        "position_quantum",
    ):
        assert "guessed" not in line(text, name)
    for name in ("friction_stiffness", "friction_coefficient", "speed_absolute"):
        assert line(text, name).endswith("guessed")


def test_a_tension_that_nobody_knows_is_guessed_and_said_to_be(tmp_path):
    text = drive_yaml(answers_from(FEW))
    assert line(text, "tension").endswith("guessed")
    assert line(text, "tension_stddev").endswith("guessed")
    read = loaded(text, tmp_path)
    preset = BELTS["polyamide-rubber"].prior(0.05)
    assert read.prior.tension == pytest.approx(preset.tension, rel=1e-3)
    assert read.prior.tension_stddev == pytest.approx(preset.tension_stddev, rel=1e-3)


def test_a_mass_makes_a_disc_and_other_inputs_reach_the_node(tmp_path):
    without = {name: value for name, value in FEW.items() if name != "driven_inertia"}
    text = drive_yaml(answers_from({**without, "driven_mass": 2.0, "input": "pulley_state"}))
    assert loaded(text, tmp_path).drive.driven.inertia == pytest.approx(0.5 * 2.0 * 0.12**2)
    assert read_parameters(tmp_path / "drive.yaml")["input"] == "pulley_state"
    assert "joint:" not in text


def test_another_surface_on_the_driver_changes_its_friction(tmp_path):
    answers = answers_from({**FEW, "belt": "ep-conveyor", "size": 0.5, "driver_surface": "rubber"})
    drive = loaded(drive_yaml(answers), tmp_path).drive
    belt = BELTS["ep-conveyor"]
    ratio = drive.driver.friction_coefficient / drive.driven.friction_coefficient
    typical = [belt.friction_coefficient(on).typical for on in ("rubber", "steel")]
    assert ratio == pytest.approx(typical[0] / typical[1], rel=1e-3)
    assert drive.driver.friction_stiffness < drive.driven.friction_stiffness


def test_all_that_is_missing_is_named_at_once_by_its_flag():
    with pytest.raises(SettingsError) as caught:
        answers_from({"driver_radius": 0.1, "torque": "current"})
    for flag in ("--driven-radius", "--centre-distance", "--belt", "--size", "--torque-constant"):
        assert flag in str(caught.value)
    assert "--driver-radius" not in str(caught.value)
    assert "--driver-inertia or --driver-mass" in str(caught.value)


@pytest.mark.parametrize(
    ("wrong", "complaint"),
    [
        ({"driver_radius": -1}, "--driver-radius is -1 m; it must lie between 0.001 and 5 m"),
        ({"size": "wide"}, "--size is 'wide'; it must be a number"),
        ({"size": math.nan}, "--size is nan"),
        ({"belt": "htd 5m"}, "toothed belt"),
        ({"belt": "rope"}, "choose from"),
        ({"driver_sign": 0.5}, "--driver-sign is 0.5; it must be 1 or -1"),
        ({"tensioning": "firm"}, "--tensioning is 'firm'; it must be one of"),
        ({"name": "two\nlines"}, "must be a name"),
        ({"driver_mass": 3.0}, "not both"),
        (
            {"driver_joint": "a", "driven_joint": "a"},
            "--driven-joint is 'a', as that of the driver",
        ),
        ({"driven_joint": "driver_pulley_joint"}, "as that of the driver"),
        ({"driven_surface": "ceramic"}, "--driven-surface: no friction coefficient is known"),
        ({"driver_surface": "ceramic"}, "there are steel; or give --friction-coefficient"),
        ({"surface_state": "wet"}, "--surface-state: no friction coefficient is known"),
        ({"belt": "v-belt-spa", "size": 2, "driver_radius": 0.01}, "--belt: "),
        ({"colour": "red"}, "colour"),
    ],
)
def test_an_answer_that_cannot_be_is_refused_in_a_line(wrong, complaint):
    with pytest.raises(SettingsError) as caught:
        answers_from({**FEW, **wrong})
    assert complaint in str(caught.value)


PJ = {"belt": "v-ribbed-pj", "size": 6}
ROUND = {"belt": "polyurethane-round", "size": 0.006}


@pytest.mark.parametrize(
    ("wrong", "complaint"),
    [
        (
            {"driver_radius": 80},
            "--driver-radius is 80 m; it must lie between 0.001 and 5 m; 80 mm",
        ),
        ({"driven_radius": 120}, "are 0.12 m"),
        ({"centre_distance": 600}, "--centre-distance is 600 m; it must lie between 0.2 and 200 m"),
        ({"centre_distance": 600}, "600 mm are 0.6 m"),
        ({"centre_distance": 0.15}, "between 0.2 and 200 m"),
        (
            {"size": 25},
            "--size is 25 m of width; it must lie between 0.001 and 4; 25 mm are 0.025 m",
        ),
        ({"size": 1e-4}, "--size is 0.0001 m of width"),
        (
            {**ROUND, "size": 6},
            "--size is 6 m of diameter; it must lie between 0.001 and 0.1; 6 mm",
        ),
        ({**PJ, "size": 2.5}, "--size is 2.5 ribs; it must be a whole number from 1 to 200"),
        ({"belt": "v-belt-spa", "size": 0.5}, "--size is 0.5 belts; it must be a whole number"),
        ({"axial_stiffness": 40}, "--axial-stiffness is 40 N; 4e+04 N is typical"),
        ({"axial_stiffness": 4e7}, "of 0.05 m of width of polyamide-rubber, and it must"),
        ({"mass_per_length": 120}, "--mass-per-length is 120 kg/m; 0.12 kg/m is typical"),
        ({"tension": 0.8}, "--tension is 0.8 N; 800 N is typical"),
        ({**PJ, "tension": 1e5}, "--tension is 100000 N; 270 N is typical of 6 ribs"),
        ({"tension": 500, "tension_tolerance": 600}, "600 N; it must be no more than the tension"),
        ({"friction_coefficient": 40}, "--friction-coefficient is 40; it must lie between"),
        ({"driver_inertia": 1e8}, "--driver-inertia is 1e+08 kg m2; it must lie between"),
        ({"sample_rate": 1e7}, "--sample-rate is 1e+07 Hz; it must lie between"),
        ({"driver_counts": 0.5}, "--driver-counts is 0.5; it must lie between"),
    ],
)
def test_an_absurd_answer_is_refused_with_its_limit_and_what_to_do(wrong, complaint):
    """It is nearly always a number in another unit, which is a drive a thousand times off."""
    with pytest.raises(SettingsError) as caught:
        answers_from({**FEW, **wrong})
    assert complaint in str(caught.value)


@pytest.mark.parametrize("belt", BELTS)
def test_what_is_typical_of_a_belt_is_never_absurd(belt):
    size = {"m of width": 0.05, "m of diameter": 0.006}.get(BELTS[belt].size.value, 3)
    typical = BELTS[belt].belt(size)
    told = {"axial_stiffness": typical.axial_stiffness, "mass_per_length": typical.mass_per_length}
    tension = typical.axial_stiffness * BELTS[belt].installed_strain.typical
    for factor in (0.1, 1.0, 10.0):
        changed = {name: factor * value for name, value in told.items()}
        answers_from({**FEW, **LARGE, "belt": belt, "size": size, "tension": factor * tension})
        answers_from({**FEW, **LARGE, "belt": belt, "size": size, **changed})


@pytest.mark.parametrize(
    ("wrong", "complaint"),
    [
        ({"driven_surface": "ceramic"}, "no friction coefficient is known"),
    ],
)
def test_a_drive_that_cannot_be_is_refused_in_a_line(wrong, complaint):
    with pytest.raises(SettingsError) as caught:
        drive_yaml(answers_from({**FEW, **wrong}))
    assert complaint in str(caught.value)


@given(
    radii=st.tuples(st.floats(1e-3, 2.0), st.floats(1e-3, 2.0)),
    apart=st.floats(1.01, 50.0),
    size=st.floats(1e-3, 3.0),
    tension=st.none() | st.floats(0.02, 50.0),
    counts=st.none() | st.integers(1, 2**26),
    name=st.text(st.characters(exclude_categories=("Cs", "Cc")), min_size=1).filter(
        lambda text: text.strip() and text.isprintable()
    ),
)
@settings(
    derandomize=True,
    deadline=None,
    max_examples=60,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
def test_whatever_is_written_is_read_back_or_refused(
    radii, apart, size, tension, counts, name, tmp_path
):
    given_ = {
        **FEW,
        "driver_radius": radii[0],
        "driven_radius": radii[1],
        "centre_distance": apart * sum(radii),
        "size": size,
        "tension": tension and tension * BELTS[FEW["belt"]].prior(size).tension,
        "driver_counts": counts,
        "name": name,
    }
    try:
        text = drive_yaml(answers_from(given_))
    except SettingsError:
        assume(False)
    read = loaded(text, tmp_path)
    assert read.name == name.strip()
    assert read.drive.driver.radius == pytest.approx(radii[0], rel=1e-6)
    assert rate(read).capacity > 0.0


def test_a_friction_that_is_told_needs_no_surface_that_is_known(tmp_path):
    told = {**FEW, "driven_surface": "ceramic", "friction_coefficient": 0.4}
    assert loaded(drive_yaml(answers_from(told)), tmp_path).prior.friction_coefficient == 0.4


def test_every_question_has_words_and_every_number_its_range():
    assert all(question.text for question in QUESTIONS.values())
    numbers = [one for one in QUESTIONS.values() if one.number and not one.signed]
    assert all(0.0 < low < high < math.inf for low, high in (one.between for one in numbers))
    assert {one.name for one in QUESTIONS.values() if one.needed} == set(FEW)


def test_on_a_terminal_a_wrong_answer_is_asked_for_again(monkeypatch, tmp_path):
    replies = {
        "radius of the driver,": ["minus one", "0.08"],
        "radius of the driven": ["0.12"],
        "distance of the shafts": ["600", "0.6"],
        "belt, as": ["?", "rope", "v-belt-spc", "polyamide-rubber"],
        "size of the belt": ["50", "0.05"],
        "inertia of all that turns with the driver,": ["0.02"],
        "what the belt runs on": ["ceramic", "steel"],
        "state of these": ["wet", "dry"],
        "inertia of all that turns with the driven": ["0.05"],
        "joint of the driven": ["driver_pulley_joint", "driven_pulley_joint"],
    }
    asked = []

    def reply(self, prompt="", **_):
        text = prompt.plain
        asked.append(text)
        for begin, answers in replies.items():
            if text.startswith(begin):
                return answers.pop(0)
        return ""

    monkeypatch.setattr(Console, "input", reply)
    said = io.StringIO()
    answers = ask({"name": "mine"}, Console(file=said, force_terminal=True, width=200))
    assert not any(replies.values())
    assert answers.name == "mine"
    assert not any("name of the drive" in text for text in asked)
    assert "it must be a number" in said.getvalue()
    assert "600 mm are 0.6 m" in said.getvalue()
    assert "50 mm are 0.05 m" in said.getvalue()
    assert "polyester-flat" in said.getvalue()
    assert loaded(drive_yaml(answers), tmp_path).drive.driver.radius == 0.08
    assert yaml.safe_load(drive_yaml(answers)) == yaml.safe_load(
        drive_yaml(answers_from({**FEW, "name": "mine"}))
    )
