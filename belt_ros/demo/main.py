"""Run the demonstration: start the processes, show the table, record, judge and draw."""

import shutil
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import rclpy
from rclpy.executors import ExternalShutdownException
from rich.console import Console
from rich.live import Live

from belt_ros.demo.client import ALARM, JOINTS, STATE, TRUTH, Client
from belt_ros.demo.player import Player
from belt_ros.demo.plot import draw
from belt_ros.demo.processes import Process
from belt_ros.demo.table import live_table, plain_line
from belt_ros.demo.verdict import Verdict, judge, judge_bag
from belt_ros.parameter_table import SettingsError
from belt_ros.replay import BagError
from belt_ros.settings import DriveSettings, load_settings

OUTPUT = Path("belt_demo")
_MARK = "node.log"  # by which a demonstration's directory is known, from its beginning on
_START_PATIENCE = 120.0  # [s]: the first run of all compiles
_LISTENERS = 2  # to joint states: the node, and the recorder here
_LISTENER_PATIENCE = 20.0  # [s]
_REFRESH = 0.2  # [s]
_LINE_EVERY = 2.0  # [s]
_DRAIN = 1.0  # [s] for the last messages
_SECONDS = 1e-9


class DemoError(RuntimeError):
    """The demonstration cannot go on; the message says why."""


def configuration(name: str) -> Path:
    """Return an example configuration, from the checkout or the installed share directory.

    Raises
    ------
    DemoError
        If it is in neither.
    """
    checkout = Path(__file__).resolve().parents[2] / "config" / name
    if checkout.is_file():
        return checkout
    from ament_index_python.packages import (  # noqa: PLC0415 - only where ROS installed us
        get_package_share_directory,
    )

    installed = Path(get_package_share_directory("belt_ros")) / "config" / name
    if not installed.is_file():
        raise DemoError(f"no config/{name} beside the package or in {installed.parent}")
    return installed


def run(bag: Path | None = None, config: Path | None = None, output: Path = OUTPUT) -> int:
    """Show the estimator at work, on the virtual rig or on a bag.

    Parameters
    ----------
    bag : Path, optional
        A bag with joint states to be played instead of the rig; needs `config`.
    config : Path, optional
        The drive's YAML.
    output : Path
        Directory for the recorded bag, the plot and the logs; replaced if it is there.

    Returns
    -------
    int
        0 if the verdict is good.
    """
    console = Console()
    try:
        verdict = _run(bag, config, output, console)
    except (DemoError, SettingsError, BagError) as error:
        console.print(error, style="red", highlight=False)
        return 1
    except (KeyboardInterrupt, ExternalShutdownException):
        console.print("interrupted")
        return 130
    return _conclude(verdict, output, console)


def _run(bag: Path | None, config: Path | None, output: Path, console: Console) -> Verdict:
    if bag is not None and config is None:
        raise DemoError("a bag needs the YAML of its drive: make demo BAG=... CONFIG=...")
    drive_file = config or configuration("demo_drive.yaml")
    settings = load_settings(drive_file)
    _prepare(output)
    with _graph(drive_file, output, console) as client:
        if bag is None:
            verdict = _with_rig(client, drive_file, output, console)
        else:
            verdict = _with_bag(client, bag, settings, console)
    heard = client.heard
    if heard[STATE]:
        title = f"{settings.name}: {'virtual rig' if bag is None else bag.name}"
        draw(output / "demo.png", title, heard[STATE], heard[TRUTH], heard[ALARM])
    return verdict


def _prepare(output: Path) -> None:
    """Make an output directory; only one that a demonstration made is removed."""
    if output.exists():
        if not (output / _MARK).is_file():
            raise DemoError(f"{output} exists and is no earlier demonstration; move it away")
        shutil.rmtree(output)
    output.mkdir(parents=True)
    (output / _MARK).touch()


@contextmanager
def _graph(drive_file: Path, output: Path, console: Console) -> Iterator[Client]:
    """Start the node and a client that hears it."""
    rclpy.init()
    client = Client(output / "bag")
    with ExitStack() as stack:
        stack.callback(client.close)
        node = stack.enter_context(
            Process(
                "belt_ros.node.main",
                output / _MARK,
                "--params-file",
                str(drive_file),
                "-p",
                "input_reliability:=reliable",
                "-p",
                "use_memory:=false",
                "-p",
                "longest_pool:=0.0",  # a state for every measurement, which is judged
            )
        )
        with console.status("starting the node; the first start of all compiles the mechanics"):
            _wait(client, client.node_listens, node, _START_PATIENCE)
        client.listen()
        for _ in range(20):
            client.work(0.05)
        yield client


def _wait(client: Client, ready: Callable[[], bool], process: Process, patience: float) -> None:
    """Serve the graph until `ready`."""
    end = time.monotonic() + patience
    while not ready():
        if process.exit_code is not None or time.monotonic() > end:
            raise DemoError(f"a process did not start:\n{process.last_words()}")
        client.work(0.1)


def _with_rig(client: Client, drive_file: Path, output: Path, console: Console) -> Verdict:
    scenario = configuration("scenarios/demo.yaml")
    with Process(
        "belt_ros.rig.main",
        output / "rig.log",
        "-p",
        f"config_file:={drive_file}",
        "-p",
        f"scenario_file:={scenario}",
        "-p",
        f"subscribers:={_LISTENERS}",
        "-p",
        f"wait_for_subscriber:={_LISTENER_PATIENCE}",
    ) as rig:
        _show(client, console, lambda: rig.exit_code is None)
        if rig.exit_code != 0:
            raise DemoError(f"the rig failed:\n{rig.last_words()}")
    heard = client.heard
    return judge(heard[STATE], heard[TRUTH], heard[ALARM], client.recorder.counts[JOINTS])


def _with_bag(client: Client, bag: Path, settings: DriveSettings, console: Console) -> Verdict:
    states = client.heard[STATE]
    with Player(bag, settings, client.publish_joints, lambda: len(states)) as player:
        _show(client, console, player.play)
    return judge_bag(client.heard[STATE], client.heard[ALARM], player.sent)


def _show(client: Client, console: Console, going: Callable[[], bool]) -> None:
    """Serve the graph and show it while `going`, and until the last messages are in."""
    begin = time.monotonic()
    drawn = -_LINE_EVERY
    end = None
    with Live(console=console, refresh_per_second=1.0 / _REFRESH, transient=False) as live:
        while end is None or time.monotonic() < end:
            if end is None and not going():
                end = time.monotonic() + _DRAIN
            client.work(0.002)
            elapsed = time.monotonic() - begin
            if elapsed - drawn < (_REFRESH if console.is_terminal else _LINE_EVERY):
                continue
            drawn = elapsed
            states, truths, alarms = (client.heard[topic] for topic in (STATE, TRUTH, ALARM))
            if not states:
                continue
            alarm = alarms[-1] if alarms else None
            if console.is_terminal:
                live.update(live_table(states[-1], truths[-1] if truths else None, alarm, elapsed))
            else:
                console.out(plain_line(states[-1], alarm, elapsed), highlight=False)


def _conclude(verdict: Verdict, output: Path, console: Console) -> int:
    console.print()
    for finding in verdict.findings:
        style = "red" if finding.passed is False else None
        console.print(str(finding), style=style, highlight=False)
    for label, name in (("recorded bag", "bag"), ("plot", "demo.png"), ("node's log", _MARK)):
        console.print(f"{label + ':':<14}{output / name}", highlight=False)
    console.print("good" if verdict.passed else "not good", style="bold")
    return 0 if verdict.passed else 1
