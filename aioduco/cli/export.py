"""`aioduco export`: descriptions of arms for other programs, as files."""

from __future__ import annotations

import enum
import shutil
import sysconfig
from itertools import zip_longest
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, cast

import typer

from aioduco.cli.exit_codes import fail
from aioduco.cli.options import mounting_option, numbers, refuse_unused
from aioduco.cli.output import say
from aioduco.models.whole_files import whole_file, write_whole

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.descriptions import ArmDescription, ToolDescription
    from aioduco.descriptions.moveit_files import RosDistro
    from aioduco.kinematics.mounting import MountingLike


class Format(enum.StrEnum):
    """Formats that can be exported."""

    URDF = "urdf"
    SRDF = "srdf"
    MJCF = "mjcf"
    MOVEIT = "moveit"
    ROS1 = "ros1"


def export(
    context: typer.Context,
    kind: Format,
    model: list[str] | None = None,
    output: Annotated[Path, typer.Option("--output", "-o", file_okay=False)] = Path(),
    prefix: list[str] | None = None,
    mounting: list[str] | None = None,
    name: str | None = None,
    meshes: Path | None = None,
    mesh_uri: str | None = None,
    tcp: str | None = None,
    tool_mass: Annotated[float, typer.Option(min=0.0)] = 0.0,
    tool_centre: str = "0,0,0",
    tool_capsule: list[str] | None = None,
    distro: str = "jazzy",
    moveit: bool = False,
    group: str = "manipulator",
    tip: str = "",
) -> None:
    """Write an arm as URDF, SRDF, MJCF, MoveIt's configuration or a package of ROS 1.

    Files of the same names are overwritten.

    Args:
        kind: What to write.
        model: Arm. Default: gcr5_910. Repeat it for more arms.
        output: Folder to write to. It is created if it does not exist.
        prefix: Prefix of the arm's names; one for each --model.
        mounting: floor, wall, ceiling, none for no world, or the base's pose: x,y,z,rx,ry,rz [m,
            rad]; one for each --model.
        name: Name of the description. Default: the models' names.
        meshes: Folder of your meshes, named like the links: link_1.stl. Default: meshes made from
            the arm's lengths.
        mesh_uri: Address of the meshes in the URDF: package://my_arm/meshes. Without --meshes, they
            are written to the folder `meshes`; without both, the URDF has cylinders.
        tcp: Tip of the tool from the flange: x,y,z,rx,ry,rz [m, rad].
        tool_mass: Mass of the tool [kg].
        tool_centre: Its centre of mass in the frame of the flange: x,y,z [m].
        tool_capsule: A part of its shape in the frame of the flange, from one point to another,
            with a radius: x,y,z,x,y,z,r [m]; again for more.
        distro: With moveit: release of ROS: jazzy, humble, or noetic for MoveIt 1.
        moveit: With ros1: MoveIt 1's package beside the driver's.
        group: MoveIt's group: duco_gcr5 in the vendor's package.
        tip: Last link of the group: link_6 there. Default: tool or flange.
    """
    from aioduco import descriptions  # noqa: PLC0415 - for this command alone
    from aioduco.errors import ParameterError  # noqa: PLC0415

    _refuse_unused(context, kind, moveit=moveit)
    try:
        tool = _tool(tcp, tool_mass, tool_centre, tool_capsule or [])
        arms = _arms(model or ["gcr5_910"], prefix or [], mounting or [], tool)
        called = name or "_".join(arm.arm.name for arm in arms)
        package = f"{called}_bringup"
        if kind is Format.ROS1 and meshes is None and mesh_uri is None:
            mesh_uri = f"package://{package}/meshes"
        looks: dict[str, Any] = {"meshes": meshes, "mesh_uri": mesh_uri}
        if kind is Format.URDF:
            text = descriptions.urdf(*arms, name=name, **looks)
            files = {f"{called}.urdf": text}
        elif kind is Format.SRDF:
            files = {f"{called}.srdf": descriptions.srdf(*arms, name=name)}
        elif kind is Format.MJCF:
            files = {
                f"{called}.xml": descriptions.mjcf(*arms, name=name, meshes=meshes),
                "scene.xml": descriptions.mjcf_scene(called, f"{called}.xml"),
            }
        elif kind is Format.ROS1:
            from aioduco.integrations.ros.ros1.launch_package import (  # noqa: PLC0415 - as above
                launch_package,
            )

            own = shutil.which("aioduco", path=sysconfig.get_path("scripts")) or "aioduco"
            files = launch_package(*arms, name=called, command=own, **looks)
            if moveit:
                from aioduco.integrations.ros.ros1.launch_package import (  # noqa: PLC0415 - as above
                    moveit_package,
                )

                files |= moveit_package(*arms, name=called, group=group, tip=tip, **looks)
        else:
            release = cast("RosDistro", distro)
            files = descriptions.moveit(
                *arms, name=name, distro=release, group=group, tip=tip, **looks
            )
        for path, text in files.items():
            target = output / path
            target.parent.mkdir(parents=True, exist_ok=True)
            write_whole(target, text)
            if text.startswith("#!"):
                target.chmod(0o755)
            say(target)
        if kind in {Format.URDF, Format.MOVEIT, Format.ROS1} and mesh_uri and meshes is None:
            folder = output / (package if kind is Format.ROS1 else "") / "meshes"
            folder.mkdir(parents=True, exist_ok=True)
            for file, content in descriptions.mesh_files(*arms).items():
                with whole_file(folder / file) as written:
                    written.write(content)
            say(folder)
    except (OSError, ParameterError) as error:
        fail(str(error), 2)


