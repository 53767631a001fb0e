"""Zenoh, as a gateway and a client use it. Only this module of the package imports it.

Zenoh calls its callbacks on its own threads; they are forwarded to the event loop.
"""

from __future__ import annotations

import contextlib
import json
import re
from functools import partial
from typing import TYPE_CHECKING, Any, Final, Self

import anyio
import anyio.from_thread

from aioduco._process.threads import in_thread
from aioduco.errors import ConnectError, MissingExtra, RobotStateError
from aioduco.integrations.fleet.proof import proof_of
from aioduco.integrations.fleet.reports import LONGEST, alive_key, state_key, stop_key
from aioduco.integrations.fleet.settings import FleetFileError, FleetSettings

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable


#: intervals of the attempts to connect to absent peers [ms]
_RETRY: Final = {
    "period_init_ms": 250,
    "period_max_ms": 1000,
    "period_increase_factor": 2,
}
#: time for a peer to answer as a session opens [ms]. Zenoh's own 10 s would hold up whoever opens a
#: session, or closes one, while another computer does not answer
_OPEN: Final = 2000
#: by which a query lasts longer than its caller waits for the answers [s]
_LONGER: Final = 1.0
#: where Zenoh's errors go on with places in its own source
_PLACE: Final = re.compile(r"\s+at /.*", re.DOTALL)


