"""Check whether a text can be the name or the address of a host."""

from __future__ import annotations

from typing import Final

__all__ = ["HOST_RULE", "is_host"]

HOST_RULE: Final = (
    "a name or an address, without blanks and control characters, each part 1 to 63 characters "
    "long, 253 in all"
)


def is_host(host: str) -> bool:
    """Whether it can be a name or an address. The system reads only a part of some other texts."""
    if not host or not host.isprintable() or " " in host:
        return False
    try:
        return len(host.encode("idna")) <= 253
    except UnicodeError:
        return False
