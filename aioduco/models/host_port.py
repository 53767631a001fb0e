"""An address as a person writes it."""

from __future__ import annotations


def host_port(host: str, port: int) -> str:
    """The text of an address: `arm.lan:7003`, or `[::1]:7003`."""
    return f"[{host}]:{port}" if ":" in str(host) else f"{host}:{port}"
