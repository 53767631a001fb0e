"""A cell in one file: reading it whole, and what is made of it."""

from __future__ import annotations

import math
from collections.abc import AsyncIterator, Iterator, Mapping
from contextlib import AbstractAsyncContextManager, AsyncExitStack, asynccontextmanager
from typing import TYPE_CHECKING, Any, Final

from aioduco.errors import CellFileError, ParameterError, WaypointFileError
from aioduco.models.gripper_models import GRIPPERS
from aioduco.models.points import Point, TaughtPoints
from aioduco.models.pose import Joints, Pose
from aioduco.models.ranges import FILE, OWN_NAME
from aioduco.models.similar import did_you_mean, unknown
from aioduco.models.toml_files import key_text, listed, parse_toml, quoted, read_text, rewrite
from aioduco.models.toml_lines import Statement, key_end, line_of, statements
from aioduco.planning.cell import sections
from aioduco.planning.cell.sections import CellRobot, CellTool, WrongField
from aioduco.recording.playback.waypoints import WaypointFile

if TYPE_CHECKING:
    import os
    from pathlib import Path

    from aioduco.envelope import Envelope
    from aioduco.planning.cell.grippers import CellGripper
    from aioduco.planning.scene import Scene
    from aioduco.robot import Robot
    from aioduco.sim.simulator import Simulator


#: sections of the file besides those of waypoints
_OWN: Final = ("robots", "tool", "gripper", "frames", "points", "scene", "limit")
_SECTIONS: Final = ("arm", *_OWN, "defaults", "waypoint")


