"""Where connections lead: a host, and which of its addresses is tried when, and for how long.

A name may have several addresses, of which one leads nowhere: a second network, or an old entry.
"""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

__all__ = ["HOST_RULE", "Route", "is_host"]

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


class Route:
    """The way to one host; connections that share it begin with the address that connected last.

    Attributes:
        address: the address that connected last, in the form of `socket.getaddrinfo`; None before.
    """

    __slots__ = ("address",)

    def __init__(self) -> None:
        self.address: Any = None

    def tries(
        self, found: Iterable[tuple[Any, ...]], deadline: float
    ) -> Iterator[tuple[tuple[Any, ...], float]]:
        """Yield each address, and the time until which to try it [s of `time.monotonic`].

        The time that is left is shared equally by the addresses that are left: one that does not
        answer leaves time for the others. No address is yielded after the deadline.

        Args:
            found: the answer of `socket.getaddrinfo`.
            deadline: time by which one must have connected.
        """
        order = sorted(dict.fromkeys(found), key=lambda each: each[-1] != self.address)
        for left, each in zip(range(len(order), 0, -1), order, strict=True):
            now = time.monotonic()
            if now >= deadline:
                return
            yield each, now + (deadline - now) / left
