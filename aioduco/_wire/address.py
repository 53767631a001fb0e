"""Addresses as people write them: the one parser for the command line, files and options."""

from __future__ import annotations

from typing import Final

from aioduco._wire.endpoint import HOST_RULE, is_host
from aioduco.errors import ParameterError

__all__ = ["PORT", "parse_address"]

#: port of a controller
PORT: Final = 7003

_EXPECTED: Final = (
    "an address: a host, host:port, or [IPv6 address]:port, where the host is "
    f"{HOST_RULE}, and the port a number from {{}} to 65535"
)


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
    if not is_host(host) or any(each in host for each in "[]/@") or not _is_right(host):
        raise ParameterError(name, text, expected)
    if port is None:
        return host, None
    if not (port.isascii() and port.isdecimal() and len(port) <= 5):
        raise ParameterError(name, text, expected)
    number = int(port)
    if not (0 if any_port else 1) <= number <= 65535:
        raise ParameterError(name, text, expected)
    return host, number


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
