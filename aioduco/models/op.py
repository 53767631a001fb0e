"""Outputs that are set during a motion (Op, manual 1.3.5): `Op`, its targets, `PointOp`.

    op = Op.at_start(output(3), time=0.2) | Op.near_end(output(3), False, distance=0.05)

Times are seconds and distances metres here; the wire has milliseconds.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

from aioduco._wire import rpc
from aioduco.errors import ParameterError
from aioduco.models import ranges
from aioduco.models.pose import Joints, Pose, PoseLike
from aioduco.models.rules import LONGEST_ARM, Integer, Number, Real, Whole

__all__ = [
    "ControllerEvent",
    "Op",
    "Output",
    "PointOp",
    "Trigger",
    "bool_register",
    "event",
    "float_register",
    "output",
    "tool_output",
    "word_register",
]

#: the wire has a signed byte for the index (Op.trig_io_1 to _3)
_MAX_INDEX = 127

_SOURCE = "1.3.5"
_AFTER_TIME = Number(0.0, unit="s", source=_SOURCE)
#: no trigger is meant farther along a path: across what the longest arm reaches [m]
_LONGEST_PATH = 2 * LONGEST_ARM
_AFTER_DISTANCE = Number(0.0, unit="m", plausible=_LONGEST_PATH, source=_SOURCE)
_SIGNED_TIME = Number(unit="s", source=_SOURCE)
_SIGNED_DISTANCE = Number(unit="m", plausible=_LONGEST_PATH, source=_SOURCE)


@dataclass(frozen=True, slots=True)
class Output:
    """An output or register of the controller, as a trigger's target.

    Make one by `output`, `bool_register`, `word_register`, `float_register` or `tool_output`.

    Attributes:
        kind: kind of output or register, in words.
        num: number within its kind, from 1.
        index: number among all targets (manual 1.3.5).
    """

    kind: str
    num: int
    index: int

    def __str__(self) -> str:
        return f"{self.kind} {self.num}"


@dataclass(frozen=True, slots=True)
class ControllerEvent:
    """An event of the controller's event function, as a trigger's target.

    Attributes:
        name: the event's name, which must be defined on the controller beforehand.
    """

    name: str

    def __str__(self) -> str:
        return f"event {self.name!r}"


Target: TypeAlias = Output | ControllerEvent


def _target(kind: str, first: int, count: int, num: Whole) -> Output:
    number = Integer(1, count, source=_SOURCE)("num", num)
    return Output(kind, number, first + number - 1)


def output(num: Whole) -> Output:
    """Name a general output of the cabinet (控制柜通用 IO 输出), 1 to 16."""
    return _target("cabinet output", 1, 16, num)


def bool_register(num: Whole) -> Output:
    """Name a bool register, 1 to 64. The wire of manual 3.8 carries triggers of 1 to 27."""
    return _target("bool register", 101, 64, num)


def word_register(num: Whole) -> Output:
    """Name a word register, 1 to 32. The wire of manual 3.8 carries no trigger of them."""
    return _target("word register", 201, 32, num)


def float_register(num: Whole) -> Output:
    """Name a float register, 1 to 32. The wire of manual 3.8 carries no trigger of them."""
    return _target("float register", 301, 32, num)


def tool_output(num: Whole) -> Output:
    """Name an output of the tool, 1 or 2. The wire of manual 3.8 carries no trigger of them."""
    return _target("tool output", 401, 2, num)


def event(name: str) -> ControllerEvent:
    """Name an event, which must be defined on the controller beforehand."""
    return ControllerEvent(ranges.LONG_NAME("name", name))


@dataclass(frozen=True, slots=True)
class Trigger:
    """An output or event that is set, and the point of the motion at which it is set.

    Attributes:
        target: the output or event.
        value: the level; without meaning for an event.
        by: whether `amount` is a time or a distance.
        amount: time or distance after the start or before the end [s or m].
    """

    target: Target
    value: bool
    by: Literal["time", "distance"]
    amount: float


def _trigger(
    target: Target,
    value: bool,
    time: Real | None,
    distance: Real | None,
    rules: tuple[Number, Number],
) -> Trigger:
    if not isinstance(target, (Output, ControllerEvent)):
        raise ParameterError("target", target, "an output or an event: output(3), event('name')")
    if isinstance(target, Output) and target.index > _MAX_INDEX:
        raise ParameterError(
            "target",
            str(target),
            f"an output with an index up to {_MAX_INDEX}: its index, {target.index}, does not fit "
            "the signed byte that the wire has for it; define an event that sets it, and trigger "
            "that by event(name)",
        )
    level = ranges.FLAG("value", value)
    if distance is None:
        return Trigger(target, level, "time", rules[0]("time", 0.0 if time is None else time))
    if time is not None:
        raise ParameterError("distance", distance, "left out when a time is given")
    return Trigger(target, level, "distance", rules[1]("distance", distance))


@dataclass(frozen=True, slots=True)
class Op:
    """Outputs that a motion sets: at most one each after its start, around its end, and on a stop.

    Combine several by `|`. An `Op()` sets nothing. Manual section 1.3.5.

    Attributes:
        start: set some time or distance after the start.
        end: set some time or distance before the end, or after it.
        stop: set when the motion is paused or stopped.

    Raises:
        ParameterError: one of them is no trigger.
    """

    start: Trigger | None = None
    end: Trigger | None = None
    stop: Trigger | None = None

    def __post_init__(self) -> None:
        for name in ("start", "end", "stop"):
            if not isinstance(given := getattr(self, name), Trigger | None):
                made = "one that Op.at_start, Op.near_end or Op.on_stop has made, or None"
                raise ParameterError(name, given, made)

    @classmethod
    def at_start(
        cls,
        target: Target,
        value: bool = True,
        *,
        time: Real | None = None,
        distance: Real | None = None,
    ) -> Op:
        """Set an output some time or some distance after the motion's start.

        Args:
            target: output or event to set: `output(3)`, `bool_register(12)`, `event("name")`.
            value: the level.
            time: time after the start [s], at least 0; 0 if neither is given.
            distance: distance along the path after the start [m], at least 0. Joint motions refuse
                distances, since the controller ignores them there.

        Raises:
            ParameterError: a value out of range, or a target that the wire cannot carry.
        """
        rules = (_AFTER_TIME, _AFTER_DISTANCE)
        return cls(start=_trigger(target, value, time, distance, rules))

    @classmethod
    def near_end(
        cls,
        target: Target,
        value: bool = True,
        *,
        time: Real | None = None,
        distance: Real | None = None,
    ) -> Op:
        """Set an output some time or some distance before the motion's end, or after it.

        Args:
            target: output or event to set: `output(3)`, `bool_register(12)`, `event("name")`.
            value: the level.
            time: time before the end [s], negative for after the end; 0 if neither is given.
            distance: distance before the end [m], negative for after the end. Joint motions refuse
                distances, since the controller ignores them there.

        Raises:
            ParameterError: a value out of range, or a target that the wire cannot carry.
        """
        rules = (_SIGNED_TIME, _SIGNED_DISTANCE)
        return cls(end=_trigger(target, value, time, distance, rules))

    @classmethod
    def on_stop(cls, target: Target, value: bool = True, *, time: Real | None = None) -> Op:
        """Set an output when the motion is paused or stopped.

        The controller has no trigger by distance here.

        Args:
            target: output or event to set: `output(3)`, `bool_register(12)`, `event("name")`.
            value: the level.
            time: time before the arm stands [s], negative for after that; 0 if not given.

        Raises:
            ParameterError: a value out of range, or a target that the wire cannot carry.
        """
        return cls(stop=_trigger(target, value, time, None, (_SIGNED_TIME, _SIGNED_DISTANCE)))

    def __or__(self, other: Op) -> Op:
        if not isinstance(other, Op):
            return NotImplemented
        parts: dict[str, Trigger | None] = {}
        for name in ("start", "end", "stop"):
            mine, theirs = getattr(self, name), getattr(other, name)
            if mine is not None and theirs is not None:
                raise ParameterError(
                    name,
                    f"{mine.target} and {theirs.target}",
                    "one trigger: the wire has one of each per motion",
                )
            parts[name] = mine or theirs
        return Op(**parts)

    def wire(self, name: str = "op", *, joint_motion: bool = False) -> rpc.Op:
        """Return the struct of the wire.

        Args:
            name: the parameter's name, for errors.
            joint_motion: whether it belongs to a joint motion, in which the controller ignores
                distances.

        Raises:
            ParameterError: a trigger by distance in a joint motion.
        """
        made = rpc.Op()
        for number, trigger in enumerate((self.start, self.end, self.stop), 1):
            if trigger is None:
                continue
            distance = trigger.by == "distance"
            if distance and joint_motion:
                raise ParameterError(
                    name,
                    f"a trigger of {trigger.target} by distance",
                    "by time: in a motion of the joints a distance is without effect",
                )
            setattr(made, f"time_or_dist_{number}", 2 if distance else 1)
            if isinstance(trigger.target, ControllerEvent):
                setattr(made, f"trig_event_{number}", trigger.target.name)
            else:
                setattr(made, f"trig_io_{number}", trigger.target.index)
            setattr(made, f"trig_value_{number}", trigger.value)
            if distance:
                setattr(made, f"trig_dist_{number}", trigger.amount)
            else:
                setattr(made, f"trig_time_{number}", trigger.amount * 1000)
        return made


def wire_op(name: str, op: Op | None, *, joint_motion: bool = False) -> rpc.Op:
    """Return the struct of the wire for an `Op`, or for None, which sets nothing."""
    if op is None:
        return rpc.Op()
    if not isinstance(op, Op):
        raise ParameterError(name, op, "an Op, or None")
    return op.wire(name, joint_motion=joint_motion)


@dataclass(frozen=True, slots=True)
class PointOp:
    """A point of a spline or of the track pool, and the outputs that are set there.

    Attributes:
        pos: a `Pose` (any six numbers become one), or a `Joints` for a track of joints.
        op: outputs that are set there.
    """

    pos: Pose | Joints
    op: Op

    def __init__(self, pos: PoseLike | Joints, op: Op | None = None) -> None:
        if isinstance(pos, Joints):
            point: Pose | Joints = Joints(*ranges.JOINTS("pos", pos))
        else:
            point = Pose(*ranges.POSE("pos", pos))
        object.__setattr__(self, "pos", point)
        if op is not None and not isinstance(op, Op):
            raise ParameterError("op", op, "an Op, or None")
        object.__setattr__(self, "op", op or Op())

    def wire(self, name: str = "point") -> rpc.PointOp:
        """Return the struct of the wire."""
        joints = isinstance(self.pos, Joints)
        return rpc.PointOp(list(self.pos), self.op.wire(f"{name}.op", joint_motion=joints))
