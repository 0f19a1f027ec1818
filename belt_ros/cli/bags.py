"""Commands about bags: replay, identify, report, fleet."""

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from belt_ros.cli.app import Config, app, errors_in_one_line, progress_bar, say_error

if TYPE_CHECKING:
    from collections.abc import Callable

    from belt_ros.replay.drives import Outcome


@app.command(epilog="Example: belt replay my_bag --config config/paper_drive.yaml --out results")
def replay(
    bags: Annotated[
        list[str],
        typer.Argument(help="rosbag2 directories, .mcap or .db3 files, folders of them, patterns."),
    ],
    config: Config,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out",
            "-o",
            help="Result directory; <bag>_belt here if not given. Of several bags, "
            "each has its own in it.",
        ),
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
    """Estimate drives' states from bags: a bag of estimates, Parquet tables, a summary of each.

    It exits with 1 where a drive has no result from a bag, or nothing can be done at all.
    """
    failed = 0
    with errors_in_one_line():
        from belt_ros.replay.bags import find_bags, result_names
        from belt_ros.replay.drives import load_drives, replay_drives

        drives = load_drives(config)
        found = find_bags(bags, tell=_teller(quiet=quiet))
        for bag, name in zip(found, result_names(found), strict=True):
            with progress_bar(f"replaying {bag.name}", quiet=quiet) as progress:
                outcomes = list(
                    replay_drives(
                        bag,
                        drives,
                        _place(name, out, several=len(found) > 1),
                        topic=topic,
                        replace=force,
                        smooth=smooth,
                        progress=progress,
                    )
                )
            failed += sum(_tell(outcome, quiet=quiet) for outcome in outcomes)
    if failed:
        raise typer.Exit(1)


def _teller(*, quiet: bool) -> "Callable[[str], None] | None":
    """Return what tells the user beside the results; nothing does where it is to be quiet."""
    return None if quiet else partial(typer.echo, err=True)


def _tell(outcome: "Outcome", *, quiet: bool) -> bool:
    """Print what came of one drive; whether it failed."""
    from belt_ros.terminal import print_summary

    if outcome.summary is None:
        say_error(outcome.error)
    elif not quiet:
        print_summary(outcome.summary, outcome.place)
    return outcome.summary is None


def _place(name: str, out: Path | None, *, several: bool) -> Path:
    """Return where the results of a bag belong, which are to have a name."""
    if out is None:
        return Path(f"{name}_belt")
    return out / name if several else out


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
    force: Annotated[
        bool,
        typer.Option("--force", help="Replace the file at --out; write it also if nothing fits."),
    ] = False,
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
        if out is not None and not found.goodness.fits and not force:
            raise SettingsError(
                f"{out} not written: the model does not fit these loads, so that no interval is to "
                "be believed; take a bag in which nothing changed, or give --force"
            )
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


@app.command(epilog="Example: belt fleet 'bags/*' --config drive.yaml --out fleet")
def fleet(
    bags: Annotated[list[str], typer.Argument(help="Bags, folders of bags, patterns.")],
    config: Config,
    out: Annotated[Path, typer.Option("--out", "-o", help="Directory of all results.")],
    workers: Annotated[
        int | None, typer.Option(min=1, help="Processes; one for each core if not given.")
    ] = None,
    scheduler: Annotated[
        str | None, typer.Option(help="Address of a Dask scheduler, to work there instead.")
    ] = None,
    topic: Annotated[
        str | None, typer.Option(help="Topic of the joint states, where there are several.")
    ] = None,
    smooth: Annotated[
        bool, typer.Option("--smooth/--no-smooth", help="Also what is known with hindsight.")
    ] = True,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but errors.")] = False,
) -> None:
    """Replay many bags: one table, trends and one page over all. Run again, it goes on.

    It exits with 1 where a drive has no result from a bag, or nothing can be done at all.
    """
    with errors_in_one_line(), progress_bar("replaying", quiet=quiet) as progress:
        from belt_ros.fleet import run_fleet

        result = run_fleet(
            bags,
            config,
            out,
            workers=workers,
            scheduler=scheduler,
            smooth=smooth,
            topic=topic,
            progress=progress,
            tell=_teller(quiet=quiet),
        )
    for row in result.rows:
        if row.error:
            say_error(row.error)
    if not quiet:
        typer.echo(
            f"{result.done} bags worked on, {result.skipped} done before; {result.failed} of "
            f"{len(result.rows)} results (one for each drive in each bag) failed: "
            f"{out / 'fleet.html'}"
        )
    if result.failed:
        raise typer.Exit(1)
