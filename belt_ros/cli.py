"""The `belt` command. What a command needs is imported when it runs, so that help comes at once."""

import json
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from enum import Enum
from pathlib import Path
from typing import Annotated

import typer

import belt_ros

_PATIENCE = 2.0  # [s] before a progress bar is worth its place
_PASS_ON = {"allow_extra_args": True, "ignore_unknown_options": True}

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
def _errors_in_one_line() -> Iterator[None]:
    """Report what the user can mend as one red line, without traceback, and exit with 1."""
    from belt_ros.mechanics import DriveError
    from belt_ros.parameter_table import SettingsError
    from belt_ros.replay.errors import BagError
    from belt_ros.replay.results import ResultsError

    try:
        yield
    except (BagError, DriveError, ResultsError, SettingsError, OSError) as error:
        typer.secho(" ".join(str(error).split()), fg=typer.colors.RED, err=True)
        raise typer.Exit(1) from error


@contextmanager
def _progress_bar(what: str, *, quiet: bool) -> Iterator[Progress | None]:
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


@app.command(epilog="Example: belt replay my_bag --config config/paper_drive.yaml --out results")
def replay(
    bag: Annotated[Path, typer.Argument(help="rosbag2 directory, .mcap or .db3 file.")],
    config: Config,
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", help="Result directory; <bag>_belt here if not given."),
    ] = None,
    topic: Annotated[
        str | None, typer.Option(help="Topic of the joint states, where there are several.")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace earlier results.")] = False,
    smooth: Annotated[
        bool,
        typer.Option(
            "--smooth/--no-smooth",
            help="Also say every half second what is known with hindsight, from the whole bag.",
        ),
    ] = True,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but errors.")] = False,
) -> None:
    """Estimate a drive's state from a bag: a bag of estimates, Parquet tables, a summary."""
    with _errors_in_one_line():
        from belt_ros import replay as replaying
        from belt_ros.settings import load_settings

        settings = load_settings(config)
        place = out or Path(f"{_name_of(bag)}_belt")
        with _progress_bar("replaying", quiet=quiet) as progress:
            summary = replaying.replay(
                bag,
                settings,
                place,
                topic=topic,
                replace=force,
                smooth=smooth,
                progress=progress,
            )
    if not quiet:
        from belt_ros.terminal import print_summary

        print_summary(summary, place)


def _name_of(bag: Path) -> str:
    place = bag.resolve()
    return place.name if place.is_dir() else place.stem


@app.command(epilog="Example: belt check config/paper_drive.yaml")
def check(
    config: Annotated[Path, typer.Argument(help="YAML that describes the drive.")],
) -> None:
    """Check a drive's YAML, and say what the mechanics makes of it."""
    with _errors_in_one_line():
        from belt_ros.rating import rate
        from belt_ros.settings import load_settings
        from belt_ros.terminal import print_rating

        settings = load_settings(config)
        print_rating(settings, rate(settings))


@app.command(epilog="Example: belt parameters --markdown > parameters.md")
def parameters(
    markdown: Annotated[bool, typer.Option("--markdown", help="As a Markdown table.")] = False,
) -> None:
    """List the parameters of a drive's YAML: unit, default, range and meaning."""
    from belt_ros.terminal import markdown_parameters, print_parameters

    if markdown:
        typer.echo(markdown_parameters())
    else:
        print_parameters()


@app.command(epilog="Example: belt demo    (or with your own: --bag my_bag --config drive.yaml)")
def demo(
    bag: Annotated[Path | None, typer.Option(help="A bag of yours, instead of the rig.")] = None,
    config: OptionalConfig = None,
) -> None:
    """Show it all at work: rig or bag, live node, alarms and results."""
    _need_ros()
    with _errors_in_one_line():
        from belt_ros.demo.main import run

        code = run(bag, config)
    raise typer.Exit(code)


@app.command(
    context_settings=_PASS_ON,
    epilog="Example: belt node --ros-args --params-file config/paper_drive.yaml",
)
def node(context: typer.Context) -> None:
    """Run the live ROS 2 node; everything after `node` goes to it."""
    _need_ros()
    from belt_ros.node.main import main as run_node

    raise typer.Exit(run_node(context.args))


