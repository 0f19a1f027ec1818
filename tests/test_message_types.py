"""The definitions of belt_msgs: where they are found, and that bags hold what ROS sends."""

import dataclasses
from pathlib import Path

import pytest

from belt_ros import message_types
from belt_ros.estimation import BeltEstimate, Health, Quantity, Rejection
from belt_ros.estimation.estimate import Consistency, Fit, LostTraction, Reserve
from belt_ros.message_fields import state_fields
from belt_ros.message_types import belt_typestore, message_texts

MESSAGES = Path(__file__).parents[1] / "msg_defs" / "msg"
NAMES = sorted(file.stem for file in MESSAGES.glob("*.msg"))


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An installed package without a checkout around it, and no ROS."""
    package = tmp_path / "site-packages" / "belt_ros"
    package.mkdir(parents=True)
    monkeypatch.setattr(message_types, "_PACKAGE", package)
    monkeypatch.delenv("AMENT_PREFIX_PATH", raising=False)
    return package


def define(place: Path, text: str) -> None:
    place.mkdir(parents=True)
    (place / "BeltState.msg").write_text(text)


def test_checkout_holds_all_of_them() -> None:
    texts = message_texts()

    assert list(texts) == [f"belt_msgs/msg/{name}" for name in NAMES]
    assert texts["belt_msgs/msg/BeltState"] == (MESSAGES / "BeltState.msg").read_text()


def test_those_of_the_package_come_before_those_of_a_workspace(
    installed: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    workspace = tmp_path / "workspace"
    define(workspace / "share" / "belt_msgs" / "msg", "bool of_workspace\n")
    monkeypatch.setenv("AMENT_PREFIX_PATH", f"{tmp_path / 'empty'}::{workspace}")
    assert message_texts() == {"belt_msgs/msg/BeltState": "bool of_workspace\n"}

    define(installed / "message_texts", "bool of_package\n")
    assert message_texts() == {"belt_msgs/msg/BeltState": "bool of_package\n"}


def test_where_they_were_looked_for_is_said(installed: Path) -> None:
    with pytest.raises(FileNotFoundError, match="install belt_ros anew") as caught:
        message_texts()

    assert str(installed / "message_texts") in str(caught.value)


@pytest.mark.parametrize("name", NAMES)
def test_types_are_those_that_ros_has_compiled(name: str) -> None:
    messages = pytest.importorskip("belt_msgs.msg", reason="belt_msgs is not built")
    compiled = getattr(messages, name)
    read = belt_typestore().types[f"belt_msgs/msg/{name}"]

    fields = compiled.get_fields_and_field_types()
    constants = type(compiled).__prepare__(name, ())

    assert list(read.__dataclass_fields__)[: len(fields)] == list(fields)
    assert {key: getattr(read, key) for key in constants} == constants


def test_an_estimate_fills_every_field_of_the_state() -> None:
    health = Health(1.0, 4, 10, 0, Rejection.NONE, (0,) * len(Rejection))
    told = {
        field.name: Quantity(1.0, 0.1) if field.type is Quantity else 0
        for field in dataclasses.fields(BeltEstimate)
    }
    estimate = BeltEstimate(
        **told
        | {
            "health": dataclasses.replace(health, fit=Fit(Consistency.CONSISTENT, 1.1, 0.4, 1.25)),
            "reserve": Reserve(Quantity(60.0, 4.0), 0.02),
            "lost_traction": LostTraction(0.9, 0.7, 0.1),
        }
    )
    fields = state_fields("a_drive", estimate)

    state = belt_typestore().types["belt_msgs/msg/BeltState"]
    names = [
        name
        for name, field in state.__dataclass_fields__.items()
        if "ClassVar" not in str(field.type)
    ]
    assert sorted(fields) == sorted(set(names) - {"header"})
    expected = {
        "capacity_torque": 60.0,
        "capacity_torque_stddev": 4.0,
        "gross_slip_probability_at_peak_load": 0.02,
        "traction_lost_probability": 0.9,
        "tension_lost_probability": 0.7,
        "friction_lost_probability": 0.1,
        "fit": 1,
        "fit_mean": 1.1,
        "fit_lowest": 0.4,
        "fit_highest": 1.25,
    }
    assert {name: fields[name] for name in expected} == expected
