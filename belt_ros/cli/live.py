"""Commands that run: demo, node, rig, play."""

import json
from pathlib import Path
from typing import Annotated

import typer

from belt_ros.cli.app import (
    Config,
    OptionalConfig,
    app,
    errors_in_one_line,
    need_ros,
    progress_bar,
)

_PASS_ON = {"allow_extra_args": True, "ignore_unknown_options": True}


@app.command(epilog="Example: belt demo    (or with your own: --bag my_bag --config drive.yaml)")
def demo(
    bag: Annotated[Path | None, typer.Option(help="A bag of yours, instead of the rig.")] = None,
    config: OptionalConfig = None,
) -> None:
    """Show it all at work: rig or bag, live node, alarms and results."""
    need_ros()
    with errors_in_one_line():
        from belt_ros.demo.main import run

        code = run(bag, config)
    raise typer.Exit(code)


@app.command(
    context_settings=_PASS_ON,
    epilog="Example: belt node --ros-args --params-file config/paper_drive.yaml",
)
def node(context: typer.Context) -> None:
    """Run the live ROS 2 node; everything after `node` goes to it."""
    need_ros()
    from belt_ros.node.main import main as run_node

    raise typer.Exit(run_node(context.args))


@app.command(
    context_settings=_PASS_ON,
    epilog="Example: belt rig -c config/paper_drive.yaml -s config/scenarios/demo.yaml    (live, "
    "with more after it: --ros-args -p output:=pulley_state)",
)
def rig(
    context: typer.Context,
    config: Config,
    scenario: Annotated[Path, typer.Option("--scenario", "-s", help="YAML that scripts the run.")],
    bag: Annotated[
        Path | None, typer.Option(help="Write a bag as fast as it goes, instead of playing live.")
    ] = None,
    drive: Annotated[
        str, typer.Option(help="With --bag: which drive, where the YAML describes several.")
    ] = "",
    finite_elements: Annotated[
        bool,
        typer.Option(
            "--finite-elements", help="With --bag: simulate belt and contact node by node."
        ),
    ] = False,
) -> None:
    """Run a virtual drive, with faults on request: live on ROS 2 topics, or into a bag.

    Live, what follows goes to the ROS 2 node, such as its parameters after --ros-args.
    """
    if context.args and (bag is not None or context.args[0] != "--ros-args"):
        raise typer.BadParameter(
            "unknown here; what is for the ROS 2 node follows --ros-args, without --bag",
            param_hint=context.args[0],
        )
    if bag is not None:
        with errors_in_one_line():
            _write_bag(bag, config, scenario, drive, finite_elements=finite_elements)
        return
    if finite_elements:
        raise typer.BadParameter(
            "it is too slow to play live; give --bag", param_hint="--finite-elements"
        )
    if drive:
        raise typer.BadParameter("live, all drives run; give --bag", param_hint="--drive")
    with errors_in_one_line():
        from belt_ros.rig.fleet import load_fleet

        load_fleet(config, scenario)
    need_ros()
    from belt_ros.rig.main import main as play

    files = {"config_file": config, "scenario_file": scenario}
    given = [f"{name}:={json.dumps(str(path))}" for name, path in files.items()]
    words = ["--ros-args", *(word for text in given for word in ("-p", text)), "--"]
    raise typer.Exit(play([*words, *context.args]))


def _write_bag(
    bag: Path, config: Path, scenario: Path, drive: str, *, finite_elements: bool
) -> None:
    from belt_ros.rig import load_scenario, simulate, simulate_finite_elements
    from belt_ros.rig.bag import refuse_existing, write_bag
    from belt_ros.settings import load_settings

    refuse_existing(bag)  # before all is simulated
    settings = load_settings(config, drive=drive)
    script = load_scenario(scenario, settings)
    if finite_elements:
        with progress_bar("simulating", quiet=False) as progress:
            samples = simulate_finite_elements(settings, script, progress=progress)
    else:
        samples = simulate(settings, script)
    count = write_bag(bag, settings.name, samples)
    typer.echo(f"{count} joint states written to {bag}")


@app.command(epilog="Example: belt play my_bag --clock --rate 2 --remap /joint_states:=/old_joints")
def play(
    bag: Annotated[Path, typer.Argument(help="rosbag2 directory, .mcap or .db3 file.")],
    rate: Annotated[float, typer.Option("--rate", "-r", help="Bag time per time.")] = 1.0,
    loop: Annotated[bool, typer.Option("--loop", "-l", help="Again and again.")] = False,
    clock: Annotated[
        bool, typer.Option("--clock", help="Publish /clock, for nodes with use_sim_time.")
    ] = False,
    remap: Annotated[
        list[str] | None, typer.Option("--remap", "-m", help="/old:=/new; may be repeated.")
    ] = None,
    topics: Annotated[
        list[str] | None, typer.Option("--topics", help="Topic to play; may be repeated.")
    ] = None,
    wait: Annotated[
        float, typer.Option(help="Wait for someone to listen, at most this long (s).")
    ] = 5.0,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but errors.")] = False,
) -> None:
    """Publish a bag to a running graph, where rosbag2 is not installed; space bar pauses."""
    need_ros()
    with errors_in_one_line():
        from belt_ros.player.run import play as playing

        played = playing(
            bag,
            rate=rate,
            loop=loop,
            clock=clock,
            remap=remap or (),
            topics=topics or (),
            wait=wait,
            tell=None if quiet else typer.echo,
        )
    if not quiet:
        if played.note:
            typer.secho(played.note, fg=typer.colors.YELLOW)
        end = " (interrupted)" if played.interrupted else ""
        typer.echo(f"{played.messages} messages published{end}")
