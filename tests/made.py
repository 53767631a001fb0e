"""An object of any public value or error, made from the types of its parameters."""

from __future__ import annotations

import collections.abc
import enum
import inspect
import math
import pkgutil
import re
import types
import typing
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any, Literal, Union

import numpy as np
import numpy.typing as npt

import aioduco
from aioduco import Cell, Joints, JointTrajectory, TaughtPoints, kinematics, planning
from aioduco._process.copying import Frozen
from aioduco.devices.bus.modbus_rtu import Port
from aioduco.envelope import Envelope, JointMargin, ToolSpeed
from aioduco.planning import Scene
from aioduco.recording.playback import WaypointFile
from aioduco.sim.cabinet import SystemValues
from aioduco.sim.scene import Box
from aioduco.testing import Chaos, Cut, Delay, Place

#: parameters that are not of any value of their type
_GIVEN: dict[str, dict[str, Any]] = {
    "BoardSize": {"columns": 4, "rows": 3},
    "ArmDescription": {"model": "gcr5_910"},
    "ArmSettings": {"name": "left", "host": "192.0.2.1"},
    "Cancelled": {"ended": "raised"},
    "ControllerVersion": {"text": "V2.8.1"},
    "ExternalAxis": {"position_limit": (0.0, 1.0)},
    "ExternalAxisScheme": {"axis_link": (1,), "base": (0.0,) * 6, "dh": ((0.0,) * 4,)},
    "CellGripper": {"kind": "parallel"},
    "FleetSettings": {"name": "cell"},
    "Jog": {"axis": 1, "direction": 1, "vel": 10.0, "step": None},
    "PointCloud": {"points": ((0.1, 0.2, 0.3),)},
    "PointOp": {"pos": Joints(0.1, 0.2, 0.3, 0.4, 0.5, 0.6)},
    "RealtimePoint": {"values": (0.1,) * 6},
    "Zone": {"shape": "box", "at": (0.1, 0.2, 0.3), "size": (0.1, 0.2, 0.3)},
}


def _waypoints() -> WaypointFile:
    file = WaypointFile.new()
    file.add("home", Joints.deg(30, -15, 105, 0, -90, 0))
    return file


#: classes of which an argument is made in another way than from the types of their parameters
_MADE: dict[type[Any], Any] = {
    Cell: lambda: Cell('arm = "gcr5_910"\n[robots.left]\nhost = "192.0.2.1"\n'),
    kinematics.Arm: lambda: kinematics.arm("gcr5_910"),
    Chaos: lambda: Chaos(3, [Delay(0.1), Cut(Place.AFTER_REQUEST)], rate=0.5),
    Envelope: lambda: Envelope("gcr5_910", ToolSpeed(0.5), JointMargin(0.1)),
    JointTrajectory: lambda: JointTrajectory([[0.0] * 6, [0.1] * 6], [0.0, 1.0]),
    Scene: lambda: Scene("gcr5_910", [Box(at=(0.5, 0, 0.2), size=(0.1, 0.1, 0.1), name="box")]),
    SystemValues: lambda: SystemValues({"count": 3, "rows": [[1.0, 2.0], [3.0]]}),
    TaughtPoints: lambda: TaughtPoints({"home": Joints.deg(30, -15, 105, 0, -90, 0)}),
    WaypointFile: _waypoints,
    planning.Mesh: lambda: planning.Mesh(vertices=np.eye(4, 3)),
    planning.Plan: lambda: planning.Plan(
        arm=kinematics.arm("gcr5_910"),
        trajectory=JointTrajectory([[0.0] * 6, [0.1] * 6], [0.0, 1.0]),
        limits=made(planning.MotionLimits),
        tip=np.eye(4),
        corners=np.zeros((2, 6)),
        looked=np.zeros(2),
        clearances=np.ones(2),
        radii=np.ones(6),
    ),
}


def made(kind: type[Any]) -> Any:
    """An object of this class, with every argument that it requires."""
    if kind in _MADE:
        return _MADE[kind]()
    if issubclass(kind, BaseException) and "__init__" not in _own(kind):
        return kind("a text")
    positional, named = [], dict(_GIVEN.get(kind.__name__, {}))
    for name, parameter in inspect.signature(kind).parameters.items():
        if name in named or parameter.default is not parameter.empty:
            continue
        if parameter.kind in (parameter.VAR_POSITIONAL, parameter.VAR_KEYWORD):
            continue
        value = _of(_hints(kind).get(name, object))
        if parameter.kind is parameter.POSITIONAL_ONLY:
            positional.append(value)
        else:
            named[name] = value
    if issubclass(kind, Frozen):
        for value in named.values():
            if isinstance(value, np.ndarray):
                value.setflags(write=False)
    return kind(*positional, **named)


