"""A controller that answers from a script and records every call: no arm, no physics, no state."""

from __future__ import annotations

import threading
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Self

from aioduco._process.copying import Uncopied
from aioduco._wire import idl
from aioduco.sim.refusal import Refusal
from aioduco.sim.server import Server

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping


@dataclass(frozen=True, slots=True)
class ReceivedCall:
    """A call that a server has received completely.

    Attributes:
        method: the function of the wire.
        args: its arguments, in the order of the wire; one that was left out has its zero value.
        at: when it was received, in s of `time.monotonic`.
        thread: id of the thread that served it; each connection has its own.
    """

    method: str
    args: tuple[Any, ...]
    at: float
    thread: int


class RecordingServer(Uncopied):
    """Answers calls with prepared results, and records them.

        with RecordingServer({"movej2": 1063, "get_tcp_pose": lambda: [0.0] * 6}) as server:
            ...                                  # connect to server.host, server.port
            assert [call.args[1] for call in server.received("movej2")] == [1.0]

    A call is recorded before it is answered. The simulator's own server handles the connections, so
    only the answers differ from those of the simulator.

    Attributes:
        host: address on which it listens.
        port: free port on which it listens.
    """

    def __init__(self, answers: Mapping[str, Any] | None = None) -> None:
        """Make a server; `with` starts it.

        Args:
            answers: result of each function of the wire, by its name, or a callable that gets the
                arguments and returns the result. The caller gets a Thrift application error if
                the callable raises, or if it calls a function that is not here.
        """
        self._answers: dict[str, Any] = {}
        self._received: list[ReceivedCall] = []
        for method, answer in (answers or {}).items():
            self.answer(method, answer)
        self._server = Server(_Answering(self._serve))

    def __enter__(self) -> Self:
        self._server.start()
        self.host: str = self._server.host
        self.port: int = self._server.port
        return self

    def __exit__(self, *_: object) -> None:
        self._server.close()

    async def __aenter__(self) -> Self:
        return self.__enter__()

    async def __aexit__(self, *_: object) -> None:
        self.__exit__()

    def answer(self, method: str, answer: Any) -> None:
        """Set or change what a function returns.

        Args:
            method: the function of the wire.
            answer: a value, or a callable that gets the arguments and returns it.

        Raises:
            KeyError: the wire has no such function.
        """
        if method not in idl.names():
            raise KeyError(f"the wire has no function {method!r}")
        self._answers[method] = answer

    def received(self, method: str | None = None) -> tuple[ReceivedCall, ...]:
        """The calls received so far, oldest first.

        Args:
            method: only calls of this function of the wire.
        """
        calls = tuple(self._received)
        return calls if method is None else tuple(c for c in calls if c.method == method)

    @property
    def connections(self) -> int:
        """How many connections are open."""
        return self._server.connections

    def _serve(self, method: str, args: tuple[Any, ...]) -> Any:
        self._received.append(ReceivedCall(method, args, time.monotonic(), threading.get_ident()))
        try:
            answer = self._answers[method]
        except KeyError:
            raise Refusal(f"{method} has no answer in this server's script") from None
        return answer(*args) if callable(answer) else answer


class _Answering:
    """A handler that has every function."""

    def __init__(self, serve: Callable[[str, tuple[Any, ...]], Any]) -> None:
        self._serve = serve

    def __getattr__(self, method: str) -> Callable[..., Any]:
        return lambda *args: self._serve(method, args)
