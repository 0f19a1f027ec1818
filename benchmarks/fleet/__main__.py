"""Measure it: `python -m benchmarks.fleet speed|cores|memory|crash`."""

import argparse
import os
import resource
import signal
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

from belt_ros.fleet import run_fleet
from belt_ros.replay import replay
from belt_ros.replay.drive_bag import DriveBag
from belt_ros.settings import load_settings
from benchmarks.fleet.bags import START_NS, make_bag

CONFIG = Path(__file__).resolve().parents[2] / "config" / "paper_drive.yaml"
_MONTH_NS = 30 * 86_400 * 1_000_000_000


def speed(place: Path, count: int) -> None:
    """Samples a second of one core: reading alone, filter, filter and smoother."""
    settings = load_settings(CONFIG)
    replay(make_bag(place / "warm", 100.0, 50), settings, place / "warm_out")
    for rate in (100.0, 1000.0):
        bag = make_bag(place / f"bag{rate:g}", rate, count)
        began = time.process_time()
        with DriveBag(bag, settings) as source:
            read = sum(1 for _ in source.samples())
        reading = time.process_time() - began
        for smooth in (False, True):
            began = time.process_time()
            replay(bag, settings, place / f"out{rate:g}{smooth}", smooth=smooth)
            took = time.process_time() - began
            print(
                f"{rate:g} Hz, smoothing {smooth}: {read / took:.0f} samples/s of CPU, "
                f"{took / reading:.1f} times reading alone ({read / reading:.0f}/s)"
            )


def cores(place: Path, count: int) -> None:
    """Ten bags on two cores against one."""
    for number in range(10):
        make_bag(place / "bags" / f"bag{number}", 100.0, count, number)
    took = {}
    for workers in (1, 2):
        began = time.perf_counter()
        run_fleet([place / "bags"], CONFIG, place / f"out{workers}", workers=workers)
        took[workers] = time.perf_counter() - began
    print(f"ten bags: {took[1]:.1f} s, {took[2]:.1f} s; {took[1] / took[2]:.2f} times as fast")


def memory(place: Path, count: int) -> None:
    """Peak memory of a bag, and of one ten times as long."""
    for length in (count, 10 * count):
        bag = make_bag(place / f"bag{length}", 1000.0, length)
        code = "from benchmarks.fleet.__main__ import peak; peak()"
        arguments = [sys.executable, "-c", code, str(bag), str(place / f"out{length}")]
        done = subprocess.run(arguments, capture_output=True, text=True, check=True)
        print(f"{length} messages: {done.stdout.strip()} MB at most")


def peak() -> None:
    """Replay one bag and print the process's peak memory [MB]."""
    replay(sys.argv[1], load_settings(CONFIG), sys.argv[2])
    print(round(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024))


def crash(place: Path, count: int) -> None:
    """Two hundred small bags, five of them damaged, one bag's worker killed twice."""
    del count
    folder, out = place / "bags", place / "out"
    for number in range(195):
        make_bag(folder / f"bag{number:03d}", 100.0, 30, number, START_NS + number * _MONTH_NS // 8)
    for number in range(5):
        (folder / f"damaged{number}.mcap").write_bytes(b"\x89MCAP0\r\n" + bytes(50 + number))
    killed: list[int] = []
    threading.Thread(target=_kill_twice, args=(out / "bags", killed), daemon=True).start()
    result = run_fleet([folder], CONFIG, out, workers=2, smooth=False)
    good = sum(not row.error for row in result.rows)
    print(f"{len(killed)} workers killed; {good} results, {result.failed} errors")
    print(f"records: {len(list((out / 'bags').glob('*/record.json')))}")
    again = run_fleet([folder], CONFIG, out, workers=2, smooth=False)
    print(f"run again: {again.done} done, {again.skipped} skipped")


def _kill_twice(folder: Path, killed: list[int]) -> None:
    victim = None
    while len(killed) < 2:
        time.sleep(0.002)
        for part in folder.glob(".*.part"):
            name, pid, *_ = part.name.removeprefix(".").rsplit(".", 3)
            if victim in (None, name) and int(pid) not in killed:
                victim = name
                os.kill(int(pid), signal.SIGKILL)
                killed.append(int(pid))
                break


def main() -> None:
    """Run one of them."""
    kinds = {"speed": speed, "cores": cores, "memory": memory, "crash": crash}
    parser = argparse.ArgumentParser(prog="python -m benchmarks.fleet")
    parser.add_argument("what", choices=kinds)
    parser.add_argument("--count", type=int, default=10_000, help="messages in a bag")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as place:
        kinds[arguments.what](Path(place), arguments.count)


if __name__ == "__main__":
    main()
