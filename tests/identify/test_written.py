"""The YAML with what was identified: the rest of it stays to the letter."""

import textwrap

import pytest
from steady import CONFIG, Belt, run

from belt_ros.identify import identify_measurements, with_identified
from belt_ros.identify.written import write_identified
from belt_ros.parameter_table import SettingsError
from belt_ros.settings import load_settings, read_parameters

TRUE = Belt(440.0, 6e6, 1.18, 3e-4, 0.01)
CHANGED = {
    "prior.tension",
    "prior.tension_stddev",
    "prior.friction_stiffness",
    "prior.friction_stiffness_decades",
    "prior.ratio_bias_stddev",
    "driven.radius",
}


@pytest.fixture(scope="module")
def said(soft):
    return identify_measurements(run(soft, TRUE, [0.0, 15.0, 30.0, 45.0, 58.0]), soft, bag="my_bag")


def test_only_what_the_data_tell_is_replaced_and_comments_stay(said, soft, tmp_path):
    path = CONFIG / "demo_drive.yaml"
    write_identified(path, tmp_path / "new.yaml", said, soft)
    before, after = read_parameters(path), read_parameters(tmp_path / "new.yaml")
    different = {name for name in after if after[name] != before.get(name)}
    assert different == CHANGED
    read = load_settings(tmp_path / "new.yaml")
    assert read.prior.friction_stiffness == pytest.approx(said.friction_stiffness.median, rel=1e-6)
    assert read.drive.driven.radius == pytest.approx(0.08125 * (1.0 + said.ratio_bias.median))
    lines = (tmp_path / "new.yaml").read_text().splitlines()
    kept = [line for line in path.read_text().splitlines() if ":" not in line or "noise" in line]
    assert set(kept) <= set(lines)
    for line in path.read_text().splitlines():
        _, mark, comment = line.partition("# ")
        assert not mark or any(one.endswith(comment) for one in lines)
    assert "from my_bag, recorded 2025-06-15" in lines[0]
    assert any("friction_coefficient" in line and "left as it was" in line for line in lines)


def test_what_is_not_accepted_when_it_is_read_back_is_not_there(said, soft, tmp_path, monkeypatch):
    def refuse(*_arguments, **_options):
        raise SettingsError("no")

    path, out = CONFIG / "demo_drive.yaml", tmp_path / "new" / "found.yaml"
    with monkeypatch.context() as changed:
        changed.setattr("belt_ros.identify.written.load_settings", refuse)
        with pytest.raises(SettingsError):
            write_identified(path, out, said, soft)
    assert not out.exists()
    write_identified(path, out, said, soft)
    assert [found.name for found in out.parent.iterdir()] == ["found.yaml"]


def test_a_drive_that_starts_from_it_believes_it(said, soft, tmp_path):
    write_identified(CONFIG / "demo_drive.yaml", tmp_path / "new.yaml", said, soft)
    again = load_settings(tmp_path / "new.yaml")
    more = identify_measurements(run(soft, TRUE, [0.0, 15.0, 30.0], seed=9), again)
    assert more.goodness.probability > 0.01
    assert more.friction_stiffness.low < 6e6 < more.friction_stiffness.high


def test_of_several_drives_the_one_named_is_changed(said, tmp_path):
    path = CONFIG / "several_drives.yaml"
    for drive in ("infeed", "lift"):
        settings = load_settings(path, drive=drive)
        out = tmp_path / f"{drive}.yaml"
        write_identified(path, out, said, settings, drive)
        before, after = read_parameters(path), read_parameters(out)
        different = {name for name in after if after[name] != before.get(name)}
        assert different == {f"{drive}.{name}" for name in CHANGED}
        assert load_settings(out, drive=drive).prior.tension == pytest.approx(said.tension.mean)
        other = "lift" if drive == "infeed" else "infeed"
        assert load_settings(out, drive=other) == load_settings(path, drive=other)


@pytest.mark.parametrize(
    "prior",
    [
        "prior: {tension: 420, tension_stddev: 80}  # flow",
        "prior.tension: 420.0\nprior.tension_stddev: 80.0",
        "prior:\n  # a remark\n  tension_stddev: 80.0\n  tension: 420.0 # N",
        "# no prior at all",
    ],
)
def test_any_way_of_writing_it_is_edited_in_place(said, soft, tmp_path, prior):
    text = textwrap.dedent(
        """\
        belt: {axial_stiffness: 80068.0, mass_per_length: 0.1036}
        driver: {radius: 0.08125, wrap_angle: 3.14159265, inertia: 0.05}
        driven: {radius: 0.08125, wrap_angle: 3.14159265, inertia: 0.05}
        span_length: 0.5105
        """
    )
    path = tmp_path / "drive.yaml"
    path.write_text(text + prior + "\n")
    edited = with_identified(path, said, soft)
    (tmp_path / "new.yaml").write_text(edited)
    read = load_settings(tmp_path / "new.yaml")
    assert read.prior.tension == pytest.approx(said.tension.mean, rel=1e-6)
    assert read.prior.tension_stddev == pytest.approx(said.tension.stddev, rel=1e-6)
    for remark in ("# flow", "# a remark", "# no prior at all"):
        assert (remark in edited) == (remark in prior)


def test_a_file_with_anchors_is_refused_rather_than_broken(said, soft, tmp_path):
    path = tmp_path / "drive.yaml"
    path.write_text(
        "belt: {axial_stiffness: 80068.0}\n"
        "driver: &pulley {radius: 0.08125, wrap_angle: 3.14159265, inertia: 0.05}\n"
        "driven: *pulley\n"
        "span_length: 0.5105\n"
    )
    with pytest.raises(SettingsError, match=r"pulley in line 3: .*write out what it means"):
        with_identified(path, said, soft)
