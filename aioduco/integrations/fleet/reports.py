"""Messages between gateways and clients: keys, JSON and its decoding. Pure.

A message from the network can have any content. One that cannot be read raises `MessageRefused`. A
gateway still obeys a stop that it cannot read: the key says that it is a stop, so that all arms of
the gateway are stopped.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass, replace
from typing import Any, Final

from aioduco.integrations.fleet.settings import is_name

#: version of the schemas below
VERSION: Final = 1
#: size of the longest message that is read [bytes]
LONGEST: Final = 1024 * 1024
#: largest number of arms, and of joints, in a message
_MOST: Final = 1024
_TEXT: Final = 2000
#: states of the connection of a gateway to an arm
LINKS: Final = ("opening", "up", "lost")


class MessageRefused(ValueError):
    """A message does not match its key; the text says why."""


def state_key(fleet: str, gateway: str = "*") -> str:
    """Key under which a gateway publishes its state."""
    return f"aioduco/{fleet}/{gateway}/state"


def alive_key(fleet: str, gateway: str = "*") -> str:
    """Key of the liveliness token that shows that a gateway is present."""
    return f"aioduco/{fleet}/{gateway}/alive"


def stop_key(fleet: str, gateway: str = "*") -> str:
    """Key of the query that requests a stop from a gateway."""
    return f"aioduco/{fleet}/{gateway}/stop"


@dataclass(frozen=True, slots=True)
class StopRequest:
    """Stop arms.

    Attributes:
        arms: names of the arms; None for all. A gateway ignores names of other gateways' arms.
    """

    arms: frozenset[str] | None = None

    def encode(self) -> bytes:
        """As a message: `{"version": 1, "arms": null}`."""
        return _encoded(arms=None if self.arms is None else sorted(self.arms))

    @classmethod
    def decode(cls, data: bytes) -> StopRequest:
        """Read a message; a message without content stops all arms.

        Raises:
            MessageRefused: it is no such message.
        """
        if not data:
            return cls()
        arms = _decoded(data).get("arms")
        if arms is None:
            return cls()
        if not isinstance(arms, list) or len(arms) > _MOST or not all(map(is_name, arms)):
            raise MessageRefused("arms is no list of names")
        return cls(frozenset(arms))


@dataclass(frozen=True, slots=True)
class ArmStopped:
    """Result of the stop of one arm.

    Attributes:
        name: name of the arm.
        error: why it is not confirmed that the arm stands; empty if it stands.
    """

    name: str
    error: str = ""


@dataclass(frozen=True, slots=True)
class StopReport:
    """A gateway's answer to a stop.

    Attributes:
        gateway: name of the gateway.
        arms: results of the arms that were to be stopped.
        note: the error in the request; empty if there was none.
    """

    gateway: str
    arms: tuple[ArmStopped, ...]
    note: str = ""

    def encode(self) -> bytes:
        """As a message."""
        arms = [{"name": arm.name, "error": arm.error} for arm in self.arms]
        return _encoded(gateway=self.gateway, arms=arms, note=self.note)

    @classmethod
    def decode(cls, data: bytes) -> StopReport:
        """Read a message.

        Raises:
            MessageRefused: it is no such message.
        """
        table = _decoded(data)
        arms = [ArmStopped(_name(each), _text(each, "error")) for each in _tables(table, "arms")]
        return cls(_name(table, "gateway"), tuple(arms), _text(table, "note"))


@dataclass(frozen=True, slots=True)
class ArmReport:
    """State of an arm, as its gateway knows it.

    Attributes:
        name: name of the arm.
        link: "opening", "up" or "lost"; if "lost", the values below are old.
        error: why the connection is lost.
        robot, program, safety, mode: names of the controller's states; empty if not known.
        joints: actual positions [rad]; empty if not known.
        seconds: age of the values [s]; 0 if there are none.
    """

    name: str
    link: str = "opening"
    error: str = ""
    robot: str = ""
    program: str = ""
    safety: str = ""
    mode: str = ""
    joints: tuple[float, ...] = ()
    seconds: float = 0.0


@dataclass(frozen=True, slots=True)
class GatewayReport:
    """A gateway's state.

    Attributes:
        gateway: name of the gateway.
        number: number of this report, from 1 since the gateway started.
        arms: state of each arm.
    """

    gateway: str
    number: int
    arms: tuple[ArmReport, ...]

    def encode(self) -> bytes:
        """As a message."""
        arms = [
            {
                **{name: getattr(arm, name) for name in _TEXTS},
                "name": arm.name,
                "joints": [round(value, 6) for value in arm.joints],
                "seconds": round(arm.seconds, 3),
            }
            for arm in self.arms
        ]
        return _encoded(gateway=self.gateway, number=self.number, arms=arms)

    def older(self, seconds: float) -> GatewayReport:
        """The same some time later: the values of its arms are older by that [s]."""
        arms = (replace(a, seconds=a.seconds + seconds) if a.robot else a for a in self.arms)
        return replace(self, arms=tuple(arms))

    @classmethod
    def decode(cls, data: bytes) -> GatewayReport:
        """Read a message.

        Raises:
            MessageRefused: it is no such message.
        """
        table = _decoded(data)
        number = table.get("number")
        if type(number) is not int or number < 0:
            raise MessageRefused("number is no count")
        arms = []
        for each in _tables(table, "arms"):
            texts = {name: _text(each, name) for name in _TEXTS}
            if texts["link"] not in LINKS:
                raise MessageRefused(f"link is {texts['link']!r}")
            joints = each.get("joints")
            if not isinstance(joints, list) or len(joints) > _MOST:
                raise MessageRefused("joints is no list")
            values = tuple(_number(value) for value in joints)
            seconds = _number(each.get("seconds"))
            arms.append(ArmReport(_name(each), joints=values, seconds=seconds, **texts))
        return cls(_name(table, "gateway"), number, tuple(arms))


_TEXTS: Final = ("link", "error", "robot", "program", "safety", "mode")


def _encoded(**table: Any) -> bytes:
    text = json.dumps({"version": VERSION, **table}, ensure_ascii=False)
    return text.encode(errors="backslashreplace")  # a byte of a file's name that is no text


def _decoded(data: bytes) -> dict[str, Any]:
    if len(data) > LONGEST:
        raise MessageRefused(f"it has {len(data)} bytes, more than {LONGEST}")
    try:
        table = json.loads(data)
    except (ValueError, RecursionError) as error:
        raise MessageRefused(f"it is no JSON: {error}"[:_TEXT]) from error
    if not isinstance(table, dict):
        raise MessageRefused("it is no object")
    if table.get("version") != VERSION:
        raise MessageRefused(f"its version is not {VERSION}")
    return table


def _tables(table: dict[str, Any], name: str) -> list[dict[str, Any]]:
    found = table.get(name)
    if (
        not isinstance(found, list)
        or len(found) > _MOST
        or not all(isinstance(each, dict) for each in found)
    ):
        raise MessageRefused(f"{name} is no list of objects")
    return found


def _name(table: dict[str, Any], key: str = "name") -> str:
    found = table.get(key)
    if not isinstance(found, str) or not is_name(found):
        raise MessageRefused(f"{key} is no name")
    return found


def _text(table: dict[str, Any], key: str) -> str:
    found = table.get(key)
    if not isinstance(found, str):
        raise MessageRefused(f"{key} is no text")
    return "".join(letter if letter.isprintable() else "�" for letter in found[:_TEXT])


def _number(found: object) -> float:
    try:
        if isinstance(found, int | float) and not isinstance(found, bool) and math.isfinite(found):
            return float(found)
    except OverflowError:
        pass
    raise MessageRefused("a number is expected")
