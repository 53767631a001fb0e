"""A stop without a robot: what is sent, how often, and when it is over."""

from __future__ import annotations

import asyncio
import itertools

import pytest
from wire.servers import Peer, Received, Script, ScriptedServer, exception

from aioduco.errors import ConnectError, NotAController, StaleState, StopUnconfirmed
from aioduco.models.enums import RobotState
from aioduco.supervision import operator_stop, stop_channel, unanswered
from aioduco.supervision.operator_stop import stop_arm

STATES = [6, 0, 5, 1]


def controller(
    *stops: int | None, moving: int = 0, tells: bool = True, before: tuple[Script, ...] = ()
) -> ScriptedServer:
    """A controller with these answers to stops, None for no answer, then 0, on all connections.

    Args:
        stops: its first answers.
        moving: how many polls find a moving arm, of those after an accepted stop.
        tells: whether it answers with its states.
        before: what the first connections do instead.
    """
    left = iter(stops)
    polls = itertools.count()

    def answer(peer: Peer, call: Received) -> None:
        if call.name == "stop":
            value = next(left, 0)
            if value is not None:
                peer.answer(call, value)
        elif call.name == "robotmoving":
            peer.answer(call, next(polls) < moving)
        elif tells:
            peer.answer(call, STATES)

    def script(peer: Peer) -> None:
        while (call := peer.receive()) is not None:
            answer(peer, call)

    return ScriptedServer(*before, script)


@pytest.fixture
def calm(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing is sent again, however long a busy machine takes."""
    monkeypatch.setattr(operator_stop, "FIRST_ATTEMPT", 20.0)
    monkeypatch.setattr(unanswered, "_STOP_AGAIN", 20.0)
    for limit in ("FIRST_ATTEMPT", "_ASK_LIMIT"):
        monkeypatch.setattr(stop_channel, limit, 20.0)


@pytest.mark.usefixtures("calm")
async def test_the_stop_is_the_first_call_and_all_goes_over_one_connection() -> None:
    with controller(moving=3) as server:
        states = await stop_arm(server.host, server.port, standstill_timeout=60.0)
    assert states.robot is RobotState.ENABLE
    assert server.calls[0].args == (False,)
    assert server.names == ["stop", *["robotmoving"] * 5, "get_robot_state"]
    assert server.connections == 1


async def test_a_stop_that_is_not_answered_or_refused_is_repeated() -> None:
    with controller(None, -1, None) as server:
        await stop_arm(server.host, server.port)
    assert server.names.count("stop") >= 4
    assert server.names[-3:] == ["robotmoving", "robotmoving", "get_robot_state"]


async def test_a_connection_that_breaks_is_replaced() -> None:
    def breaks(peer: Peer) -> None:
        peer.receive()
        peer.reset()

    with controller(before=(breaks, breaks)) as server:
        await stop_arm(server.host, server.port)
    assert server.names.count("stop") >= 3
    assert server.names[-3:] == ["robotmoving", "robotmoving", "get_robot_state"]


async def test_an_arm_that_moves_on_is_not_said_to_stand(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(unanswered, "_STOP_AGAIN", 0.1)
    with controller(moving=10**9) as server:
        with pytest.raises(StopUnconfirmed, match="emergency stop"):
            await stop_arm(server.host, server.port, standstill_timeout=0.5)
        assert server.names.count("stop") >= 2


@pytest.mark.slow
async def test_a_controller_that_answers_nothing_is_not_said_to_have_stopped() -> None:
    with controller(*[None] * 99) as server:
        with pytest.raises(StopUnconfirmed, match="emergency stop") as caught:
            await stop_arm(server.host, server.port, stop_timeout=0.5)
        assert server.names.count("stop") >= 2
    assert "the last one was sent, but no answer came" in str(caught.value)
    assert "not sent again" not in str(caught.value)


async def test_a_cancelled_stop_goes_on_until_the_arm_stands() -> None:
    with controller(None, None) as server:
        stopping = asyncio.ensure_future(stop_arm(server.host, server.port))
        await asyncio.to_thread(server.wait_calls, 1)
        stopping.cancel()
        with pytest.raises(asyncio.CancelledError):
            await stopping
    assert server.names[-2:] == ["robotmoving", "robotmoving"]


async def test_states_that_are_not_read_do_not_hide_that_the_arm_stands() -> None:
    with controller(tells=False) as server:
        said = "^the arm was stopped, and stands; its states could not be read: get_robot_state"
        with pytest.raises(StaleState, match=said):
            await stop_arm(server.host, server.port, call_timeout=0.2)


def garbage(peer: Peer) -> None:
    peer.receive()
    peer.send(b"HTTP/1.1 400 Bad Request\r\n\r\n")
    peer.wait_gone()


def of_another_service(peer: Peer) -> None:
    while (call := peer.receive()) is not None:
        peer.send(exception(call.raw, 1, f"unknown function {call.name}"))


@pytest.mark.parametrize("script", [garbage, of_another_service])
async def test_what_is_no_controller_is_named(script: Script) -> None:
    with ScriptedServer(script) as server:
        with pytest.raises(NotAController):
            await stop_arm(server.host, server.port)
        assert set(server.names) <= {"stop", "get_robot_state"}


async def test_where_nothing_listens_nothing_is_tried_for_long() -> None:
    with ScriptedServer() as server:
        pass
    with pytest.raises(ConnectError, match="refused"):
        await stop_arm(server.host, server.port)
