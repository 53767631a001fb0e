"""The robots that have names: a file of the user.

It is `$XDG_CONFIG_HOME/aioduco/robots.toml`, by default `~/.config/aioduco/robots.toml`:

    default = "left"

    [left]
    host = "192.168.1.10"

    [right]
    host = "192.168.1.11"
    port = 7003
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from aioduco._wire.address import PORT, parse_address
from aioduco.errors import ParameterError
from aioduco.models.toml_files import read_toml

__all__ = ["ENVIRONMENT", "RobotAddress", "WrongAddress", "find", "names", "robots_file"]

#: environment variable with a name or an address
ENVIRONMENT: Final = "AIODUCO_HOST"
#: address on which a simulator of this computer listens
_LOOPBACK: Final = "127.0.0.1"


class WrongAddress(Exception):
    """The file cannot be read, or an address is not valid."""


@dataclass(frozen=True, slots=True)
class RobotAddress:
    """Address of a controller.

    Attributes:
        host: host name or address.
        port: TCP port.
        name: name in the user's file of robots; empty without one.
    """

    host: str
    port: int
    name: str = ""

    def __str__(self) -> str:
        host = f"[{self.host}]" if ":" in self.host else self.host
        where = f"{host}:{self.port}"
        return f"{self.name} ({where})" if self.name else where


def robots_file() -> Path | None:
    """Path of the user's file of robots, which need not exist; None for a user without a home."""
    folder = os.environ.get("XDG_CONFIG_HOME", "")
    # XDG: a path that is not absolute must be ignored
    try:
        base = Path(folder) if Path(folder).is_absolute() else Path.home() / ".config"
    except RuntimeError:  # neither HOME nor an entry in the system's list of users
        return None
    return base / "aioduco" / "robots.toml"


def find(given: str | None, port: int | None = None) -> RobotAddress:
    """Find the robot of a command.

    The first of these that is set is used: the argument on the command line, `AIODUCO_HOST`,
    `default` in the file of robots, a simulator on this computer. An empty text is set, and wrong:
    where a variable of a script is empty, no other arm is meant.

    Args:
        given: a name of the file, or an address: `192.168.1.10`, `arm.lan:7003`, `[::1]:7003`.
        port: TCP port; it overrides any other.

    Raises:
        WrongAddress: the file cannot be read, or the address is not valid.
    """
    name, text = "the robot", given
    if text is None:
        name, text = ENVIRONMENT, os.environ.get(ENVIRONMENT)
    try:
        robots, default = _read(robots_file())
    except WrongAddress:
        # an address needs no file; a name does
        if text is None or not _is_numeric(text):
            raise
        robots, default = {}, ""
    if text is None:
        text = default or _LOOPBACK
    found = robots.get(text)
    if found is None:
        host, told = _parsed(name, text)
        found = RobotAddress(host, told or PORT)
    return found if port is None else RobotAddress(found.host, port, found.name)


def names() -> list[str]:
    """Names of the robots in the file; none if it cannot be read."""
    try:
        return list(_read(robots_file())[0])
    except WrongAddress:
        return []


def _read(path: Path | None) -> tuple[dict[str, RobotAddress], str]:
    """The robots of a file by their names, and the name of its default."""
    if path is None:
        return {}, ""
    try:
        data = read_toml(path)
    except (FileNotFoundError, NotADirectoryError):
        return {}, ""
    except (OSError, ValueError) as error:
        raise WrongAddress(f"{path} cannot be read: {error}") from None
    default = data.pop("default", "")
    if not isinstance(default, str):
        raise WrongAddress(
            f"{path}: default is the name of a robot, before the first [name]: "
            'default = "left"; a robot cannot be called default'
        )
    robots = {name: _robot(path, name, entry) for name, entry in data.items()}
    if default and default not in robots:
        raise WrongAddress(
            f"{path}: there is no robot {default!r} to be the default; there are "
            f"{', '.join(robots) or 'none'}"
        )
    return robots, default


def _robot(path: Path, name: str, entry: Any) -> RobotAddress:
    if not isinstance(entry, dict) or not isinstance(entry.get("host"), str):
        raise WrongAddress(f'{path}: [{name}] needs a line such as host = "192.168.1.10"')
    host, told = _parsed(f"{path}: host of [{name}]", entry["host"])
    port = entry.get("port", told or PORT)
    if type(port) is not int or not 1 <= port <= 65535:
        raise WrongAddress(f"{path}: [{name}] has port = {port!r}, not from 1 to 65535")
    if unknown := sorted(entry.keys() - {"host", "port"}):
        raise WrongAddress(f"{path}: [{name}] has {unknown[0]!r}; it may have host and port")
    return RobotAddress(host, port, name)


def _parsed(name: str, text: str) -> tuple[str, int | None]:
    try:
        return parse_address(text)
    except ParameterError as error:
        raise WrongAddress(f"{name} is {text!r}, but must be {error.expected}") from None


def _is_numeric(text: str) -> bool:
    """Whether a text is an address of numbers, with or without a port."""
    import ipaddress  # noqa: PLC0415 - only if the file is wrong

    try:
        ipaddress.ip_address(parse_address(text)[0])
    except ValueError:
        return False
    return True
