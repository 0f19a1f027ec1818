"""Two hundred bags, of which some are damaged and one has its worker killed, all accounted for.

Speed and memory are measured by `benchmarks.replay`.
"""

import os
import signal
import tempfile
import threading
import time
from pathlib import Path

from belt_ros.fleet import run_fleet
from benchmarks.fleet.bags import START_NS, make_bag

CONFIG = Path(__file__).resolve().parents[2] / "config" / "paper_drive.yaml"
_MONTH_NS = 30 * 86_400 * 1_000_000_000


def crash(place: Path) -> None:
    """Two hundred small bags, five of them damaged, one bag's worker killed twice."""
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
    """Run it in a folder of its own."""
    with tempfile.TemporaryDirectory() as place:
        crash(Path(place))


if __name__ == "__main__":
    main()
