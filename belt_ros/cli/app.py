"""The application: its options, and what all commands share."""

import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer

import belt_ros

_PATIENCE = 2.0  # [s] before a progress bar is worth its place

Progress = Callable[[float, float], None]  # called with what is done and what there is to do

app = typer.Typer(
    name="belt",
    help="Know the state of a belt drive: slip, tensions, friction and margin, live or from bags.",
    no_args_is_help=True,
    rich_markup_mode="rich",
    pretty_exceptions_enable=False,
)

Config = Annotated[
    Path, typer.Option("--config", "-c", help="YAML that describes the drive; see config/.")
]
OptionalConfig = Annotated[
    Path | None, typer.Option("--config", "-c", help="YAML that describes the drive; see config/.")
]


@contextmanager
def errors_in_one_line() -> Iterator[None]:
    """Report what the user can mend as one red line, without traceback, and exit with 1."""
    from belt_ros.fleet import FleetError
    from belt_ros.mechanics import DriveError
    from belt_ros.parameter_table import SettingsError
    from belt_ros.replay.errors import BagError
    from belt_ros.replay.results import ResultsError
    from belt_ros.report import ReportError

    mendable = (
        BagError,
        DriveError,
        FleetError,
        ReportError,
        ResultsError,
        SettingsError,
        OSError,
    )
    try:
        yield
    except mendable as error:
        say_error(str(error))
        raise typer.Exit(1) from error


def say_error(text: str) -> None:
    """Print one red line."""
    typer.secho(" ".join(text.split()), fg=typer.colors.RED, err=True)


@contextmanager
def progress_bar(what: str, *, quiet: bool) -> Iterator[Progress | None]:
    """Yield what a long work reports to; a bar appears on a terminal once it takes long."""
    if quiet or not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console
    from rich.progress import Progress as Bar

    bar = Bar(
        *Bar.get_default_columns(),
        console=Console(stderr=True),
        transient=True,
    )
    task = bar.add_task(what, total=None)
    late = threading.Timer(_PATIENCE, bar.start)
    late.daemon = True
    late.start()
    try:
        yield lambda done, total: bar.update(task, completed=done, total=total)
    finally:
        late.cancel()
        late.join()
        bar.stop()


def _print_version(*, wanted: bool) -> None:
    if wanted:
        typer.echo(f"belt {belt_ros.__version__}")
        raise typer.Exit


@app.callback()
def _options(
    _version: Annotated[
        bool,
        typer.Option(
            "--version",
            callback=lambda wanted: _print_version(wanted=wanted),
            is_eager=True,
            help="Print the version and exit.",
        ),
    ] = False,
) -> None:
    """Take the options that come before any command."""


def need_ros() -> None:
    """Say how to get ROS 2 where there is none."""
    from importlib.util import find_spec

    if find_spec("rclpy") is None or find_spec("belt_msgs") is None:
        typer.secho(
            "This needs ROS 2 with belt_msgs: source a workspace that holds them, or run "
            "`make setup` and use .venv/bin/belt.",
            fg=typer.colors.RED,
            err=True,
        )
        raise typer.Exit(1)
