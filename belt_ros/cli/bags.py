"""Commands about bags: replay, identify, report, fleet."""

from pathlib import Path
from typing import Annotated

import typer

from belt_ros.cli.app import Config, app, errors_in_one_line, progress_bar


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
    with errors_in_one_line():
        from belt_ros import replay as replaying
        from belt_ros.settings import load_settings

        settings = load_settings(config)
        place = out or Path(f"{_name_of(bag)}_belt")
        with progress_bar("replaying", quiet=quiet) as progress:
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


@app.command(epilog="Example: belt identify my_bag --config drive.yaml --out identified.yaml")
def identify(
    bag: Annotated[Path, typer.Argument(help="rosbag2 directory, .mcap or .db3 file, with loads.")],
    config: Config,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", help="Drive's YAML to write, with what was found.")
    ] = None,
    drive: Annotated[str, typer.Option(help="Which drive, where the YAML describes several.")] = "",
    topic: Annotated[
        str | None, typer.Option(help="Topic of the joint states, where there are several.")
    ] = None,
    wide: Annotated[
        bool, typer.Option("--wide", help="Start from wide priors, not from those of the YAML.")
    ] = False,
    force: Annotated[bool, typer.Option("--force", help="Replace the file at --out.")] = False,
) -> None:
    """Find kf, friction, tension and radius ratio in a bag with loads, each with its interval."""
    with errors_in_one_line():
        from belt_ros import identify as identifying
        from belt_ros.drive_inputs import load_inputs
        from belt_ros.identify.shown import print_identified
        from belt_ros.identify.written import write_identified
        from belt_ros.parameter_table import SettingsError
        from belt_ros.settings import load_settings, names_of_drives, read_parameters

        if out is not None and out.exists() and not force:
            raise SettingsError(f"{out} exists already; give --force to replace it")
        settings = load_settings(config, drive=drive)
        names = names_of_drives(read_parameters(config))
        found = identifying.identify(
            bag,
            settings,
            inputs=load_inputs(config, drive),
            prefix=f"{drive or names[0]}/" if names else "",
            topic=topic,
            wide=wide,
        )
        print_identified(found)
        if out is not None:
            write_identified(config, out, found, settings, drive)
            typer.echo(f"written to {out}")


@app.command(epilog="Example: belt report results --baseline commissioning --out report.html")
def report(
    results: Annotated[Path, typer.Argument(help="Result directory of belt replay.")],
    baseline: Annotated[
        Path | None,
        typer.Option(
            "--baseline",
            "-b",
            help="Results of the same drive when it was commissioned, to compare with.",
        ),
    ] = None,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", help="The page; <results>.html here if not given.")
    ] = None,
) -> None:
    """Make one HTML page of a replay's results, which opens anywhere, also offline."""
    with errors_in_one_line():
        from belt_ros.report import write_report

        place = out or Path(f"{results.resolve().name}.html")
        write_report(results, place, baseline)
    typer.echo(f"report in {place}")