class FleetLink:
    """A session of Zenoh, for one fleet; an asynchronous context manager.

    Args:
        settings: settings of the fleet.
        listens: whether it listens for connections of others.
    """

    def __init__(self, settings: FleetSettings, *, listens: bool) -> None:
        self._settings = settings
        self._listens = listens
        self._session: Any = None
        self._portal = anyio.from_thread.BlockingPortal()
        self._declared: list[Any] = []

    async def __aenter__(self) -> Self:
        """Open the session.

        Raises:
            MissingExtra: the extra `fleet` is not installed.
            FleetFileError: an address is none, or Zenoh's own file is wrong.
            ConnectError: an address cannot be listened on, or no router answers.
            RobotStateError: it is open already.
        """
        if self._session is not None:
            raise RobotStateError("the connection to the fleet is open already: make another one")
        with MissingExtra.named("a fleet", "fleet"):
            import zenoh  # noqa: PLC0415 - of the extra
        listen, connect = self._settings.listen, self._settings.connect
        where = ", ".join((self._listens and listen) or connect)
        try:
            config = self._config(zenoh)
        except zenoh.ZError as error:
            raise FleetFileError(f"Zenoh refuses the settings: {_plain(error)}") from error
        try:
            self._session = await in_thread(zenoh.open, config)
        except (zenoh.ZError, OSError, ValueError) as error:
            raise ConnectError(where or "Zenoh", 0, _plain(error)) from error
        self._portal = anyio.from_thread.BlockingPortal()
        self._declared = []
        try:
            await self._portal.__aenter__()
        except BaseException:
            await self._close_session()
            raise
        return self

    async def __aexit__(self, *_: object) -> None:
        try:
            # without the error of the block, which it would put into a group
            await self._portal.__aexit__(None, None, None)
        finally:
            await self._close_session()

    async def _close_session(self) -> None:
        session, self._session = self._session, None
        with anyio.CancelScope(shield=True):
            await in_thread(session.close)

    def _config(self, zenoh: Any) -> Any:
        settings = self._settings
        try:
            config = zenoh.Config.from_file(settings.zenoh) if settings.zenoh else zenoh.Config()
        except zenoh.ZError as error:
            text = f"Zenoh's file {settings.zenoh} cannot be read: {_plain(error)}"
            raise FleetFileError(text) from error
        # A client connects to all gateways in its settings, as gateways do with each other.
        connect = [*settings.connect, *(() if self._listens else settings.listen)]
        values: dict[str, Any] = {
            # A session without `listen` connects to a router, which also forwards its messages.
            "mode": "peer" if settings.listen else "client",
            "listen/endpoints": list(settings.listen) if self._listens else [],
            "connect/endpoints": connect,
            "connect/retry": _RETRY,
            "scouting/multicast/enabled": settings.discover,
            "scouting/gossip/enabled": True,
        }
        if not settings.zenoh:
            values["transport/unicast/open_timeout"] = _OPEN
        for name, value in values.items():
            config.insert_json5(name, json.dumps(value))
        return config

    # -- a gateway --------------------------------------------------------------------------

    def declare_alive(self, gateway: str) -> None:
        """Declare that a gateway is present, for as long as this session is open."""
        token = self._session.liveliness().declare_token(alive_key(self._settings.name, gateway))
        self._declared.append(token)

    def publish_state(self, gateway: str, data: bytes) -> None:
        """Publish a gateway's state without waiting; a message that cannot be sent is dropped."""
        self._session.put(state_key(self._settings.name, gateway), data)

    def answer_stops(
        self, gateway: str, stop: Callable[[bytes], Awaitable[bytes]], key_of_it: bytes | None
    ) -> None:
        """Run `stop` on the event loop for each request, and answer with its result.

        Args:
            gateway: name of the gateway.
            stop: function that stops, from the request to the answer.
            key_of_it: the gateway's key, for the proof; None for none.
        """
        key = stop_key(self._settings.name, gateway)

        async def carry_out(query: Any) -> None:
            try:
                request, asked = _bytes(query.payload), _bytes(query.attachment)
                answer = await stop(request)
                proof = None if key_of_it is None else proof_of(key_of_it, asked, request, answer)
                # The requester may have disconnected; then the answer is lost.
                with contextlib.suppress(Exception):
                    query.reply(key, answer, attachment=proof)
            finally:
                query.drop()

        def asked(query: Any) -> None:
            self._hand_on(carry_out, query)

        self._declared.append(self._session.declare_queryable(key, asked))

    def watch_namesakes(self, gateway: str, seen: Callable[[], object]) -> None:
        """Report each state that another session publishes in the name of this gateway."""
        import zenoh  # noqa: PLC0415 - it is there

        key = state_key(self._settings.name, gateway)
        origin = zenoh.Locality.REMOTE
        self._declared.append(
            self._session.declare_subscriber(
                key, lambda _: self._hand_on(seen), allowed_origin=origin
            )
        )

    # -- a client ---------------------------------------------------------------------------

    def watch_gateways(self, seen: Callable[[str, bool], object]) -> None:
        """Report gateways that appear, including present ones, and gateways that disappear."""
        import zenoh  # noqa: PLC0415 - it is there

        def changed(sample: Any) -> None:
            name = str(sample.key_expr).split("/")[2]
            self._hand_on(seen, name, sample.kind == zenoh.SampleKind.PUT)

        liveliness = self._session.liveliness()
        key = alive_key(self._settings.name)
        self._declared.append(liveliness.declare_subscriber(key, changed, history=True))

    def watch_states(self, told: Callable[[str, bytes], object]) -> None:
        """Receive the states of gateways, each with the gateway's name from its key."""

        def came(sample: Any) -> None:
            name = str(sample.key_expr).split("/")[2]
            self._hand_on(told, name, _bytes(sample.payload))

        self._declared.append(
            self._session.declare_subscriber(state_key(self._settings.name), came)
        )

    def ask_for_stop(
        self,
        gateway: str,
        data: bytes,
        asked: bytes,
        timeout: float,
        answered: Callable[[str, bytes, bytes], object],
        ended: Callable[[str], object],
    ) -> None:
        """Request a stop from one gateway. Its answer arrives later, or never.

        Others can answer in its name: the request goes to all that do, and all answers are passed
        on, so that none of them takes the place of the gateway's own.

        Args:
            gateway: name of the gateway.
            data: the request.
            asked: the challenge for its proof.
            timeout: time until which answers are passed on [s].
            answered: called with the gateway, an answer, and its proof, which may be empty.
            ended: called with the gateway when all that take its name have answered.
        """
        import zenoh  # noqa: PLC0415 - it is there

        def came(reply: Any) -> None:
            if reply.ok is not None:
                proof = _bytes(reply.ok.attachment)
                self._hand_on(answered, gateway, _bytes(reply.ok.payload), proof)

        key = stop_key(self._settings.name, gateway)
        handler = zenoh.handlers.Callback(came, partial(self._hand_on, ended, gateway))
        # Longer than the caller waits: a query that ends by its own time-out has ended, too.
        self._session.get(
            key, handler, payload=data, attachment=asked, timeout=timeout + _LONGER,
            target=zenoh.QueryTarget.ALL, consolidation=zenoh.ConsolidationMode.NONE,
        )  # fmt: skip

    def _hand_on(self, function: Callable[..., Any], *args: Any) -> None:
        with contextlib.suppress(RuntimeError):  # the session is closing
            self._portal.start_task_soon(function, *args)


def _plain(error: Exception) -> str:
    """What Zenoh says of an error."""
    return _PLACE.sub("", str(error))


def _bytes(payload: Any) -> bytes:
    """The content of a message; if it is too long, `LONGEST` + 1 bytes, which are refused."""
    if payload is None:
        return b""
    if len(payload) > LONGEST:
        return b"\0" * (LONGEST + 1)
    content: bytes = payload.to_bytes()
    return content