class Cell(Mapping[str, Point]):
    """The cell of a TOML file (工作单元): its named points as a mapping, and all else in it.

        cell = Cell.load("cell.toml")
        async with cell.connect() as robot:
            await robot.motion.movej2(cell.joints("ready"), v=1.0, a=2.0)

    Everything is checked when the file is read; an error has the file and the line. `cell["pick"]`
    is joints [rad], or a pose in the arm's base [m, rad].

    Args:
        text: the text of the file.
        path: path of the file: its name in errors, and the folder of the files that it names.

    Attributes:
        path: path of the file.
        text: the text.
        arm: model of the arms that say none, such as "gcr5_910"; empty without one.
        robots: the robots by name.
        tool: the tool.
        gripper: the gripper; None without one.
        frames: frames by name, in the arm's base [m, rad].
        waypoints: the waypoints, for `run_waypoints`.

    Raises:
        CellFileError: the text is no TOML, or a field is wrong.
    """

    path: Path
    text: str
    arm: str
    robots: dict[str, CellRobot]
    tool: CellTool
    gripper: CellGripper | None
    frames: dict[str, Pose]
    waypoints: WaypointFile

    def __init__(self, text: str, path: str | os.PathLike[str] = "cell.toml") -> None:
        self.path = FILE("path", path)
        # what is saved later goes there, even if the working directory is another one then
        self._file = self.path.absolute()
        self._take(text)

    def _take(self, text: str) -> None:
        """Read everything, or nothing."""
        try:
            found, folder = parse_toml(text), self._file.parent
            sections.only((), found, _SECTIONS)
            arm = sections.model(("arm",), found["arm"]) if found.get("arm", "") != "" else ""
            robots, default = sections.robots(found.get("robots", {}), arm)
            if not arm and not robots and {"limit", "scene"} & found.keys():
                sections.wrong((), 'arm is missing: the model of the arm, such as arm = "gcr5_910"')
            gripper = None
            if "gripper" in found:
                from aioduco.planning.cell.grippers import gripper as gripper_of  # noqa: PLC0415

                gripper = gripper_of(found["gripper"])
            frames = sections.frames(found.get("frames", {}))
            tool = sections.tool(found.get("tool", {}), folder)
            points = sections.points(found.get("points", {}), frames)
            scene = sections.scene(found.get("scene", {}), folder)
            limits = sections.limits(found.get("limit", []), robots)
            waypoints = WaypointFile(text, str(self.path), beside=_OWN)
        except WrongField as error:
            where = ".".join(map(_shown, error.place))
            line = line_of(text, error.place)
            raise CellFileError(f"{self.path}, line {line}: {where}: {error}") from error.__cause__
        except WaypointFileError as error:
            raise CellFileError(str(error)) from error
        except ValueError as error:
            raise CellFileError(f"{self.path} is no TOML: {error}") from error
        self.text, self.waypoints = text, waypoints
        self.arm, self.robots, self._default = arm, robots, default
        self.tool, self.gripper, self.frames = tool, gripper, frames
        self._points, self._scene, self._limits = points, scene, limits

    def __repr__(self) -> str:
        named = f"{len(self.robots)} robots, {len(self)} points"
        return f"<Cell {self.path}: {named}, {len(self.waypoints.waypoints)} waypoints>"

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Cell):
            return NotImplemented
        return (self.path, self.text) == (other.path, other.text)

    def __hash__(self) -> int:
        return hash(self.path)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Cell:
        """Read a file.

        Args:
            path: the file.

        Raises:
            CellFileError: the file cannot be read, or a field is wrong; the message has the line.
        """
        try:
            text = read_text(path)
        except (OSError, ValueError) as error:
            raise CellFileError(f"{path} cannot be read: {error}") from error
        return cls(text, path)

    # -- points --------------------------------------------------------------------------------

    def __getitem__(self, name: str) -> Point:
        if name not in self._points:
            raise KeyError(f"{self.path}: point {unknown(str(name), self._points)}")
        point, frame = self._points[name].point, self._points[name].frame
        return self.frames[frame] @ point if frame and isinstance(point, Pose) else point

    def __iter__(self) -> Iterator[str]:
        return iter(self._points)

    def __len__(self) -> int:
        return len(self._points)

    def joints(self, name: str) -> Joints:
        """Return the joint angles of this name [rad].

        Raises:
            ParameterError: there is no such point, or it is a pose.
        """
        return TaughtPoints(self).joints(name)

    def pose(self, name: str) -> Pose:
        """Return the pose of this name in the arm's base [m, rad].

        Raises:
            ParameterError: there is no such point, or it is joint angles.
        """
        return TaughtPoints(self).pose(name)

    def teach(self, name: str, point: Point) -> None:
        """Set a named point, also one that there is not yet; `save` writes it to the file.

        Comments, order and all other text are kept. A point that has a frame keeps it: the pose is
        stored in that frame.

        Args:
            name: name of the point.
            point: joints [rad], or a pose in the arm's base [m, rad].

        Raises:
            ParameterError: the name is no text of one line, or the point is neither of the two.
            CellFileError: the text cannot take the point; nothing was changed.
        """
        OWN_NAME("name", name)
        if not isinstance(point, Joints | Pose):
            raise ParameterError("point", point, "a Joints or a Pose")
        frame = self._points[name].frame if name in self._points else ""
        if frame and not isinstance(point, Pose):
            raise ParameterError("point", point, f"a Pose: {name} is in the frame {frame}")
        stored = point
        if frame and isinstance(point, Pose):
            stored = self.frames[frame].inverse() @ point
        before = self.text
        newline = "\r\n" if "\r\n" in before else "\n"
        text = _with_point(before.replace("\r\n", "\n"), name, _field(stored), frame)
        unwritten = f"{self.path}: {name} cannot be written there; nothing was changed"
        try:
            self._take(text.replace("\n", newline))
        except CellFileError as error:
            raise CellFileError(f"{unwritten} ({error})") from error
        if name not in self._points or self._points[name].frame != frame:
            self._take(before)
            raise CellFileError(unwritten)

    def save(self, path: str | os.PathLike[str] | None = None) -> None:
        """Write the text to a file completely or not at all.

        Args:
            path: the file; None for the one that was read. An existing file keeps its mode and its
                line ends, and stays the target of symbolic links.

        Raises:
            CellFileError: it cannot be written; an existing one stays unchanged.
        """
        target = self._file if path is None else path
        try:
            rewrite(target, self.text)
        except OSError as error:
            raise CellFileError(f"{target} cannot be written: {error}") from error

    # -- robots --------------------------------------------------------------------------------

    def robot(self, name: str | None = None) -> CellRobot:
        """The robot of a name.

        Args:
            name: its name; None for the default, or the only one.

        Raises:
            ParameterError: there is no such robot, or several and none is the default.
        """
        wanted = self._default if name is None else name
        if not isinstance(wanted, str) or wanted not in self.robots:
            listed = ", ".join(self.robots) or "none"
            near = did_you_mean(wanted, self.robots)
            raise ParameterError("robot", name, f"a robot of {self.path}: {listed}{near}")
        return self.robots[wanted]

    def connect(self, name: str | None = None, **options: Any) -> Robot:
        """Create a robot of the cell, kept within the cell's limits; `async with` connects to it.

        Args:
            name: name of the robot; None for the default, or the only one.
            **options: as of `aioduco.connect`; `host` and `port` for another address, such as a
                simulator's.

        Raises:
            ParameterError: there is no such robot, or an option is out of range.
        """
        from aioduco.robot import connect  # noqa: PLC0415 - for robots alone

        robot = self.robot(name)
        made = connect(**{"host": robot.host, "port": robot.port, **options})
        made.envelope = self.envelope(robot.name)
        return made

    def connect_all(
        self, *names: str, **options: Any
    ) -> AbstractAsyncContextManager[dict[str, Robot]]:
        """Connect to several robots: `async with cell.connect_all() as robots`.

        At the end of the block all of them are left standing.

        Args:
            *names: their names; none for all.
            **options: as of `aioduco.connect`, for each of them.

        Raises:
            ParameterError: there is no such robot, or an option is out of range.
            ConnectError: one of them cannot be reached; those before it are closed again.
        """
        made = {name: self.connect(name, **options) for name in names or self.robots}
        return _opened(made)

    # -- what surrounds an arm -------------------------------------------------------------------

    def envelope(self, name: str | None = None) -> Envelope | None:
        """The limits of a robot; None if the file has none for it.

        Args:
            name: name of the robot; None for the default, or for the arm without a robot.
        """
        from aioduco.envelope import Envelope  # noqa: PLC0415 - loads NumPy

        robot = self._robot_or_arm(name)
        kept = [limit for each, limit in self._limits if each in ("", robot.name)]
        return Envelope(robot.model, *kept) if kept else None

    def scene(self, name: str | None = None) -> Scene:
        """The planning scene of a robot: its arm, tool or gripper, and surroundings.

        A gripper is there, with open fingers, if the file does not say what the tool looks like.

        Args:
            name: name of the robot; None for the default, or for the arm without a robot.

        Raises:
            SceneError: the scene cannot be made.
        """
        from aioduco.planning.scene import Scene  # noqa: PLC0415 - for planning alone

        robot, looks = self._robot_or_arm(name), self._scene.looks
        tool = self.tool.looks
        if tool is None and self.gripper is not None:
            from aioduco.sim.physics.gripper import gripper_mjcf  # noqa: PLC0415 - for it alone

            tool = gripper_mjcf(GRIPPERS[self.gripper.kind])
        return Scene(
            robot.model,
            () if looks is None or isinstance(looks, str) else looks,
            around=looks if isinstance(looks, str) else None,
            tool=tool,
            mounting=robot.mounting,
            pedestal=robot.pedestal,
            padding=self._scene.padding,
        )

    def simulator(self, name: str | None = None, **options: Any) -> Simulator:
        """A simulator of a robot, not started: its arm, tool or gripper, and surroundings.

        A gripper takes the place of the tool's looks: it has fingers that hold parts.

        Args:
            name: name of the robot; None for the default, or for the arm without a robot.
            **options: as of `Simulator`; they replace what the cell says.

        Raises:
            SceneError: a part of the cell is not one of a simulator.
        """
        from aioduco.sim import Simulator  # noqa: PLC0415 - MuJoCo is for simulators alone

        return Simulator(**{**self.simulator_options(name), **options})

    def simulator_options(self, name: str | None = None) -> dict[str, Any]:
        """The arguments of `Simulator` for a robot, as of `simulator`."""
        robot, looks = self._robot_or_arm(name), self._scene.looks
        found: dict[str, Any] = {
            "model": robot.model,
            "mounting": robot.mounting,
            "pedestal": robot.pedestal,
            "scene": looks,
            "tool": None if self.gripper is not None else self.tool.looks,
            "gripper": None if self.gripper is None else self.gripper.kind,
        }
        return {key: value for key, value in found.items() if value is not None}

    def _robot_or_arm(self, name: str | None) -> CellRobot:
        """A robot of the file, or the arm of a file without robots."""
        if self.robots or name is not None:
            return self.robot(name)
        if not self.arm:
            raise ParameterError("arm", self.arm, f"given in {self.path}")
        return CellRobot(name="", host="", port=0, model=self.arm)


