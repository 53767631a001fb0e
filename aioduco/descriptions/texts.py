"""Descriptions of one arm, or of several in one world, as the texts of files."""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias, get_args

from aioduco.descriptions.meshes import find_meshes, own_meshes, stl
from aioduco.descriptions.mjcf_text import mjcf_text
from aioduco.descriptions.moveit_files import RosDistro, moveit_files
from aioduco.descriptions.srdf_text import GROUP, srdf_text
from aioduco.descriptions.tree import WORD, ArmDescription, ArmTree
from aioduco.descriptions.urdf_text import urdf_text
from aioduco.errors import ParameterError
from aioduco.kinematics.arm import Arm
from aioduco.kinematics.looks import merged
from aioduco.models.words import one_of

if TYPE_CHECKING:
    import os


ArmLike: TypeAlias = str | Arm | ArmDescription
"""A model, such as "gcr5_910", an arm with numbers of its own, or one with prefix and tool."""

_URDF_KINDS = (".dae", ".stl", ".obj")
_MJCF_KINDS = (".obj", ".stl")


def urdf(
    *arms: ArmLike,
    name: str | None = None,
    meshes: str | os.PathLike[str] | None = None,
    mesh_uri: str | None = None,
) -> str:
    """Return the URDF of an arm, or of several in one world.

    Links are `base_link`, `link_1` to `link_6`, and by REP 199 `base`, `flange` and `tool0`; with a
    tool also `tool` and `tcp`. The pose of `tool0` in `base` is the one that `Arm.fkine` and the
    controller return. Joints are `joint_1` to `joint_6`.

    Args:
        arms: for each arm a model such as "gcr5_910", an `Arm`, or an `ArmDescription` with prefix,
            mounting and tool.
        name: name of the robot; by default the models' names.
        meshes: folder of your own meshes in metres, named like the links: `link_1.dae`, `.stl` or
            `.obj`. They replace the visual shapes; the collision shapes stay.
        mesh_uri: URI of the meshes in the file, such as "package://my_arm/meshes"; by default
            `file://` and the folder. Without `meshes`, those of `mesh_files` are meant. Without
            both, the visual shapes are cylinders.

    Raises:
        ParameterError: there is no such model or mounting; two arms have the same prefix; the name
            or a prefix is not a word; no mesh is named like a link.
    """
    whole, trees = _take(arms, name)
    return urdf_text(whole, trees, _addresses(trees, meshes, mesh_uri))


def srdf(*arms: ArmLike, name: str | None = None) -> str:
    """Return the SRDF of an arm, or of several in one world.

    It has, for each arm, the groups `manipulator` and `end_effector`, the configurations `home`,
    `ahead` and `up`, and the pairs of links whose collisions are disabled: neighbours, and pairs
    that never or always touch in 10,000 random configurations.

    Args:
        arms: as for `urdf`.
        name: as for `urdf`; it must be the same in both files.

    Raises:
        ParameterError: as for `urdf`.
    """
    return srdf_text(*_take(arms, name))


def mesh_files(*arms: ArmLike) -> dict[str, bytes]:
    """Return the looks of an arm, or of several, as meshes for `urdf(..., mesh_uri=...)`.

    They are turned and lofted from the arms' lengths: housings, caps with marks, tubes, a flange.

    Args:
        arms: as for `urdf`.

    Returns:
        Binary STL files in metres and in the frames of the links, one for each link and colour, by
        their names, such as `link_1_cap.stl`.

    Raises:
        ParameterError: as for `urdf`.
    """
    _, trees = _take(arms, "arms")
    names = own_meshes(trees)
    return {
        names[link.name][colour]: stl(points, faces)
        for tree in trees
        for link in tree.links
        for colour, (points, faces) in merged(link.looks).items()
    }


