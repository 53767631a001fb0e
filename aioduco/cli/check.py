"""`aioduco check`: taught points looked at before an arm goes there."""

from __future__ import annotations

from pathlib import Path  # noqa: TC003 - typer evaluates the annotations
from typing import Annotated

import typer

__all__ = ["check"]


def check(
    file: Annotated[Path, typer.Argument(help="File of points, as `TaughtPoints.save` writes it.")],
    model: Annotated[str, typer.Option(help="The arm.")] = "gcr5_910",
    start: Annotated[
        str | None,
        typer.Option(help="Point of the file where it begins; the first joints, if left out."),
    ] = None,
    tool: Annotated[
        str | None, typer.Option(help="Tip of the tool from the flange: x,y,z,rx,ry,rz [m, rad].")
    ] = None,
    wobj: Annotated[
        str | None, typer.Option(help="Work object in the base: x,y,z,rx,ry,rz [m, rad].")
    ] = None,
) -> None:
    """Check taught points: reach, joint limits, singularities, branches. Nothing moves."""
    from aioduco.errors import ParameterError  # noqa: PLC0415 - for this command alone
    from aioduco.kinematics import check as look  # noqa: PLC0415
    from aioduco.models.points import TaughtPoints  # noqa: PLC0415
    from aioduco.models.pose import Joints  # noqa: PLC0415

    try:
        points = TaughtPoints.load(file)
        if start is not None:
            near = points.joints(start)
        else:
            taught = (point for point in points.values() if isinstance(point, Joints))
            near = next(taught, Joints.deg(30, -15, 105, 0, -90, 0))
        tip, base = _pose("tool", tool), _pose("wobj", wobj)
        report = look(points, arm=model, near=near, tool=tip, wobj=base)
    except (OSError, ParameterError) as error:
        typer.echo(str(error), err=True)
        raise typer.Exit(2) from None
    typer.echo(str(report))
    if not report.ok:
        raise typer.Exit(1)


def _pose(name: str, text: str | None) -> list[float] | None:
    from aioduco.errors import ParameterError  # noqa: PLC0415

    if text is None:
        return None
    try:
        values = [float(each) for each in text.split(",")]
    except ValueError:
        values = []
    if len(values) != 6:
        raise ParameterError(name, text, "x,y,z,rx,ry,rz [m, rad]")
    return values