@asynccontextmanager
async def _opened(robots: dict[str, Robot]) -> AsyncIterator[dict[str, Robot]]:
    async with AsyncExitStack() as stack:
        for robot in robots.values():
            await stack.enter_async_context(robot)
        yield robots


def _shown(part: str | int) -> str:
    return str(part + 1) if isinstance(part, int) else part


# -- the text ------------------------------------------------------------------------------------


def _field(point: Point) -> str:
    """A point as a field of the file."""
    turned = [math.degrees(each) for each in (point if isinstance(point, Joints) else point[3:])]
    if isinstance(point, Joints):
        return f"joints_deg = [{listed(turned)}]"
    return f"pose_mm_deg = [{listed([*(each * 1e3 for each in point[:3]), *turned])}]"


def _with_point(text: str, name: str, field: str, frame: str) -> str:
    """The text with a point: the fields of one that is there are replaced, a new one follows."""
    here = ("points", name)
    lines = text.split("\n")
    said = [each for each in statements(text) if each.path[: len(here)] == here]
    for each in said:
        if each.path == here and each.value is not None:  # an inline table
            inner = f"{field}, frame = {quoted(frame)}" if frame else field
            return _replaced(lines, each, f"{{ {inner} }}")
    for each in said:
        if len(each.path) == 3 and each.path[2] != "frame":
            key, _, value = field.partition(" = ")
            return _replaced(lines, each, value, (str(each.path[2]), key))
    if said:
        return text
    gap = "" if text.endswith("\n") or not text else "\n"
    return f"{text}{gap}\n[points.{key_text(name)}]\n{field}\n"


def _replaced(
    lines: list[str], old: Statement, value: str, keys: tuple[str, str] | None = None
) -> str:
    """The text with another value, and key, in a statement; its comment is kept."""
    comment = _comment(old.text)
    begin = old.text[: key_end(old.text)]
    if keys is not None:
        before, found, _ = begin.rpartition(keys[0])
        before = before.removesuffix('"').removesuffix("'")
        begin = f"{before if found else begin}{keys[1]} "
    made = f"{begin.rstrip()} = {value}{'  ' + comment if comment else ''}"
    return "\n".join([*lines[: old.begin - 1], *made.split("\n"), *lines[old.end :]])


def _comment(statement: str) -> str:
    """The comment behind a statement."""
    end = statement.find("#")
    while end >= 0:
        try:
            parse_toml(statement[:end])
        except ValueError:
            end = statement.find("#", end + 1)
        else:
            return statement[end:]
    return ""
