"""Settings of `fleet.toml`: the fleet, this computer's gateway, and its arms."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from aioduco.errors import DucoError, ParameterError
from aioduco.models.address import host_alone
from aioduco.models.ranges import HEARTBEAT, TEXTS
from aioduco.models.rules import stored
from aioduco.models.similar import did_you_mean
from aioduco.models.toml_files import read_toml

if TYPE_CHECKING:
    from os import PathLike


#: address on which a gateway listens by default
LOOPBACK: Final = "tcp/127.0.0.1:7447"
#: names are parts of Zenoh's key expressions, in which `/`, `*`, `$`, `?` and `#` are special
_NAME: Final = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,63}")


class FleetFileError(DucoError, ValueError):
    """The settings of a fleet are wrong; the text says why. Nothing was started."""


def is_name(text: object) -> bool:
    """Whether a value is a name of a fleet, a gateway or an arm."""
    return isinstance(text, str) and _NAME.fullmatch(text) is not None


@dataclass(frozen=True, slots=True)
class ArmSettings:
    """One arm of a gateway.

    Attributes:
        name: name of the arm in the fleet; letters, digits, `_`, `.` and `-`.
        host: name or address of its controller.
        port: TCP port of the controller.
        heartbeat: time without a heartbeat of the gateway after which the controller stops the arm
            [s], 0.2 to 60; 0 for none: then another program must send the heartbeat.
        guard: whether a separate process stops the arm when the gateway dies; Linux only.
    """

    name: str
    host: str
    port: int = 7003
    heartbeat: float = 1.0
    guard: bool = False

    def __post_init__(self) -> None:
        _named("name of an arm", self.name)
        _typed(self, host=str, port=int, heartbeat=(int, float), guard=bool)
        try:
            host_alone(self.host, name=f"host of the arm {self.name}")
        except ParameterError as error:
            raise FleetFileError(str(error)) from None
        if not 0 < self.port < 65536:
            raise FleetFileError(f"port of the arm {self.name} is {self.port}")
        if self.heartbeat != 0 and not HEARTBEAT.low <= self.heartbeat <= HEARTBEAT.high:
            raise FleetFileError(
                f"heartbeat of the arm {self.name} is {self.heartbeat} s, and must be "
                f"{HEARTBEAT.low:g} to {HEARTBEAT.high:g}, or 0 for none"
            )


@dataclass(frozen=True, slots=True)
class FleetSettings:
    """Settings of a fleet on one of its computers.

    Attributes:
        name: name of the fleet; gateways of other fleets are not visible.
        gateway: name of this computer's gateway, unique in the fleet; empty for clients only.
        listen: Zenoh endpoints to listen on. An address other than loopback lets every computer
            of that network see and stop the arms.
        connect: endpoints of other gateways or, if `listen` is empty, of a router.
        discover: whether to look for gateways by multicast in the local network too.
        expect: gateways that must be present: a stop that one of them does not answer is not
            confirmed.
        rate: rate at which a gateway publishes its state [Hz].
        zenoh: file with Zenoh's own configuration, such as certificates and access control; empty
            for none. The settings above override it.
        keys: file with the keys of gateways, by which they prove their answers to a stop; empty for
            none: then no stop is confirmed. A gateway's own computer needs its own key alone.
        arms: arms of this gateway.
    """

    name: str
    gateway: str = ""
    listen: tuple[str, ...] = (LOOPBACK,)
    connect: tuple[str, ...] = ()
    discover: bool = False
    expect: tuple[str, ...] = ()
    rate: float = 5.0
    zenoh: str = ""
    keys: str = ""
    arms: tuple[ArmSettings, ...] = field(default=())

    def __post_init__(self) -> None:
        _named("name of the fleet", self.name)
        if self.gateway != "":
            _named("name of the gateway", self.gateway)
        _typed(self, discover=bool, rate=(int, float), zenoh=str, keys=str)
        try:
            stored(self, listen=TEXTS, connect=TEXTS, expect=TEXTS)
        except ParameterError as error:
            raise FleetFileError(str(error)) from None
        if not isinstance(self.arms, Sequence) or not all(
            isinstance(arm, ArmSettings) for arm in self.arms
        ):
            raise FleetFileError(f"arms is {self.arms!r}, but must be a list of ArmSettings")
        object.__setattr__(self, "arms", tuple(self.arms))
        for each in self.expect:
            _named("expected gateway", each)
        if not 0.1 <= self.rate <= 100:
            raise FleetFileError(f"rate is {self.rate} Hz, and must be 0.1 to 100")
        names = [arm.name for arm in self.arms]
        if twice := sorted({name for name in names if names.count(name) > 1}):
            raise FleetFileError(f"arms of the same name: {', '.join(twice)}")

    @classmethod
    def read(cls, path: str | PathLike[str]) -> FleetSettings:
        """Read a file. The files that it names are found from its own folder.

        Raises:
            FleetFileError: the file cannot be read, or is not valid; the text says why.
        """
        try:
            table = read_toml(path)
        except OSError as error:
            raise FleetFileError(f"{path} cannot be read: {error}") from error
        except ValueError as error:
            raise FleetFileError(f"{path}: {error}") from error
        read = cls.of(table)
        folder = Path(path).absolute().parent
        return replace(
            read,
            zenoh=read.zenoh and str(folder / read.zenoh),
            keys=read.keys and str(folder / read.keys),
        )

    @classmethod
    def of(cls, table: dict[str, Any]) -> FleetSettings:
        """Make settings from a parsed table: `[fleet]` and a list of `[[arm]]`.

        Raises:
            FleetFileError: an entry is unknown, missing or wrong.
        """
        _only("the file", table, {"fleet", "arm"})
        fleet, arms = table.get("fleet", {}), table.get("arm", [])
        if not isinstance(fleet, dict) or not isinstance(arms, list):
            raise FleetFileError("[fleet] must be a table, and [[arm]] a list of tables")
        known = {each.name for each in fields(cls)} - {"arms"}
        _only("[fleet]", fleet, known)
        values = dict(fleet)
        made = []
        for arm in arms:
            if not isinstance(arm, dict):
                raise FleetFileError("[[arm]] must be a list of tables")
            _only("[[arm]]", arm, {each.name for each in fields(ArmSettings)})
            _complete("[[arm]]", arm, "name", "host")
            made.append(ArmSettings(**arm))
        _complete("[fleet]", values, "name")
        return cls(**values, arms=tuple(made))


def settings_given(given: object) -> FleetSettings:
    """The settings of an argument.

    Raises:
        FleetFileError: it is something else, such as the name of their file.
    """
    if not isinstance(given, FleetSettings):
        raise FleetFileError(
            f"settings is {given!r}, but must be FleetSettings: FleetSettings.read reads a file"
        )
    return given


def _complete(where: str, table: dict[str, Any], *needed: str) -> None:
    if lack := [name for name in needed if name not in table]:
        raise FleetFileError(f"{where} lacks {' and '.join(lack)}")


def _only(where: str, table: dict[str, Any], known: set[str]) -> None:
    if unknown := sorted(set(table) - known):
        raise FleetFileError(
            f"{where} takes no {', '.join(unknown)}; it takes {', '.join(sorted(known))}"
            f"{did_you_mean(unknown[0], known)}"
        )


def _named(what: str, text: object) -> None:
    if not is_name(text):
        raise FleetFileError(
            f"the {what} is {text!r}: letters, digits, '_', '.' and '-' only, 64 at most"
        )


def _typed(settings: object, **types: type | tuple[type, ...]) -> None:
    for name, kind in types.items():
        value = getattr(settings, name)
        if not isinstance(value, kind) or (isinstance(value, bool) and kind is not bool):
            raise FleetFileError(f"{name} is {value!r}, which is of the wrong type")
