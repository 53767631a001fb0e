"""An address as a person writes it."""

from __future__ import annotations


def host_port(host: str, port: int) -> str:
    """The text of an address: `arm.lan:7003`, or `[::1]:7003`."""
    return f"[{host}]:{port}" if ":" in str(host) else f"{host}:{port}"


def is_loopback(host: str) -> bool:
    """Whether a host as it is written is this computer itself, as a simulator's is by default."""
    import ipaddress  # noqa: PLC0415 - a stop from a shell needs none

    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"
