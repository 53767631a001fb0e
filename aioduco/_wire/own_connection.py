"""The connection of one thread at a time, which is opened again whenever a call needs it."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any

from aioduco._wire.connection import Connection
from aioduco._wire.lifecycle import ConnectionState
from aioduco.errors import ConnectionLost

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco._wire.endpoint import Endpoint


class OwnConnection:
    """A connection of one thread at a time, opened again when a call needs it.

    Args:
        endpoint: where it leads.
        hurried: whether its calls cannot wait for the resolution of a name: the addresses that
            led to the last connection serve them.
        keeps_overdue: as for `Connection`.
        waiting: as for `Connection`.

    Attributes:
        connection: the present connection, in any state.
        given_up: why the present call was given up; empty if it was not.
    """

    def __init__(
        self,
        endpoint: Endpoint,
        *,
        hurried: bool = False,
        keeps_overdue: bool = False,
        waiting: Callable[[], object] | None = None,
    ) -> None:
        self._endpoint = endpoint
        self._hurried = hurried
        self._keeps_overdue = keeps_overdue
        self._waiting = waiting
        self.connection: Connection = self._new()
        self.given_up: str = ""

    @property
    def idle(self) -> bool:
        """Whether it is open, and can be used for another call."""
        return self.connection.state is ConnectionState.IDLE

    def ready(self, deadline: float | None = None) -> Connection:
        """Return the connection; open another one if this one is not open any more.

        Args:
            deadline: as for `Connection.open`.

        Raises:
            ConnectError: there is no controller, or it does not answer in time.
            ConnectionLost: it was given up.
        """
        if not self.idle:
            self.connection.close()
            self.connection = self._new()
            if self.given_up:
                raise ConnectionLost(f"nothing was sent, since {self.given_up}")
            self.connection.open(deadline, self._endpoint.known if self._hurried else None)
        return self.connection

    def call(self, name: str, args: tuple[Any, ...], timeout: float) -> Any:
        """Call a function of the wire and wait for its answer; only on the owner's thread.

        Args:
            name: the function.
            args: one value per parameter.
            timeout: seconds to connect, if it is not connected, and again for the answer.

        Raises:
            The errors of `ready` and of `Connection.call`.
        """
        return self.ready(time.monotonic() + timeout).call(name, args, timeout)

    def give_up(self, reason: str) -> None:
        """Make the thread drop its call, from another one; no further one is opened."""
        # The thread sets `connection` before it reads `given_up`, here the order is reversed: so
        # one of the two always sees what the other wrote.
        self.given_up = reason
        self.connection.abandon(reason)

    def close(self) -> None:
        """Close the connection; the next call opens another one."""
        self.connection.close()

    def _new(self) -> Connection:
        return Connection(self._endpoint, keeps_overdue=self._keeps_overdue, waiting=self._waiting)