def _refuse_unused(context: typer.Context, kind: Format, *, moveit: bool) -> None:
    """Refuse options that the format does not have. Those of arm and tool are for every format."""
    if kind is Format.SRDF:
        refuse_unused(context, "urdf, mjcf, moveit and ros1", "meshes")
    if kind in {Format.SRDF, Format.MJCF}:
        refuse_unused(context, "urdf, moveit and ros1", "mesh_uri")
    if kind is not Format.MOVEIT:
        refuse_unused(context, "moveit", "distro")
    if kind is not Format.ROS1:
        refuse_unused(context, "ros1", "moveit")
    if kind is not Format.MOVEIT and not moveit:
        refuse_unused(context, "moveit, and for ros1 with --moveit", "group", "tip")


def _arms(
    models: Sequence[str],
    prefixes: Sequence[str],
    mountings: Sequence[str],
    tool: ToolDescription | None,
) -> list[ArmDescription]:
    from aioduco.descriptions import ArmDescription  # noqa: PLC0415
    from aioduco.errors import ParameterError  # noqa: PLC0415

    for option, given in (("prefix", prefixes), ("mounting", mountings)):
        if len(given) > len(models):
            raise ParameterError(option, ", ".join(given), "one for each --model at most")
    return [
        ArmDescription(model, prefix or "", _mounting(mounting or "floor"), tool)
        for model, prefix, mounting in zip_longest(models, prefixes, mountings)
    ]


def _mounting(text: str) -> MountingLike | None:
    if text == "none":
        return None
    return mounting_option(text)


def _tool(
    tcp: str | None, mass: float, centre: str, capsules: Sequence[str]
) -> ToolDescription | None:
    from aioduco.descriptions import Capsule, ToolDescription  # noqa: PLC0415

    middle = numbers("tool-centre", centre, 3)
    if any(middle) and mass == 0.0:
        raise typer.BadParameter("it is for --tool-mass", param_hint="--tool-centre")
    if tcp is None and mass == 0.0 and not capsules:
        return None
    parts = []
    for text in capsules:
        x, y, z, x2, y2, z2, radius = numbers("tool-capsule", text, 7)
        parts.append(Capsule((x, y, z), (x2, y2, z2), radius))
    return ToolDescription(
        mass=mass,
        centre=middle,
        tcp=numbers("tcp", tcp or "0,0,0,0,0,0", 6),
        parts=parts,
    )
