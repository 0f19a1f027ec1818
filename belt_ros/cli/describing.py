"""Commands about a drive as it is described: init, check, parameters, materials, figures."""

import sys
from enum import Enum
from pathlib import Path
from typing import Annotated

import typer

from belt_ros.cli.app import app, errors_in_one_line, progress_bar


@app.command(
    epilog="Example: belt init drive.yaml    (asks)    or, with flags only: belt init drive.yaml "
    "--driver-radius 0.08 --driven-radius 0.12 --centre-distance 0.6 --belt polyamide-rubber "
    "--size 0.05 --driver-inertia 0.02 --driven-mass 3"
)
def init(
    out: Annotated[Path, typer.Argument(help="YAML to write.")] = Path("drive.yaml"),
    name: Annotated[str | None, typer.Option(help="Name of the drive in messages.")] = None,
    driver_radius: Annotated[
        float | None, typer.Option(help="Radius of the driver, to the belt's neutral line (m).")
    ] = None,
    driven_radius: Annotated[
        float | None, typer.Option(help="Radius of the driven pulley (m).")
    ] = None,
    centre_distance: Annotated[float | None, typer.Option(help="Of the shafts (m).")] = None,
    crossed: Annotated[bool, typer.Option("--crossed", help="The belt crosses itself.")] = False,
    belt: Annotated[str | None, typer.Option(help="Belt; see `belt materials`.")] = None,
    size: Annotated[
        float | None, typer.Option(help="Width or diameter (m), or number of ribs or belts.")
    ] = None,
    axial_stiffness: Annotated[float | None, typer.Option(help="EA (N), if known.")] = None,
    mass_per_length: Annotated[
        float | None, typer.Option(help="Of the belt (kg/m), if known.")
    ] = None,
    driven_surface: Annotated[
        str | None, typer.Option(help="Lagging; see `belt materials laggings`.")
    ] = None,
    driver_surface: Annotated[
        str | None, typer.Option(help="Lagging of the driver, if another.")
    ] = None,
    surface_state: Annotated[str | None, typer.Option(help="dry, wet or dirty.")] = None,
    friction_coefficient: Annotated[float | None, typer.Option(help="mu, if known.")] = None,
    tensioning: Annotated[
        str | None,
        typer.Option(
            help="constant_mean, constant_slack, constant_hub_load or fixed_centres (default)."
        ),
    ] = None,
    tension: Annotated[float | None, typer.Option(help="As installed (N).")] = None,
    tension_tolerance: Annotated[float | None, typer.Option(help="+/- (N), 19 of 20.")] = None,
    driver_inertia: Annotated[float | None, typer.Option(help="Moment of inertia (kg m2).")] = None,
    driver_mass: Annotated[float | None, typer.Option(help="Of a disc instead (kg).")] = None,
    driven_inertia: Annotated[float | None, typer.Option(help="Moment of inertia (kg m2).")] = None,
    driven_mass: Annotated[float | None, typer.Option(help="Of a disc instead (kg).")] = None,
    kind: Annotated[
        str | None, typer.Option("--input", help="joint_state, pulley_state or float64.")
    ] = None,
    driver_joint: Annotated[str | None, typer.Option(help="Name in JointState.")] = None,
    driven_joint: Annotated[str | None, typer.Option(help="Name in JointState.")] = None,
    driver_gear_ratio: Annotated[
        float | None, typer.Option(help="Turns of the joint per turn of the pulley.")
    ] = None,
    driven_gear_ratio: Annotated[
        float | None, typer.Option(help="Turns of the joint per turn of the pulley.")
    ] = None,
    driver_sign: Annotated[
        float | None, typer.Option(help="-1 if it counts against the belt.")
    ] = None,
    driven_sign: Annotated[
        float | None, typer.Option(help="-1 if it counts against the belt.")
    ] = None,
    driver_counts: Annotated[
        float | None, typer.Option(help="Encoder counts per turn of the joint.")
    ] = None,
    driven_counts: Annotated[
        float | None, typer.Option(help="Encoder counts per turn of the joint.")
    ] = None,
    sample_rate: Annotated[float | None, typer.Option(help="Readings per second (Hz).")] = None,
    torque: Annotated[
        str | None, typer.Option(help="How the driver's is known: sensor or current.")
    ] = None,
    torque_constant: Annotated[
        float | None, typer.Option(help="N m of the joint per unit of effort, e.g. per A.")
    ] = None,
    driven_torque: Annotated[
        bool, typer.Option("--driven-torque", help="The driven pulley's is measured too.")
    ] = False,
    ask: Annotated[
        bool | None,
        typer.Option("--ask/--no-ask", help="Ask what no flag tells; on a terminal it does."),
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace the file.")] = False,
) -> None:
    """Make a drive's YAML from a few questions, or from flags alone."""
    given = dict(locals())
    for other in ("out", "ask", "force"):
        del given[other]
    given["input"] = given.pop("kind")
    for flag in ("crossed", "driven_torque"):
        given[flag] = given[flag] or None
    with errors_in_one_line():
        from rich.console import Console

        from belt_ros.appearing import appearing
        from belt_ros.parameter_table import SettingsError
        from belt_ros.starter import answers_from, drive_yaml
        from belt_ros.starter.asking import ask as questions

        if out.exists() and not force:
            raise SettingsError(f"{out} exists already; give --force to replace it")
        asking = sys.stdin.isatty() and sys.stdout.isatty() if ask is None else ask
        answers = questions(given, Console(highlight=False)) if asking else answers_from(given)
        text = drive_yaml(answers)
        try:
            with appearing(out) as part:
                part.write_text(text, encoding="utf-8")
        except OSError as error:
            raise SettingsError(f"cannot write {out}: {error.strerror or error}") from error
    typer.echo(f"{out} written; see what it amounts to: belt check {out}")


@app.command(epilog="Example: belt check config/paper_drive.yaml")
def check(
    config: Annotated[Path, typer.Argument(help="YAML that describes the drive.")],
) -> None:
    """Check a YAML of one drive or several, and say what the mechanics makes of each."""
    with errors_in_one_line():
        from belt_ros.rating import rate
        from belt_ros.replay.drives import load_drives
        from belt_ros.terminal import print_rating

        for drive in load_drives(config):
            print_rating(drive.settings, rate(drive.settings))


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
        float | None, typer.Option(help="Its width or diameter (m), or number of ribs or belts.")
    ] = None,
    on: Annotated[str, typer.Option(help="What it runs on; see the table of laggings.")] = "steel",
    state: Annotated[str, typer.Option(help="dry, wet or dirty.")] = "dry",
    diameter: Annotated[
        float | None, typer.Option(help="Datum diameter of a grooved pulley (m).")
    ] = None,
) -> None:
    """List belts, laggings and grooves that can be named, or the figures of one belt."""
    with errors_in_one_line():
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

    with errors_in_one_line(), progress_bar("drawing", quiet=False) as progress:
        try:
            places = draw_all(out, only, progress)
        except FigureError as error:
            raise typer.BadParameter(str(error), param_hint="--only") from error
    for place in places:
        typer.echo(place)
