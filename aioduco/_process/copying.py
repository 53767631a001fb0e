"""What a copy or a pickle of an object is, where Python's own would be wrong."""

from __future__ import annotations

import copy
from typing import Any, ClassVar, NoReturn, Self, TypeVar

from aioduco.errors import NotCopyable

_Value = TypeVar("_Value", bound="Frozen")


class Uncopied:
    """Base of classes whose objects hold a connection, a process, a thread or a device.

    A copy would be a second owner of it, and would not know of what the first one does.
    """

    __slots__ = ()

    #: what to do instead, for the message
    _instead: ClassVar[str] = "make another one there, with the same arguments"

    def __reduce_ex__(self, protocol: object) -> NoReturn:
        raise NotCopyable(
            f"{type(self).__name__} cannot be copied or pickled: what it holds belongs to this "
            f"object in this process. Use this one, or {self._instead}. Nothing was done"
        )


class Frozen:
    """Base of values whose arrays are read-only, which they are in a copy and a pickle too."""

    __slots__ = ()

    def __reduce__(self) -> tuple[object, ...]:
        return _refrozen, (type(self), self._content())

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        return _refrozen(type(self), copy.deepcopy(self._content(), memo))

    def _content(self) -> dict[str, Any]:
        slots = [name for kind in type(self).__mro__ for name in kind.__dict__.get("__slots__", ())]
        return {**{name: getattr(self, name) for name in slots}, **getattr(self, "__dict__", {})}


def _refrozen(kind: type[_Value], content: dict[str, Any]) -> _Value:
    value = object.__new__(kind)
    for name, part in content.items():
        if hasattr(part, "setflags"):  # an array; without loading numpy for it
            part.setflags(write=False)
        object.__setattr__(value, name, part)
    return value
