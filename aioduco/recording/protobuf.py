"""Decodes the three kinds of Foxglove's messages in recordings, from protobuf's wire format.

A field that protobuf leaves out is 0, or empty; a number that a joint does not have is None.
"""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator


_DOUBLE: Final = struct.Struct("<d")
_LEVELS: Final = ("UNKNOWN", "DEBUG", "INFO", "WARNING", "ERROR", "FATAL")


def _varint(data: memoryview, at: int) -> tuple[int, int]:
    value = shift = 0
    while True:
        byte = data[at]
        at += 1
        value |= (byte & 0x7F) << shift
        if byte < 0x80:
            return value, at
        shift += 7
        if shift > 63:
            raise ValueError("a number of more than 64 bits")


def _fields(data: memoryview) -> Iterator[tuple[int, Any]]:
    """Iterate over number and value of each field: a whole number, a double, or bytes.

    A fixed field of 4 bytes is read as a whole number.
    """
    at = 0
    while at < len(data):
        tag, at = _varint(data, at)
        match tag & 7:
            case 0:
                value: Any
                value, at = _varint(data, at)
            case 1:
                (value,) = _DOUBLE.unpack_from(data, at)
                at += 8
            case 2:
                length, at = _varint(data, at)
                value = data[at : at + length]
                at += length
            case 5:
                (value,) = struct.unpack_from("<I", data, at)
                at += 4
            case kind:
                raise ValueError(f"a field of kind {kind}")
        yield tag >> 3, value


def _doubles(data: memoryview, count: int) -> list[float]:
    """Decode a message that contains only doubles."""
    found = [0.0] * count
    for number, value in _fields(data):
        found[number - 1] = value
    return found


_JOINT: Final = ("position", "velocity", "acceleration", "effort")


def _joint_states(data: memoryview) -> dict[str, Any]:
    found: dict[str, list[Any]] = {"names": [], **{name: [] for name in _JOINT}}
    for number, value in _fields(data):
        if number != 2:
            continue
        joint: dict[int, Any] = dict(_fields(value))
        found["names"].append(str(joint.get(1, b""), "utf-8"))
        for index, name in enumerate(_JOINT, 2):
            found[name].append(joint.get(index))
    return {
        name: values
        for name, values in found.items()
        if name == "names" or any(value is not None for value in values)
    }


def _frame_transforms(data: memoryview) -> dict[str, Any]:
    """Decode by name of the child: parent, translation, and rotation as a quaternion, x first."""
    found: dict[str, Any] = {}
    for number, value in _fields(data):
        if number == 1:
            one: dict[int, Any] = dict(_fields(value))
            found[str(one.get(3, b""), "utf-8")] = {
                "parent": str(one.get(2, b""), "utf-8"),
                "translation": _doubles(one.get(4, memoryview(b"")), 3),
                "rotation": _doubles(one.get(5, memoryview(b"")), 4),
            }
    return found


def _log(data: memoryview) -> dict[str, Any]:
    found: dict[int, Any] = dict(_fields(data))
    level = found.get(2, 0)
    texts = [str(found.get(number, b""), "utf-8") for number in (3, 4, 5)]
    return {
        "level": _LEVELS[level] if level < len(_LEVELS) else str(level),
        **dict(zip(("message", "name", "file"), texts, strict=True)),
        "line": found.get(6, 0),
    }


#: decoders by the name of the schema
DECODERS: Final[dict[str, Callable[[memoryview], dict[str, Any]]]] = {
    "foxglove.JointStates": _joint_states,
    "foxglove.FrameTransforms": _frame_transforms,
    "foxglove.Log": _log,
}