def mjcf(
    *arms: ArmLike,
    name: str | None = None,
    meshes: str | os.PathLike[str] | None = None,
) -> str:
    """Return the MJCF of an arm, or of several in one world.

    It follows the conventions of MuJoCo Menagerie. Bodies, joints and frames have the names of the
    URDF, position servos those of their joints. Its meshes are in the text. It has the keyframes
    `home`, `ahead` and `up`, but no floor and no light.

    Args:
        arms: as for `urdf`.
        name: as for `urdf`.
        meshes: as for `urdf`, `.obj` or `.stl`.

    Raises:
        ParameterError: as for `urdf`.
    """
    whole, trees = _take(arms, name)
    return mjcf_text(whole, trees, find_meshes(meshes, trees, _MJCF_KINDS))


def moveit(
    *arms: ArmLike,
    name: str | None = None,
    meshes: str | os.PathLike[str] | None = None,
    mesh_uri: str | None = None,
    distro: RosDistro = "jazzy",
    group: str = GROUP,
    tip: str = "",
) -> dict[str, str]:
    """Return MoveIt's configuration of an arm, or of several in one world.

    It contains URDF, SRDF, and the parameters of kinematics, joint limits, OMPL and controllers, as
    the files of a package's folder `config`.

    Args:
        arms: as for `urdf`.
        name: as for `urdf`.
        meshes: as for `urdf`.
        mesh_uri: as for `urdf`.
        distro: release of ROS: "jazzy" or "humble", or "noetic" for MoveIt 1.
        group: name of the group of an arm's joints, after its prefix.
        tip: link at which the group ends, after the prefix, such as "link_6"; empty: the tool's tip
            or the flange.

    Returns:
        The texts of the files by their names.

    Raises:
        ParameterError: as for `urdf`; or there is no such release or link.
    """
    one_of("distro", distro, get_args(RosDistro))
    if not isinstance(group, str) or not WORD.fullmatch(group):
        raise ParameterError("group", group, "a word of letters, digits and _")
    whole, trees = _take(arms, name)
    links = {link.name for tree in trees for link in tree.links}
    if tip != "" and not {f"{tree.arm.prefix}{tip}" for tree in trees} <= links:
        raise ParameterError("tip", tip, f"one of {', '.join(sorted(links))}, without a prefix")
    uris = _addresses(trees, meshes, mesh_uri)
    return moveit_files(whole, trees, uris, distro, group=group, tip=tip)


def _take(arms: tuple[ArmLike, ...], name: str | None) -> tuple[str, list[ArmTree]]:
    described = [arm if isinstance(arm, ArmDescription) else ArmDescription(arm) for arm in arms]
    if not described:
        raise ParameterError("arms", "none", "at least one arm")
    prefixes = [arm.prefix for arm in described]
    if len(set(prefixes)) < len(prefixes):
        raise ParameterError("prefix", prefixes, "a different one for each arm")
    whole = "_".join(arm.arm.name for arm in described) if name is None else name
    if not isinstance(whole, str) or not WORD.fullmatch(whole):
        raise ParameterError("name", whole, "a word of letters, digits and _")
    return whole, [arm.tree() for arm in described]


def _addresses(
    trees: list[ArmTree], meshes: str | os.PathLike[str] | None, uri: str | None
) -> dict[str, dict[str, str]]:
    """Return the URIs of meshes: by link, by colour; "" for colours of their own."""
    if uri is not None and not isinstance(uri, str):
        raise ParameterError("mesh_uri", uri, 'a text, such as "package://my_arm/meshes", or None')
    if meshes is None:
        if uri is None:
            return {}
        return {
            link: {colour: f"{uri.rstrip('/')}/{file}" for colour, file in files.items()}
            for link, files in own_meshes(trees).items()
        }
    found = find_meshes(meshes, trees, _URDF_KINDS)
    return {
        link: {"": path.as_uri() if uri is None else f"{uri.rstrip('/')}/{path.name}"}
        for link, path in found.items()
    }
