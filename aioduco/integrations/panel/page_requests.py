"""Requests of a page: its messages as checked values. No I/O."""

from __future__ import annotations

import json
from dataclasses import dataclass, fields
from functools import partial
from typing import TYPE_CHECKING, Any, Final, Literal, TypeAlias, get_args

from aioduco import Jog, JogFrame
from aioduco.errors import ParameterError

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence


#: joint speed of a motion to a target at 100 % [rad/s], and its acceleration [rad/s²]
JOINT_SPEED: Final = 1.0
JOINT_ACCELERATION: Final = 1.0
#: tool speed of a motion to a target at 100 % [m/s], and its acceleration [m/s²]
LINE_SPEED: Final = 0.25
LINE_ACCELERATION: Final = 0.5
#: length of the longest message of the page [bytes]
LONGEST: Final = 4096

_AXES: Final = ("x", "y", "z", "rx", "ry", "rz")

RobotVerb: TypeAlias = Literal["bring_up", "recover", "pause", "resume"]
Step: TypeAlias = Literal["touch", "ahead", "beside", "pose", "drop_touch", "drop_pose", "clear"]
Sensor: TypeAlias = Literal["torque", "force"]
Written: TypeAlias = Literal["tip", "load", "held"]


@dataclass(frozen=True, slots=True)
class JogMotion:
    """A jog, for as long as its button is held down."""

    jog: Jog

    def __str__(self) -> str:
        sign = "+" if self.jog.direction > 0 else "−"
        if self.jog.joint_space:
            return f"jog of joint {self.jog.axis + 1} {sign}"
        frame = self.jog.frame.name.lower().replace("_", " ")
        return f"jog along {_AXES[self.jog.axis]} {sign} of the {frame}"


@dataclass(frozen=True, slots=True)
class JointMotion:
    """Move to joint angles, as long as the button is held down.

    Attributes:
        joints: the target [rad], six.
        speed: speed of the joints [rad/s].
    """

    joints: tuple[float, ...]
    speed: float

    def __str__(self) -> str:
        return "move to joint angles"


@dataclass(frozen=True, slots=True)
class LineMotion:
    """Move to a pose on a line, as long as the button is held down.

    Attributes:
        pose: the target of the tool in the work object [m, rad], six.
        speed: speed of the tool [m/s].
    """

    pose: tuple[float, ...]
    speed: float

    def __str__(self) -> str:
        return "move on a line"


HoldMotion: TypeAlias = JogMotion | JointMotion | LineMotion


@dataclass(frozen=True, slots=True)
class PageStop:
    """Stop the arm. It needs no lease."""


@dataclass(frozen=True, slots=True, repr=False)
class TakeControl:
    """Give this page the lease. Its `repr` does not show the token.

    Attributes:
        token: the token that the page presents.
    """

    token: str

    def __repr__(self) -> str:
        return "TakeControl(…)"


@dataclass(frozen=True, slots=True)
class GiveBack:
    """End this page's lease."""


@dataclass(frozen=True, slots=True)
class Press:
    """A button that moves the arm is held down.

    Attributes:
        motion: the motion of the button.
        seen: number of the state that the page saw last.
    """

    motion: HoldMotion
    seen: int


@dataclass(frozen=True, slots=True)
class LetGo:
    """The button was released."""


@dataclass(frozen=True, slots=True)
class PageBeat:
    """A keep-alive message of the page.

    Attributes:
        seen: number of the state that the page saw last.
        down: whether a button is held down.
    """

    seen: int
    down: bool


@dataclass(frozen=True, slots=True)
class PageAim:
    """Show the arm at the joints of the sliders.

    Attributes:
        joints: the angles [rad], six; None to show nothing.
    """

    joints: tuple[float, ...] | None


@dataclass(frozen=True, slots=True)
class RobotAction:
    """Change the state of the arm: bring up, recover, pause, resume.

    Attributes:
        verb: what to do.
        seen: number of the state that the page saw last.
    """

    verb: RobotVerb
    seen: int


@dataclass(frozen=True, slots=True)
class SetOutput:
    """Set a digital output.

    Attributes:
        num: number of the output, from 1.
        on: whether to switch it on.
        tool: whether it is one of the tool, rather than of the cabinet.
        seen: number of the state that the page saw last.
    """

    num: int
    on: bool
    tool: bool
    seen: int


@dataclass(frozen=True, slots=True)
class SimulatorLine:
    """An action of a person at a simulated machine, in the syntax of `aioduco sim-do`."""

    line: str


@dataclass(frozen=True, slots=True)
class MeasureStep:
    """Read what a step of a measurement needs, or forget something.

    Attributes:
        step: a touch, a position for the tool's axes, a pose of a load, or what to forget.
        sensor: what is read of a load.
    """

    step: Step
    sensor: Sensor


@dataclass(frozen=True, slots=True)
class WriteMeasured:
    """Write a result of a measurement to the controller.

    Attributes:
        what: the tip of a tool, the load of a tool, or what the tool holds.
        name: name of the tool, for the first two.
    """

    what: Written
    name: str


PageRequest: TypeAlias = (
    PageStop
    | TakeControl
    | GiveBack
    | Press
    | LetGo
    | PageBeat
    | PageAim
    | RobotAction
    | SetOutput
    | SimulatorLine
    | MeasureStep
    | WriteMeasured
)


