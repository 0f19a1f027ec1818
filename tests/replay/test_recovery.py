import pytest
from bags import chunk_ends, steady_run, write_chunked_mcap
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st
from mcap.writer import CompressionType
from reading import expected, read

from belt_ros.replay import BagError
from belt_ros.replay.drive_bag import DriveBag

SAMPLES = steady_run(60)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    return write_chunked_mcap(tmp_path_factory.mktemp("whole") / "bag.mcap", SAMPLES)


def cut(whole, place, tmp_path):
    path = tmp_path / "cut.mcap"
    path.write_bytes(whole.read_bytes()[:place])
    return path


def test_every_whole_chunk_is_recovered(settings, whole, tmp_path):
    ends = chunk_ends(whole)
    left = [len(read(cut(whole, end, tmp_path), settings)) for end in ends]
    assert left[-1] == len(SAMPLES)
    for before, count, end in zip(left, left[1:], ends[1:], strict=False):
        assert before < count
        assert read(cut(whole, end - 1, tmp_path), settings) == expected(SAMPLES[:before])


def test_the_loss_is_said(settings, whole, tmp_path):
    end = chunk_ends(whole)[2]
    with DriveBag(cut(whole, end + 100, tmp_path), settings) as bag:
        assert f"{bag.count} messages recovered, the last " in bag.note
        assert bag.count == len(list(bag.samples()))
        assert bag.topics == ("/joint_states",)


@hypothesis_settings(max_examples=60, deadline=None)
@given(share=st.floats(0.0, 1.0))
def test_wherever_it_is_cut_a_beginning_is_left_or_an_error_says_so(
    settings, whole, tmp_path_factory, share
):
    place = int(share * whole.stat().st_size)
    path = cut(whole, place, tmp_path_factory.getbasetemp())
    if place >= chunk_ends(whole)[0]:
        samples = read(path, settings)
        assert samples == expected(SAMPLES[: len(samples)])
        assert samples
    else:
        with pytest.raises(BagError, match=r"cut\.mcap"):
            read(path, settings)


@pytest.mark.parametrize(
    "options",
    [
        {"compression": CompressionType.NONE},
        {"compression": CompressionType.LZ4},
        {"use_chunking": False},
    ],
    ids=["uncompressed", "lz4", "no chunks"],
)
def test_other_layouts_are_recovered(settings, tmp_path, options):
    path = write_chunked_mcap(tmp_path / "bag.mcap", SAMPLES, **options)
    samples = read(cut(path, path.stat().st_size // 2, tmp_path), settings)
    assert 10 < len(samples) < len(SAMPLES)
    assert samples == expected(SAMPLES[: len(samples)])


def test_a_chunk_of_wrong_checksum_is_left_out(settings, whole, tmp_path):
    _, second, third, *_, last = chunk_ends(whole)
    content = bytearray(whole.read_bytes()[:last])
    content[(second + third) // 2] ^= 0xFF
    path = tmp_path / "bag.mcap"
    path.write_bytes(content)
    with DriveBag(path, settings) as bag:
        samples = list(bag.samples())
        assert "1 chunk" in bag.note
    assert 0 < len(samples) < len(SAMPLES)
    assert set(samples) < set(expected(SAMPLES))


def test_a_recorder_that_lost_power_leaves_a_readable_directory(settings, tmp_path):
    bag = tmp_path / "bag"
    bag.mkdir()
    for number, part in enumerate((SAMPLES[:20], SAMPLES[20:40], SAMPLES[40:])):
        write_chunked_mcap(bag / f"bag_{number}.mcap", part)
    last = bag / "bag_2.mcap"
    last.write_bytes(last.read_bytes()[: chunk_ends(last)[0]])
    (bag / "bag_10.mcap").touch()
    with DriveBag(bag, settings) as it:
        samples = list(it.samples())
        assert "bag_2.mcap is damaged" in it.note
        assert "Nothing can be read of bag_10.mcap" in it.note
    assert samples == expected(SAMPLES[: len(samples)])
    assert len(samples) > 40
