"""Several drives of the rig: told apart by a file, or many alike; faults of one and of all."""

import itertools
import math
from pathlib import Path

import pytest

from belt_ros.parameter_table import SettingsError
from belt_ros.rig import measured, simulate
from belt_ros.rig.entries import ScenarioError
from belt_ros.rig.fleet import Fleet, Instant, RigPlant, load_fleet
from belt_ros.rig.readings import PulleyReading, Rates
from belt_ros.rig.scenario import scenario_from_mapping
from belt_ros.settings import DriveSettings

ALL = Rates(100.0, 100.0)
START_NS = 10**18
SCRIPT: dict[str, object] = {"duration": 0.3, "speed": 100.0, "load": 20.0, "seed": 3}


@pytest.fixture
def scenario_file(tmp_path: Path) -> Path:
    path = tmp_path / "scenario.yaml"
    path.write_text("{duration: 0.3, speed: 100.0, load: 20.0, seed: 3}")
    return path


@pytest.fixture
def many(root: Path, scenario_file: Path) -> Fleet:
    return load_fleet(root / "config" / "paper_drive.yaml", scenario_file, 3)


@pytest.fixture
def several(root: Path, scenario_file: Path) -> Fleet:
    return load_fleet(root / "config" / "several_drives.yaml", scenario_file)


def of(instants: list[tuple[Instant, ...]], drive: str, pulley: str) -> list[PulleyReading]:
    return [
        reading
        for each in instants
        for instant in each
        for reading in instant.readings
        if (reading.drive, reading.pulley) == (drive, pulley)
    ]


def test_one_drive_says_what_a_run_offline_says(settings: DriveSettings) -> None:
    scenario = scenario_from_mapping(SCRIPT, settings)
    plant = RigPlant(settings, scenario)

    for sample, instant in zip(
        simulate(settings, scenario, START_NS), plant.play(START_NS, ALL), strict=True
    ):
        driver, driven = instant.readings
        assert instant.truth == sample.truth
        assert (driver.stamp_ns, driven.stamp_ns) == (sample.stamp_ns, sample.stamp_ns)
        assert (driver.joint, driven.joint) == sample.joints.names
        assert (driver.position, driven.position) == sample.joints.positions
        assert (driver.speed, driven.speed) == sample.joints.velocities
        assert (driver.torque, driven.torque) == sample.joints.efforts


def test_its_load_sensors_say_what_they_say_offline(settings: DriveSettings) -> None:
    scenario = scenario_from_mapping(SCRIPT, settings)
    plant = RigPlant(settings, scenario, loads=True)

    for (measurement, _), instant in zip(
        measured(settings, scenario, loads=True), plant.play(0, ALL), strict=True
    ):
        driver, driven = instant.readings
        said = (driver.hub_load, driven.hub_load, driven.span_tension)
        assert said == measurement.loads


def test_a_load_that_comes_late_is_that_of_its_stamp(settings: DriveSettings) -> None:
    late = [{"at": 0.0, "kind": "delayed", "value": 0.05}]
    scenario = scenario_from_mapping({**SCRIPT, "faults": late}, settings)
    plain = scenario_from_mapping(SCRIPT, settings)
    in_time = {
        reading.stamp_ns: reading.hub_load
        for instant in RigPlant(settings, plain, loads=True).play(0, ALL)
        for reading in instant.readings
        if reading.pulley == "driver"
    }

    for instant in RigPlant(settings, scenario, loads=True).play(0, ALL):
        for reading in instant.readings:
            if reading.pulley == "driver":
                assert reading.stamp_ns == instant.stamp_ns - 50_000_000
                assert reading.hub_load == in_time[reading.stamp_ns]


def test_each_pulley_is_read_at_its_own_rate(settings: DriveSettings) -> None:
    plant = RigPlant(settings, scenario_from_mapping(SCRIPT, settings))
    instants = [(instant,) for instant in plant.play(START_NS, Rates(100.0, 20.0))]

    assert len(of(instants, settings.name, "driver")) == 31
    driven = of(instants, settings.name, "driven")
    assert {b.stamp_ns - a.stamp_ns for a, b in itertools.pairwise(driven)} == {50_000_000}


def test_a_file_of_several_drives_gives_each_a_plant_and_noise_of_its_own(several: Fleet) -> None:
    assert several.names == ("infeed", "outfeed", "lift")
    assert len(set(several.joints.values())) == 6
    instants = list(several.play(START_NS, ALL))

    tensions = [round(instant.truth.mean_tension) for instant in instants[0]]
    assert tensions == [420, 420, 600]
    infeed, outfeed = (
        [r.speed for r in of(instants, name, "driven")] for name in several.names[:2]
    )
    assert sum(one == other for one, other in zip(infeed, outfeed, strict=True)) < 10


def test_many_alike_share_plant_and_noise(many: Fleet) -> None:
    assert many.names == ("drive_1", "drive_2", "drive_3")
    instants = list(many.play(START_NS, ALL))

    first, *others = ([r.speed for r in of(instants, name, "driven")] for name in many.names)
    assert others == [first, first]


def test_a_fault_of_one_drive_leaves_the_others_alone(many: Fleet, several: Fleet) -> None:
    for fleet in (many, several):
        chosen = fleet.names[1]
        fleet.request(f"wrong_sign driven_speed drive={chosen}")
        instants = list(fleet.play(START_NS, ALL))
        for name in fleet.names:
            negative = [reading.speed < 0.0 for reading in of(instants, name, "driven")]
            assert negative == [name == chosen] * 31


def test_a_fault_without_a_name_is_of_all_drives_and_ends_for_all(many: Fleet) -> None:
    many.request("dropout driver_torque")
    run = many.play(START_NS, ALL)
    before = list(itertools.islice(run, 10))
    assert many.clear() == ("dropout driver_torque",)
    after = list(run)

    for name in many.names:
        assert all(math.isnan(reading.torque) for reading in of(before, name, "driver"))
        assert not any(math.isnan(reading.torque) for reading in of(after, name, "driver"))


def test_the_belt_of_one_drive_can_lose_its_tension(several: Fleet) -> None:
    several.request("drive=outfeed tension=300")
    first = next(several.play(START_NS, ALL))

    assert [round(instant.truth.mean_tension) for instant in first] == [420, 300, 600]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("tension=300 drive=drive_2", "drive_2 shares its plant with 2 others"),
        ("stuck driven_speed drive=drive_9", "drive is drive_9; it must be one of drive_1, drive"),
        ("stuck drive=drive_1 drive=drive_2", "drive is drive_1, drive_2; it must be one of"),
        ("stuck motor drive=drive_1", "sensor is 'motor'"),
    ],
)
def test_what_cannot_be_is_refused(many: Fleet, text: str, words: str) -> None:
    with pytest.raises(ScenarioError, match=words):
        many.request(text)
    assert many.clear() == ()


def test_a_number_of_drives_for_a_file_of_several_is_refused(
    root: Path, scenario_file: Path
) -> None:
    with pytest.raises(SettingsError, match=r"drives is 5, but .* names 3 itself"):
        load_fleet(root / "config" / "several_drives.yaml", scenario_file, 5)