def page_request(text: str | bytes) -> PageRequest:
    """Read a message of a page.

    Args:
        text: a JSON object; its `ask` names the request.

    Raises:
        ParameterError: the message is no request, or a value has a wrong type or range.
    """
    try:
        return _read(text)
    except RecursionError:  # also raised by formatting the error message
        raise ParameterError("message", "…", "an object of JSON") from None


def _read(text: str | bytes) -> PageRequest:
    try:
        data = json.loads(text)
    except ValueError:
        raise ParameterError("message", "…", "an object of JSON") from None
    if not isinstance(data, dict):
        raise ParameterError("message", "…", "an object of JSON")
    ask = data.get("ask")
    kind: Any = _REQUESTS.get(ask) if isinstance(ask, str) else None
    if kind is None:
        raise ParameterError("ask", ask, f"one of {', '.join(_REQUESTS)}")
    request: PageRequest = kind(
        **{each.name: _READERS[each.name](each.name, data.get(each.name)) for each in fields(kind)}
    )
    return request


def _token(name: str, token: Any) -> str:
    if not isinstance(token, str):  # the error never contains the value
        raise ParameterError(name, "…", "a string")
    return token


def _motion(name: str, motion: Any) -> HoldMotion:
    if not isinstance(motion, dict):
        raise ParameterError(name, motion, "an object")
    kind = motion.get("kind")
    percent = _number("percent", motion.get("percent"), 1.0, 100.0)
    if kind == "jog":
        return JogMotion(_jog(motion, percent))
    if kind == "joints":
        return JointMotion(_six("joints", motion.get("to")), JOINT_SPEED * percent / 100)
    if kind == "line":
        speed = max(0.01, LINE_SPEED * percent / 100)
        return LineMotion(_six("pose", motion.get("to")), speed)
    raise ParameterError("kind", kind, "jog, joints or line")


def _jog(motion: dict[str, Any], percent: float) -> Jog:
    axis, direction = motion.get("axis"), motion.get("direction")
    if direction not in (-1, 1) or type(direction) is not int:
        raise ParameterError("direction", direction, "1 or -1")
    if isinstance(axis, str) and axis in _AXES:
        frames = {frame.name.lower(): frame for frame in JogFrame}
        name = motion.get("frame", "base")
        if not isinstance(name, str) or name not in frames:
            raise ParameterError("frame", name, f"one of {', '.join(frames)}")
        named: Any = axis
        return Jog.cartesian(named, direction, percent, frame=frames[name])
    return Jog.joint(_whole("axis", axis), direction, percent)


def _aim(name: str, given: Any) -> tuple[float, ...] | None:
    return None if given is None else _six(name, given)


def _printable(name: str, value: Any, most: int, rule: str) -> str:
    if not isinstance(value, str) or not value.isprintable() or len(value) > most:
        raise ParameterError(name, "…", rule)
    return value


def _one_of(name: str, value: Any, allowed: tuple[Any, ...]) -> Any:
    if not isinstance(value, str) or value not in allowed:
        raise ParameterError(name, value, f"one of {', '.join(allowed)}")
    return value


def _number(name: str, value: Any, low: float, high: float) -> float:
    if type(value) not in (int, float) or not low <= value <= high:  # NaN is in no range
        raise ParameterError(name, value, f"a number from {low:g} to {high:g}")
    return float(value)


def _whole(name: str, value: Any) -> int:
    if type(value) is not int or not 0 <= value < 1 << 53:
        raise ParameterError(name, value, "a whole number from 0")
    return value


def _flag(name: str, value: Any) -> bool:
    if type(value) is not bool:
        raise ParameterError(name, value, "true or false")
    return value


def _six(name: str, value: Any) -> tuple[float, ...]:
    if not isinstance(value, list) or len(value) != 6:
        raise ParameterError(name, value, "six numbers")
    numbers: Sequence[Any] = value
    return tuple(_number(name, number, -100.0, 100.0) for number in numbers)


#: what reads each field of a request
_READERS: Final[dict[str, Callable[[str, Any], Any]]] = {
    "token": _token,
    "motion": _motion,
    "seen": _whole,
    "down": _flag,
    "joints": _aim,
    "verb": partial(_one_of, allowed=get_args(RobotVerb)),
    "num": _whole,
    "on": _flag,
    "tool": _flag,
    "line": partial(_printable, most=200, rule="one printable line of at most 200 characters"),
    "step": partial(_one_of, allowed=get_args(Step)),
    "sensor": partial(_one_of, allowed=get_args(Sensor)),
    "what": partial(_one_of, allowed=get_args(Written)),
    "name": partial(_printable, most=32, rule="at most 32 printable characters"),
}
_REQUESTS: Final[dict[str, type[PageRequest]]] = {
    "stop": PageStop,
    "take": TakeControl,
    "give_back": GiveBack,
    "press": Press,
    "let_go": LetGo,
    "beat": PageBeat,
    "aim": PageAim,
    "do": RobotAction,
    "output": SetOutput,
    "simulator": SimulatorLine,
    "measure": MeasureStep,
    "write": WriteMeasured,
}
