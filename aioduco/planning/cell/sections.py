"""The sections of a cell's file: each a function from what TOML reads to values.

They compose the formats of the files that there are: robots, taught points, waypoints, envelopes,
and the arguments of a scene's things and of a gripper's driver. A wrong field raises `WrongField`
with its place in the file, from which `Cell` finds the line.
"""

from __future__ import annotations

import dataclasses
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Final, NoReturn, TypeAlias, cast

from aioduco.errors import ParameterError, SceneError
from aioduco.kinematics import arm as arm_of
from aioduco.kinematics import models
from aioduco.kinematics.catalogue import model_named
from aioduco.models.address import CELL_KEYS, RobotAddress, WrongAddress, robots_of
from aioduco.models.load import Load
from aioduco.models.points import Point, point_of
from aioduco.models.pose import Pose
from aioduco.models.ranges import JOINTS, PAYLOAD, POSE
from aioduco.models.similar import did_you_mean, unknown
from aioduco.planning.shapes import OWN_NAME, OWN_NAMES, Ground, Mesh
from aioduco.recording.playback.envelope_file import limit_of
from aioduco.sim.scene import (
    Box,
    Cylinder,
    MountingLike,
    Pad,
    Rod,
    Sphere,
    Table,
    Thing,
    mounting_of,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping
    from pathlib import Path

    from aioduco.envelope import EnvelopeLimit
    from aioduco.models.toml_lines import TomlPath


_KINDS: Final[dict[str, type[Thing]]] = {
    "box": Box,
    "sphere": Sphere,
    "cylinder": Cylinder,
    "rod": Rod,
    "pad": Pad,
    "table": Table,
    "ground": Ground,
    "mesh": Mesh,
}
#: what surrounds an arm, or is its tool: an MJCF file, or things
Surroundings: TypeAlias = str | tuple[Thing, ...]


_NO_TOOL: Final = Pose(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


class WrongField(Exception):
    """A field of the file is wrong.

    Attributes:
        place: its keys from the top of the file.
    """

    def __init__(self, place: TomlPath, text: str) -> None:
        super().__init__(text)
        self.place: TomlPath = place


@dataclasses.dataclass(frozen=True, slots=True, kw_only=True)
class CellRobot:
    """A robot of a cell.

    Attributes:
        name: its name.
        host: name or address of its controller.
        port: TCP port of the controller.
        model: its arm, such as "gcr5_910".
        mounting: where its base is in the world: "floor", "wall", "ceiling", or a pose [m, rad].
        pedestal: height of a column under it [m].
    """

    name: str
    host: str
    port: int
    model: str
    mounting: MountingLike = "floor"
    pedestal: float = 0.0


@dataclasses.dataclass(frozen=True, slots=True, kw_only=True)
class CellTool:
    """The tool of a cell's arms.

    Attributes:
        tcp: its tip in the frame of the flange [m, rad].
        load: its mass and centre of mass; None if the file does not have it.
        looks: what the flange carries: an MJCF file, or things, in the flange's frame.
    """

    tcp: Pose = _NO_TOOL
    load: Load | None = None
    looks: str | tuple[Thing, ...] | None = None


@dataclasses.dataclass(frozen=True, slots=True)
class CellScene:
    """What stands in a cell: an MJCF file or things, and the distance that plans keep from it."""

    looks: Surroundings | None = None
    padding: float = 0.005


@dataclasses.dataclass(frozen=True, slots=True)
class CellPoint:
    """A named point: joints, or a pose in a frame; an empty name stands for the arm's base."""

    point: Point
    frame: str = ""


# -- fields ------------------------------------------------------------------------------------


def wrong(place: TomlPath, text: str) -> NoReturn:
    """Refuse a field."""
    raise WrongField(place, text)


@contextmanager
def at(*place: str | int) -> Iterator[None]:
    """Name the place of what the readers of other formats refuse in this block."""
    try:
        yield
    except WrongAddress as error:
        raise WrongField((*place, *error.place), str(error)) from error
    except ParameterError as error:
        text = f"{error.parameter} is {error.value!r}, but must be {error.expected}"
        field = error.parameter.partition(" ")[0].partition("[")[0]
        raise WrongField((*place, field), text) from error
    except SceneError as error:
        raise WrongField(place, str(error)) from error


def table(place: TomlPath, value: Any, known: Iterable[str] | None = None) -> dict[str, Any]:
    """A table of the file, with known keys alone."""
    if not isinstance(value, dict):
        wrong(place, f"is to be a table: [{'.'.join(map(str, place))}]")
    if known is not None:
        only(place, value, known)
    return dict(value)


def only(place: TomlPath, found: Mapping[str, Any], known: Iterable[str]) -> None:
    """Refuse keys that are not known."""
    names = list(known)
    for key in found:
        if key not in names:
            wrong((*place, key), unknown(key, names, most=20))


def blocks(place: TomlPath, value: Any) -> list[dict[str, Any]]:
    """An array of tables of the file."""
    if not isinstance(value, list) or not all(isinstance(each, dict) for each in value):
        wrong(place, f"is to be tables: [[{'.'.join(map(str, place))}]]")
    return [dict(each) for each in value]


def kind_of(place: TomlPath, value: Any, known: Iterable[str]) -> None:
    """Refuse a kind that is missing or not known."""
    names = list(known)
    if value is None:
        wrong(place, f"is missing; there are {', '.join(names)}")
    if value not in names:
        wrong(place, f"kind {unknown(str(value), names)}")


def text(place: TomlPath, value: Any) -> str:
    """A text of the file, not empty."""
    if not isinstance(value, str) or not value:
        wrong(place, f"is {value!r}, but must be a text, not empty")
    return value


def _numbers(value: Any) -> bool:
    return isinstance(value, list) and all(type(each) in (int, float) for each in value)


def _pose(place: TomlPath, found: dict[str, Any], name: str) -> Pose | None:
    """A pose of a table: `name` [m, rad], or `name`_mm_deg; the field is taken out."""
    fields = {name: "pose", f"{name}_mm_deg": "pose_mm_deg"}
    given = [each for each in fields if each in found]
    if not given:
        return None
    if len(given) == 2:
        wrong((*place, given[1]), f"give {given[0]} or {given[1]}")
    key = given[0]
    with at(*place):
        point = _in_range(key, point_of(key, {fields[key]: found.pop(key)}))
    assert isinstance(point, Pose)
    return point


def _in_range(name: str, point: Point) -> Point:
    """Check a point as motions do: 20 rad or 120 m are degrees or millimetres."""
    rule = POSE if isinstance(point, Pose) else JOINTS
    rule(name, point)
    return point


# -- sections ----------------------------------------------------------------------------------


def model(place: TomlPath, value: Any) -> str:
    """The name of an arm's model, also as a controller writes it: "GCR5 910"."""
    name = text(place, value)
    found = model_named(name)
    if found is None:
        wrong(place, f"{name!r} is no arm{did_you_mean(name, models())}; see aioduco.kinematics")
    return found.name


def robots(value: Any, usual: str) -> tuple[dict[str, CellRobot], str]:
    """`[robots]`: as in robots.toml, and for each robot its model and mounting.

    Args:
        value: the section.
        usual: model of a robot that says none.

    Returns:
        The robots by name, and the name of the default; empty if there are several and none is it.
    """
    found = table(("robots",), value)
    with at("robots"):
        addresses, default = robots_of(found, also=CELL_KEYS)
    made = {name: _robot(each, found[name], usual) for name, each in addresses.items()}
    if not default and len(made) == 1:
        (default,) = made
    return made, default


def _robot(address: RobotAddress, entry: dict[str, Any], usual: str) -> CellRobot:
    place = ("robots", address.name)
    kind = model((*place, "model"), entry["model"]) if "model" in entry else usual
    if not kind:
        wrong(place, f'arm is missing: the model of the arm, such as arm = "{models()[0]}"')
    given: Any = entry.get("mounting", "floor")
    pedestal: Any = entry.get("pedestal", 0.0)
    if type(given) is not str and not (_numbers(given) and len(given) == 6):
        wrong((*place, "mounting"), f"is {given!r}, but must be a name or six numbers [m, rad]")
    if type(pedestal) not in (int, float):
        wrong((*place, "pedestal"), f"is {pedestal!r}, but must be a number [m]")
    with at(*place, "mounting"):
        mounting = cast("MountingLike", given) if isinstance(given, str) else Pose.of(given)
        mounting_of(mounting, arm_of(kind), pedestal)
    return CellRobot(
        name=address.name,
        host=address.host,
        port=address.port,
        model=kind,
        mounting=mounting,
        pedestal=float(pedestal),
    )


def tool(value: Any, folder: Path) -> CellTool:
    """`[tool]`: its tip, load and looks."""
    place = ("tool",)
    found = table(place, value, ("tcp", "tcp_mm_deg", "load", "file", "thing"))
    tip = _pose(place, found, "tcp")
    load = found.get("load")
    if load is not None:
        if not (_numbers(load) and len(load) in (1, 4)):
            wrong((*place, "load"), f"is {load!r}, but must be a mass [kg], or it and x, y, z [m]")
        with at(*place):
            load = PAYLOAD("load", Load(*load))
    return CellTool(
        tcp=_NO_TOOL if tip is None else tip,
        load=None if load is None else Load(*map(float, load)),
        looks=_looks(place, found, folder),
    )


def frames(value: Any) -> dict[str, Pose]:
    """`[frames.NAME]`: poses in the arm's base."""
    made = {}
    for name, entry in table(("frames",), value).items():
        place = ("frames", name)
        found = table(place, entry, ("pose", "pose_mm_deg"))
        pose = _pose(place, found, "pose")
        if pose is None:
            wrong(place, "needs pose [m, rad] or pose_mm_deg: where it is in the arm's base")
        made[name] = pose
    return made


def points(value: Any, known: Mapping[str, Pose]) -> dict[str, CellPoint]:
    """`[points.NAME]`: as `TaughtPoints` has them, a pose with the name of its frame."""
    made = {}
    for name, entry in table(("points",), value).items():
        if not name:
            wrong(("points", name), "a point needs a name")
        place = ("points", name)
        found = table(place, entry, ("joints", "joints_deg", "pose", "pose_mm_deg", "frame"))
        frame = found.pop("frame", "")
        if frame and (not isinstance(frame, str) or frame not in known):
            wrong((*place, "frame"), f"frame {unknown(str(frame), known)}")
        try:
            point = _in_range(name, point_of(name, found))
        except ParameterError as error:
            field = found if len(found) == 1 else ()
            wrong((*place, *field), f"is {error.value!r}, but must be {error.expected}")
        if frame and not isinstance(point, Pose):
            wrong((*place, "frame"), "joints have no frame: leave it out, or give a pose")
        made[name] = CellPoint(point, frame)
    return made


def scene(value: Any, folder: Path) -> CellScene:
    """`[scene]`: an MJCF file or `[[scene.thing]]`, and the padding."""
    found = table(("scene",), value, ("file", "thing", "padding"))
    padding = found.get("padding", 0.005)
    if type(padding) not in (int, float) or not 0.0005 <= padding <= 0.1:
        wrong(("scene", "padding"), f"is {padding!r}, but must be from 0.0005 to 0.1 m")
    return CellScene(_looks(("scene",), found, folder), float(padding))


def limits(value: Any, names: Iterable[str]) -> list[tuple[str, EnvelopeLimit]]:
    """`[[limit]]`: as in a file of an envelope, each for all robots or for one.

    Returns:
        For each limit the name of its robot, empty for all, and the limit.
    """
    made = []
    for number, block in enumerate(blocks(("limit",), value)):
        robot = block.pop("robot", "")
        if robot and (not isinstance(robot, str) or robot not in names):
            wrong(("limit", number, "robot"), f"robot {unknown(str(robot), names)}")
        with at("limit", number):
            made.append((robot, limit_of(f"limit {number + 1}", block)))
    return made


def _looks(place: TomlPath, found: dict[str, Any], folder: Path) -> Surroundings | None:
    """An MJCF file, or things."""
    file, listed = found.get("file"), found.get("thing")
    if file is not None and listed is not None:
        wrong((*place, "file"), "give a file or things, not both")
    if file is not None:
        return _file((*place, "file"), file, folder)
    if listed is None:
        return None
    made: list[Thing] = []
    for number, block in enumerate(blocks((*place, "thing"), listed)):
        where = (*place, "thing", number)
        if block.get("kind") == "mesh":
            block.setdefault("name", f"mesh{number + 1}")
        thing = _thing(where, block, folder)
        if thing.name and any(each.name == thing.name for each in made):
            wrong((*where, "name"), f"there is a thing called {thing.name!r} already")
        if place == ("scene",) and thing.name in OWN_NAMES:
            wrong((*where, "name"), OWN_NAME.format(thing.name))
        made.append(thing)
    return tuple(made)


def _thing(place: TomlPath, block: dict[str, Any], folder: Path) -> Thing:
    kind = block.pop("kind", None)
    kind_of((*place, "kind"), kind, _KINDS)
    make: Callable[..., Thing] = _KINDS[kind]
    fields = [each.name for each in dataclasses.fields(_KINDS[kind]) if each.name != "vertices"]
    only(place, block, fields)
    if "file" in block:
        block["file"] = _file((*place, "file"), block["file"], folder)
    made: dict[str, Any] = {
        key: tuple(each) if isinstance(each, list) else each for key, each in block.items()
    }
    with at(*place):
        try:
            return make(**made)
        except (TypeError, ValueError) as error:
            if isinstance(error, ParameterError):
                raise
            wrong(place, f"a {kind} cannot be made of {made}: {error}")


def _file(place: TomlPath, value: Any, folder: Path) -> str:
    path = folder / text(place, value)
    if not path.is_file():
        wrong(place, f"the file {path} does not exist")
    return str(path.resolve())