def _own(kind: type[Any]) -> set[str]:
    """Names that a class, or a base of it in the package, defines."""
    own = [each for each in kind.__mro__ if each.__module__.startswith("aioduco")]
    return {name for each in own for name in vars(each)}


def _hints(kind: type[Any]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for each in reversed(kind.__mro__):
        if not each.__module__.startswith("aioduco"):
            continue
        own = vars(import_module(each.__module__))
        for source in (each, each.__dict__.get("__init__")):
            hints = getattr(source, "__annotations__", {})
            for name, hint in hints.items():
                text = getattr(hint, "__forward_arg__", hint)
                found[name] = eval(text, {**_names(), **own}) if isinstance(text, str) else text
    return found


@cache
def _names() -> dict[str, Any]:
    """What annotations name without an import at run time."""
    found: dict[str, Any] = {**vars(collections.abc), **vars(typing), "np": np, "Path": Path}
    found.update(NDArray=npt.NDArray, Matrix=npt.NDArray[Any], Array=npt.NDArray[Any], Fault=str)
    for module in pkgutil.walk_packages(aioduco.__path__, "aioduco."):
        if re.search(
            r"\.(ros|compat|cli)\b|arm_scene|planning\.(search|solver|worker)|__main__", module.name
        ):
            continue  # no public value lies there, and some load much
        for name, value in vars(import_module(module.name)).items():
            if str(getattr(value, "__module__", "")).startswith("aioduco"):
                found.setdefault(name, value)
    return found


def _of(hint: Any) -> Any:
    """A value of a type."""
    origin, arguments = typing.get_origin(hint), typing.get_args(hint)
    if isinstance(hint, str):
        return _of(eval(hint, _names()))
    if hint in (Any, object):
        return "anything"
    if origin in (Union, types.UnionType):
        return _of(next(each for each in arguments if each is not type(None)))
    if origin is Literal:
        return arguments[0]
    if origin is tuple:
        if arguments[-1] is ...:
            return (_of(arguments[0]),) * 6
        return tuple(map(_of, arguments))
    if origin in (list, collections.abc.Sequence):
        return [_of(arguments[0])] * 6
    if origin in (dict, collections.abc.Mapping):
        return {_of(arguments[0]): _of(arguments[1])}
    if origin in (np.ndarray, npt.NDArray):  # the latter where it is an alias of its own
        return np.linspace(0.1, 0.6, 6)
    if origin is collections.abc.Callable:
        return len
    if hint in _SIMPLE:
        return _SIMPLE[hint]
    if issubclass(hint, enum.Enum):
        return next(iter(hint))
    return made(hint)


_SIMPLE: dict[Any, Any] = {
    bool: True,
    int: 3,
    float: 0.5,
    str: "a text",
    bytes: b"bytes",
    Path: Path("file"),
    BaseException: ValueError("wrong"),
    Exception: ValueError("wrong"),
    type(None): None,
}


def same(one: Any, other: Any) -> bool:
    """Whether two objects have the same class and the same content, arrays included."""
    if type(one) is not type(other):
        return False
    if isinstance(one, np.ndarray):
        same_flags = one.flags.writeable == other.flags.writeable
        return (
            same_flags
            and one.dtype == other.dtype
            and np.array_equal(one, other, equal_nan=one.dtype.kind == "f")
        )
    if isinstance(one, float):
        return one == other or (math.isnan(one) and math.isnan(other))
    if isinstance(one, BaseException):
        return (
            str(one) == str(other) and same(one.args, other.args) and same(vars(one), vars(other))
        )
    if isinstance(one, dict):
        return list(one) == list(other) and all(same(one[key], other[key]) for key in one)
    if isinstance(one, (tuple, list)):
        return len(one) == len(other) and all(map(same, one, other))
    if isinstance(one, enum.Enum) or not type(one).__module__.startswith("aioduco"):
        return bool(one == other)
    return all(same(value, getattr(other, name, None)) for name, value in _content(one).items())


def _content(thing: Any) -> dict[str, Any]:
    if isinstance(thing, Scene):  # but for its lock
        return thing.__getstate__()
    if isinstance(thing, Port):  # but for the requests under way
        return {"write": thing.write, "read": thing.read}
    slots = [name for kind in type(thing).__mro__ for name in kind.__dict__.get("__slots__", ())]
    found = {name: getattr(thing, name) for name in slots if hasattr(thing, name)}
    return {**found, **getattr(thing, "__dict__", {})}
