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
from dataclasses import replace
from pathlib import Path
from typing import Final

from aioduco.errors import ParameterError
from aioduco.models.address import (
    CELL_KEYS,
    PORT,
    RobotAddress,
    WrongAddress,
    parse_address,
    robots_of,
)
from aioduco.models.similar import did_you_mean, unknown
from aioduco.models.toml_files import read_toml

__all__ = ["ENVIRONMENT", "RobotAddress", "WrongAddress", "find", "names", "robots_file"]

#: environment variable with a name or an address
ENVIRONMENT: Final = "AIODUCO_HOST"
#: address on which a simulator of this computer listens
_LOOPBACK: Final = "127.0.0.1"


def robots_file() -> Path | None:
    """Path of the user's file of robots, which need not exist; None for a user without a home."""
    folder = os.environ.get("XDG_CONFIG_HOME", "")
    # XDG: a path that is not absolute must be ignored
    try:
        base = Path(folder) if Path(folder).is_absolute() else Path.home() / ".config"
    except RuntimeError:  # neither HOME nor an entry in the system's list of users
        return None
    return base / "aioduco" / "robots.toml"


def find(given: str | None, port: int | None = None, cell: Path | None = None) -> RobotAddress:
    """Find the robot of a command.

    The first of these that is set is used: the argument on the command line, `AIODUCO_HOST`,
    `default` in the file of robots, a simulator on this computer. An empty text is set, and wrong:
    where a variable of a script is empty, no other arm is meant. With the file of a cell, its
    robots and its default are used, and nothing else.

    Args:
        given: a name of the file, or an address: `192.168.1.10`, `arm.lan:7003`, `[::1]:7003`.
        port: TCP port; it overrides that of a name. An address with another port is refused.
        cell: file of a cell; its section `[robots]` takes the place of the user's file.

    Raises:
        WrongAddress: the file cannot be read, or the address is not valid.
    """
    name, text = "the robot", given
    if text is None and cell is None:
        name, text = ENVIRONMENT, os.environ.get(ENVIRONMENT)
    robots: dict[str, RobotAddress] = {}
    default = ""
    if cell is not None:
        robots, default = _of_cell(cell)
    elif text is None or not _is_numeric(text):  # an address needs no file: a stop waits for none
        robots, default = _read(robots_file())
    if cell is not None and (default if text is None else text) not in robots:
        listed = ", ".join(robots) or "none"
        if text is None:
            raise WrongAddress(f"{cell} names no default robot; there are {listed}")
        raise WrongAddress(f"{cell}: robot {unknown(text, robots)}")
    if text is None:
        text = default or _LOOPBACK
    found = robots.get(text)
    if found is None:
        if port is None:
            _refuse_misspelt(text, robots)
        host, told = _parsed(name, text)
        if None not in (port, told) and port != told:
            raise WrongAddress(
                f"{name} is {text!r}, but --port is {port}: give one of the two ports"
            )
        found = RobotAddress(host, told or PORT)
    return found if port is None else replace(found, port=port)


def _refuse_misspelt(text: str, robots: dict[str, RobotAddress]) -> None:
    """Refuse what looks like a wrongly written name of a robot; it would be taken for a host."""
    if "." in text or ":" in text or text == "localhost":
        return
    if near := did_you_mean(text, robots):
        host = f"if it is the name of a host, give its port, too: {text}:{PORT}"
        raise WrongAddress(f"no robot is called {text!r}{near} {host}")


def names() -> list[str]:
    """Names of the robots in the file; none if it cannot be read."""
    try:
        return list(_read(robots_file())[0])
    except WrongAddress:
        return []


def _of_cell(path: Path) -> tuple[dict[str, RobotAddress], str]:
    """The robots of a cell, of which nothing else is read: a stop must not wait for the rest."""
    try:
        robots, default = robots_of(read_toml(path).get("robots", {}), also=CELL_KEYS)
    except (OSError, ValueError) as error:
        raise WrongAddress(f"{path} cannot be read: {error}") from None
    except WrongAddress as error:
        raise WrongAddress(f"{path}: {error}") from None
    if not default and len(robots) == 1:
        (default,) = robots
    named = {name: replace(each, cell=str(path)) for name, each in robots.items()}
    return named, default


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
    try:
        return robots_of(data)
    except WrongAddress as error:
        raise WrongAddress(f"{path}: {error}") from None


def _parsed(name: str, text: str) -> tuple[str, int | None]:
    try:
        return parse_address(text)
    except ParameterError as error:
        raise WrongAddress(f"{name} is {text!r}, but must be {error.expected}") from None


def _is_numeric(text: str) -> bool:
    """Whether a text is an address of numbers, with or without a port."""
    import ipaddress  # noqa: PLC0415 - quick stop

    try:
        ipaddress.ip_address(parse_address(text)[0])
    except ValueError:
        return False
    return True
