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

__all__ = ["ENVIRONMENT", "RobotAddress", "WrongAddress", "find", "names", "robots_file"]

#: environment variable with a name or an address
ENVIRONMENT: Final = "AIODUCO_HOST"
#: address on which a simulator of this computer listens
_LOOPBACK: Final = "127.0.0.1"
_PORT: Final = 7003


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
        where = f"{self.host}:{self.port}"
        return f"{self.name} ({where})" if self.name else where


def robots_file() -> Path:
    """Path of the user's file of robots. The file need not exist."""
    folder = os.environ.get("XDG_CONFIG_HOME", "")
    # XDG: a path that is not absolute must be ignored
    base = Path(folder) if Path(folder).is_absolute() else Path.home() / ".config"
    return base / "aioduco" / "robots.toml"


def find(given: str | None, port: int | None = None) -> RobotAddress:
    """Find the robot of a command.

    The first of these that is set is used: the argument on the command line, `AIODUCO_HOST`,
    `default` in the file of robots, a simulator on this computer.

    Args:
        given: a name of the file, or an address: `192.168.1.10`, `arm.lan:7003`, `[::1]:7003`.
        port: TCP port; it overrides any other.

    Raises:
        WrongAddress: the file cannot be read, or the address is not valid.
    """
    robots, default = _read(robots_file())
    text = given or os.environ.get(ENVIRONMENT) or default or _LOOPBACK
    found = robots.get(text)
    if found is None:
        host, told = _split(text)
        found = RobotAddress(host, told or _PORT)
    return found if port is None else RobotAddress(found.host, port, found.name)


def names() -> list[str]:
    """Names of the robots in the file; none if it cannot be read."""
    try:
        return list(_read(robots_file())[0])
    except WrongAddress:
        return []


def _read(path: Path) -> tuple[dict[str, RobotAddress], str]:
    """The robots of a file by their names, and the name of its default."""
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        return {}, ""
    except (OSError, ValueError) as error:
        raise WrongAddress(f"{path} cannot be read: {error}") from None
    import tomllib  # noqa: PLC0415 - most computers have no such file

    try:
        data: dict[str, Any] = tomllib.loads(text)
    except ValueError as error:
        raise WrongAddress(f"{path} cannot be read: {error}") from None
    default = data.pop("default", "")
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
    port = entry.get("port", _PORT)
    if type(port) is not int or not 1 <= port <= 65535:
        raise WrongAddress(f"{path}: [{name}] has port = {port!r}, not from 1 to 65535")
    if unknown := sorted(entry.keys() - {"host", "port"}):
        raise WrongAddress(f"{path}: [{name}] has {unknown[0]!r}; it may have host and port")
    return RobotAddress(entry["host"], port, name)


def _split(text: str) -> tuple[str, int | None]:
    """Host and port of an address; the port is None if the address has none."""
    host, colon, port = text.rpartition(":")
    if text.startswith("["):  # IPv6 stands in brackets before a port
        if text.endswith("]"):
            return text[1:-1], None
        host = host.removeprefix("[").removesuffix("]")
    elif not colon or ":" in host:
        return text, None
    if not (port.isascii() and port.isdigit() and 1 <= int(port) <= 65535):
        raise WrongAddress(f"{text!r} has no port from 1 to 65535 after its colon")
    return host, int(port)
