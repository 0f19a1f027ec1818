"""Time and memory of replaying bags, as rows of figures."""

import gc
import resource
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from statistics import median
from typing import NamedTuple

from rosbags.highlevel import AnyReader

from belt_ros.estimation import Measurement, MonitorOutput
from belt_ros.fleet import run_fleet
from belt_ros.replay import replay
from belt_ros.replay.drive_bag import DriveBag
from belt_ros.settings import load_settings
from benchmarks.estimation.judged import SOURCES
from benchmarks.fleet.bags import make_bag
from benchmarks.replay.playback import played_back

CONFIG = Path(__file__).resolve().parents[2] / "config" / "paper_drive.yaml"
RATES = (100.0, 1000.0)
BAGS = 10
LONGER = 10
READING = "the bag alone, by rosbags"
PLAIN, SMOOTHED = "all, --no-smooth", "all"
PARTS = ("bag to measurements", "BeltMonitor.step", "results and summary", "smoothing")
ONE, TWO, START = "one core", "two cores", "two cores, two bags of ten samples"
SHORT, LONG = "short bag", f"{LONGER} times as long"
_FEW = 10  # samples
_WARM = 2000  # samples
_MEMORY_RATE = 1000.0


class Figure(NamedTuple):
    """What something took, in the unit of its case."""

    case: str
    what: str
    value: float
    sources: str = SOURCES


def speed_case(rate: float) -> str:
    """Name a bag of samples at some rate [Hz]; its unit is us of processor time for a sample."""
    return f"{rate:g} Hz [us/sample]"


CORES, MEMORY = f"{BAGS} bags [s]", "peak memory [MB]"


def speed(place: Path, count: int, turns: int) -> Iterator[Figure]:
    """Processor time of all that a replay consists of, medians of some turns."""
    replay(make_bag(place / "warm", RATES[0], _WARM), load_settings(CONFIG), place / "warm_out")
    for rate in RATES:
        bag = make_bag(place / f"bag{rate:g}", rate, count)
        took: dict[str, list[float]] = {}
        for turn in range(turns):
            for what, seconds in _turn(bag, place / f"out{rate:g}_{turn}"):
                took.setdefault(what, []).append(seconds / count * 1e6)
        for what, all_turns in took.items():
            yield Figure(speed_case(rate), what, median(all_turns))


def _turn(bag: Path, out: Path) -> Iterator[tuple[str, float]]:
    """Time everything once [s]; what cannot be timed by itself is a difference."""
    settings, monitor = load_settings(CONFIG), load_settings(CONFIG).monitor()
    samples: list[Measurement] = []
    outputs: list[MonitorOutput] = []

    def read() -> None:
        with DriveBag(bag, settings) as source:
            for sample in source.samples():
                assert isinstance(sample.content, Measurement)
                samples.append(sample.content)

    def step() -> None:
        outputs.extend(map(monitor.step, samples))

    yield READING, _processor_time(lambda: _read_alone(bag))
    reading, stepping = _processor_time(read), _processor_time(step)
    played = played_back(settings, monitor, outputs)
    gc.collect()
    gc.freeze()  # what is kept here would be gone through again and again, which no replay does
    around = _processor_time(lambda: replay(bag, played, out / "played", smooth=False))
    gc.unfreeze()
    samples.clear()
    outputs.clear()
    plain = _processor_time(lambda: replay(bag, settings, out / "plain", smooth=False))
    smoothed = _processor_time(lambda: replay(bag, settings, out / "smoothed"))
    parts = reading, stepping, around - reading, smoothed - plain
    yield from zip((*PARTS, PLAIN, SMOOTHED), (*parts, plain, smoothed), strict=True)


def _read_alone(bag: Path) -> None:
    with AnyReader([bag]) as reader:
        for connection, _, data in reader.messages():
            reader.deserialize(data, connection.msgtype)


def _processor_time(work: Callable[[], object]) -> float:
    began = time.process_time()
    work()
    return time.process_time() - began


def cores(place: Path, count: int) -> Iterator[Figure]:
    """Wall time of a fleet of equal bags on one core and on two, start of the workers included."""
    for number in range(BAGS):
        make_bag(place / "bags" / f"bag{number}", RATES[-1], count, number)
    few = [make_bag(place / "few" / f"bag{n}", RATES[-1], _FEW, n) for n in range(2)]
    run_fleet(few, CONFIG, place / "compiled", workers=1)
    for what, bags, workers in (
        (START, few, 2),
        (ONE, [place / "bags"], 1),
        (TWO, [place / "bags"], 2),
    ):
        began = time.perf_counter()
        result = run_fleet(bags, CONFIG, place / what, workers=workers)
        yield Figure(CORES, what, time.perf_counter() - began)
        if result.failed:
            raise RuntimeError(result.rows[0].error)


def memory(place: Path, count: int) -> Iterator[Figure]:
    """Peak memory of a process that replays a bag, and of one whose bag is longer."""
    for what, length in ((SHORT, count), (LONG, LONGER * count)):
        bag = make_bag(place / f"bag{length}", _MEMORY_RATE, length)
        code = "from benchmarks.replay.measure import print_peak; print_peak()"
        arguments = [sys.executable, "-c", code, str(bag), str(place / f"out{length}")]
        done = subprocess.run(arguments, stdout=subprocess.PIPE, text=True, check=True)
        yield Figure(MEMORY, what, float(done.stdout))


def print_peak() -> None:
    """Replay the bag of the first argument; print the process's peak memory [MB]."""
    replay(sys.argv[1], load_settings(CONFIG), sys.argv[2])
    print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)
