"""`aioduco demo`: a small pick and place, or ways round an obstacle. Here are its options."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from aioduco.cli import extras
from aioduco.cli.addresses import Port, robot_at
from aioduco.cli.options import refuse_unused, require_writable


def demo(
    context: typer.Context,
    host: str | None = None,
    port: Port = None,
    model: str = "gcr5_910",
    speed: Annotated[float, typer.Option(min=0.01, max=100.0)] = 1.0,
    plot: Path = Path("demo.png"),
    no_plot: bool = False,
    result: Annotated[Path | None, typer.Option("--json")] = None,
    planned: Annotated[bool, typer.Option("--plan")] = False,
    pictures: Annotated[Path | None, typer.Option(file_okay=False)] = None,
    yes: bool = False,
) -> None:
    """Make a small pick and place, show it, and say how well it went.

    Args:
        host: A controller's address, or its name. Without it: a simulated arm.
        model: Arm to simulate, or model of the real one.
        speed: Speed of simulated time, as a multiple of real time.
        plot: File for the plot.
        no_plot: Write no plot.
        result: File for the result. -: standard output.
        planned: Plan and carry out ways round an obstacle, if simulated.
        pictures: With --plan: folder for pictures before and after.
        yes: Do not ask before a real arm moves.
    """
    if host is None:
        refuse_unused(context, "--host: without it, a simulated arm moves", "port")
    else:
        refuse_unused(context, "a simulated arm", "speed")
    if planned:
        refuse_unused(context, "the pick and place, without --plan", "speed", "plot", "no_plot")
    else:
        refuse_unused(context, "--plan", "pictures")
    drawn = None if no_plot or planned else plot
    require_writable("--plot", drawn)
    require_writable("--json", None if result == Path("-") else result)
    address = None if host is None else robot_at(host, port)
    if not planned:
        from aioduco.cli.demo_run import run  # noqa: PLC0415 - NumPy and the rest, as below

        run(address, model, speed, drawn, result, yes=yes)
    if address is not None:
        raise typer.BadParameter(
            "is for a simulated arm: its obstacle stands nowhere else", param_hint="--plan"
        )
    extras.need("sim", "plan", *(("plot",) if pictures is not None else ()))
    from aioduco.cli.demo_plan import run_planned  # noqa: PLC0415 - MuJoCo is for this case alone

    run_planned(model, result, pictures)