@app.command(epilog="Example: belt rig -c config/paper_drive.yaml -s config/scenarios/demo.yaml")
def rig(
    config: Config,
    scenario: Annotated[Path, typer.Option("--scenario", "-s", help="YAML that scripts the run.")],
    bag: Annotated[
        Path | None, typer.Option(help="Write a bag as fast as it goes, instead of playing live.")
    ] = None,
    finite_elements: Annotated[
        bool,
        typer.Option(
            "--finite-elements", help="With --bag: simulate belt and contact node by node."
        ),
    ] = False,
) -> None:
    """Run a virtual drive, with faults on request: live on ROS 2 topics, or into a bag."""
    if finite_elements and bag is None:
        raise typer.BadParameter(
            "it is too slow to play live; give --bag", param_hint="--finite-elements"
        )
    with _errors_in_one_line():
        from belt_ros.rig import load_scenario, simulate, simulate_finite_elements
        from belt_ros.settings import load_settings

        settings = load_settings(config)
        script = load_scenario(scenario, settings)
        if bag is not None:
            from belt_ros.rig.bag import write_bag

            if finite_elements:
                with _progress_bar("simulating", quiet=False) as progress:
                    samples = simulate_finite_elements(settings, script, progress=progress)
            else:
                samples = simulate(settings, script)
            count = write_bag(bag, settings.name, samples)
            typer.echo(f"{count} joint states written to {bag}")
            return
    _need_ros()
    from belt_ros.rig.main import main as play

    files = {"config_file": config, "scenario_file": scenario}
    given = [f"{name}:={json.dumps(str(path))}" for name, path in files.items()]
    raise typer.Exit(play(["--ros-args", *(word for text in given for word in ("-p", text))]))


class MaterialTable(str, Enum):
    """The tables of `belt materials`."""

    BELTS = "belts"
    LIMITS = "limits"
    FRICTION = "friction"
    LAGGINGS = "laggings"
    SECTIONS = "sections"
    EVIDENCE = "evidence"
    SOURCES = "sources"


@app.command(epilog="Example: belt materials --belt polyamide-rubber --size 0.05 --on steel")
def materials(
    table: Annotated[
        MaterialTable, typer.Argument(help="Which table to print.")
    ] = MaterialTable.BELTS,
    belt: Annotated[
        str | None, typer.Option(help="Print this belt's figures as YAML for a drive instead.")
    ] = None,
    size: Annotated[
        float | None, typer.Option(help="Its width or diameter [m], or number of ribs or belts.")
    ] = None,
    on: Annotated[str, typer.Option(help="What it runs on; see the table of laggings.")] = "steel",
    state: Annotated[str, typer.Option(help="dry, wet or dirty.")] = "dry",
    diameter: Annotated[
        float | None, typer.Option(help="Datum diameter of a grooved pulley [m].")
    ] = None,
) -> None:
    """List belts, laggings and grooves that can be named, or the figures of one belt."""
    with _errors_in_one_line():
        from belt_ros.mechanics import DriveError
        from belt_ros.mechanics.materials import belt_material
        from belt_ros.terminal import material_yaml, print_material_table

        if belt is None:
            print_material_table(table.value)
            return
        material = belt_material(belt)
        if size is None:
            raise DriveError(f"--size is missing: {material.size.value}")
        typer.echo(material_yaml(material, size, on, state, diameter))


@app.command(epilog="Example: belt figures --out figures --only 10 --only table2")
def figures(
    out: Annotated[Path, typer.Option("--out", "-o", help="Directory to write them to.")] = Path(
        "figures"
    ),
    only: Annotated[
        list[str] | None, typer.Option(help="Figure number or table; may be given several times.")
    ] = None,
) -> None:
    """Draw the figures and tables of Kim, Leamy and Ferri (2011) with this code."""
    from belt_ros.figures import FigureError, draw_all

    with _errors_in_one_line(), _progress_bar("drawing", quiet=False) as progress:
        try:
            places = draw_all(out, only, progress)
        except FigureError as error:
            raise typer.BadParameter(str(error), param_hint="--only") from error
    for place in places:
        typer.echo(place)


def _need_ros() -> None:
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


def main() -> None:
    """Run the `belt` command."""
    app()


if __name__ == "__main__":
    main()
