"""Addresses as people write them: the one parser for the command line, files and options."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

from aioduco.errors import ParameterError
from aioduco.models.host_port import host_port
from aioduco.models.similar import did_you_mean

HOST_RULE: Final = (
    "a name or an address, without http://, slashes, blanks and control characters, each part 1 to "
    "63 characters long, 253 in all"
)
#: port of a controller
PORT: Final = 7003
#: what a robot has in the file of a cell besides host and port
CELL_KEYS: Final = frozenset({"model", "mounting", "pedestal"})

_EXPECTED: Final = (
    "an address: a host, host:port, or [IPv6 address]:port, where the host is "
    f"{HOST_RULE}, and the port a number from {{}} to 65535"
)


class WrongAddress(Exception):
    """A file of robots, or an address in it, is not valid.

    Attributes:
        place: keys of the field in the table of robots.
    """

    def __init__(self, text: str, *place: str) -> None:
        super().__init__(text)
        self.place: tuple[str, ...] = place


@dataclass(frozen=True, slots=True)
class RobotAddress:
    """Address of a controller.

    Attributes:
        host: host name or address.
        port: TCP port.
        name: name in a file of robots; empty without one.
        cell: file of the cell that names it; empty if another file does, or none.
    """

    host: str
    port: int
    name: str = ""
    cell: str = ""

    @property
    def where(self) -> str:
        """Host and port, as commands take them."""
        return host_port(self.host, self.port)

    def __str__(self) -> str:
        return f"{self.name} ({self.where})" if self.name else self.where


def is_host(host: object) -> bool:
    """Whether it can be a name or an address. The system reads only a part of some other texts."""
    if not isinstance(host, str) or not host or not host.isprintable():
        return False
    if any(each in host for each in " []/@"):
        return False
    try:
        return len(host.encode("idna")) <= 253
    except UnicodeError:
        return False


def robots_of(table: dict[str, Any], *, also: frozenset[str] = frozenset()) -> tuple[
    dict[str, RobotAddress], str
]:  # fmt: skip
    """The robots in a table: `default = "left"`, and tables with `host` and `port` by name.

    Args:
        table: the table, as read from TOML.
        also: keys of a robot that are somebody else's.

    Returns:
        The robots by their names, and the name of the default; empty without one.

    Raises:
        WrongAddress: an entry is unknown, missing or wrong.
    """
    if not isinstance(table, dict):
        raise WrongAddress("robots are tables: [NAME]")
    default = table.get("default", "")
    if not isinstance(default, str):
        raise WrongAddress(
            'default is the name of a robot, before the first [name]: default = "left"; a robot '
            "cannot be called default",
            "default",
        )
    entries = {name: entry for name, entry in table.items() if name != "default"}
    robots = {name: _robot(name, entry, also) for name, entry in entries.items()}
    if default and default not in robots:
        raise WrongAddress(
            f"there is no robot {default!r} to be the default; there are "
            f"{', '.join(robots) or 'none'}{did_you_mean(default, robots)}",
            "default",
        )
    return robots, default


def _robot(name: str, entry: Any, also: frozenset[str]) -> RobotAddress:
    known = {"host", "port", *also}
    if isinstance(entry, dict) and (strange := sorted(entry.keys() - known)):
        text = f"[{name}] has {strange[0]!r}; it may have {' and '.join(sorted(known))}"
        raise WrongAddress(text + did_you_mean(strange[0], known), name, strange[0])
    if not isinstance(entry, dict) or not isinstance(entry.get("host"), str):
        raise WrongAddress(f'[{name}] needs a line such as host = "192.168.1.10"', name)
    try:
        host, told = parse_address(entry["host"])
    except ParameterError as error:
        text = f"host of [{name}] is {entry['host']!r}, but must be {error.expected}"
        raise WrongAddress(text, name, "host") from None
    port = entry.get("port", told or PORT)
    if type(port) is not int or not 1 <= port <= 65535:
        raise WrongAddress(f"[{name}] has port = {port!r}, not from 1 to 65535", name, "port")
    return RobotAddress(host, port, name)


def parse_address(
    text: object, *, name: str = "address", any_port: bool = False
) -> tuple[str, int | None]:
    """Take an address apart.

    Args:
        text: `192.168.1.10`, `arm.lan:7003`, `::1`, `[::1]`, `[::1]:7003`.
        name: what it is called in the error.
        any_port: whether the port may be 0, for a free one to listen on.

    Returns:
        Host and port; the port is None if the address has none.

    Raises:
        ParameterError: it is no address. An empty text is none: a variable of a script that is
            not set must not stand for another arm.
    """
    expected = _EXPECTED.format(0 if any_port else 1)
    if not isinstance(text, str):
        raise ParameterError(name, text, expected)
    if not text.strip():
        raise ParameterError(name, text, f"given (is a variable empty?): {expected}")
    host, port = text, None
    if text.startswith("["):
        host, closed, rest = text[1:].partition("]")
        if not closed or ":" not in host or not (rest == "" or rest.startswith(":")):
            raise ParameterError(name, text, expected)
        port = rest[1:] if rest else None
    elif text.count(":") == 1:
        host, _, port = text.partition(":")
    if not is_host(host) or not _is_right(host):
        raise ParameterError(name, text, expected)
    if port is None:
        return host, None
    if not (port.isascii() and port.isdecimal() and len(port) <= 5):
        raise ParameterError(name, text, expected)
    number = int(port)
    if not (0 if any_port else 1) <= number <= 65535:
        raise ParameterError(name, text, expected)
    return host, number


def host_alone(host: object, *, name: str = "host") -> str:
    """Check a host that has no port with it, as where the port is another argument.

    Raises:
        ParameterError: it is no host, or an address with a port or brackets.
    """
    try:
        told, port = parse_address(host)
    except ParameterError:
        raise ParameterError(name, host, HOST_RULE) from None
    if told != host:
        alone = f"alone, with its port as an argument of its own: {told!r}, {port or PORT}"
        raise ParameterError(name, host, alone)
    return told


def _is_right(host: str) -> bool:
    """Whether a host with colons is an IPv6 address."""
    if ":" not in host:
        return True
    import ipaddress  # noqa: PLC0415 - most addresses have no colon

    try:
        ipaddress.IPv6Address(host)
    except ValueError:
        return False
    return True
