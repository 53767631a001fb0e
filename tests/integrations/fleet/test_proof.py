"""Only a gateway itself, proven by its key, can report that its arms stand."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from contextlib import AsyncExitStack
from dataclasses import replace
from pathlib import Path
from typing import Any

import anyio
import anyio.to_thread
import pytest
from ports import free_port

from aioduco.integrations.fleet import (
    FleetClient,
    FleetFileError,
    FleetGateway,
    FleetSettings,
    FleetStop,
)
from aioduco.integrations.fleet.proof import challenge, proof_of, proves, read_keys
from aioduco.integrations.fleet.reports import ArmStopped, StopReport, alive_key, stop_key
from aioduco.testing import eventually_async

KEY = bytes(range(32))


@pytest.fixture
def plant(tmp_path: Path) -> FleetSettings:
    """A fleet of one gateway, `cell`, with a key, and where it listens; `late` has a key, too."""
    pytest.importorskip("zenoh")
    keys = tmp_path / "keys.toml"
    keys.write_text(f'cell = "{KEY.hex()}"\nlate = "{KEY.hex()}"')
    listen = (f"tcp/127.0.0.1:{free_port()}",)
    return FleetSettings("plant", "cell", listen=listen, expect=("cell",), keys=str(keys))


def test_a_proof_is_of_one_answer_to_one_request() -> None:
    riddle = challenge()
    assert riddle != challenge()
    whole: tuple[bytes, bytes, bytes, bytes] = (KEY, riddle, b"all", b"stands")
    proof = proof_of(*whole)
    assert proves(KEY, riddle, b"all", b"stands", proof)
    for number in range(4):
        other = [*whole]
        other[number] = bytes([other[number][0] ^ 1]) + other[number][1:]
        assert not proves(other[0], other[1], other[2], other[3], proof)
    assert not proves(KEY, riddle, b"alls", b"tands", proof), "parts cannot be moved"
    for wrong in (b"", proof[:-1], proof + b"0"):
        assert not proves(KEY, riddle, b"all", b"stands", wrong)


@pytest.mark.parametrize(
    "text",
    ['a = "12"', f'a = "{"g" * 32}"', "a = 5", f'"a/b" = "{"0" * 32}"', "a =", "a = " + "[" * 9999],
)
def test_a_wrong_file_of_keys_is_refused_without_a_key_in_the_text(
    text: str, tmp_path: Path
) -> None:
    path = tmp_path / "keys.toml"
    path.write_text(text)
    with pytest.raises(FleetFileError) as refused:
        read_keys(path)
    assert "0" * 32 not in str(refused.value)
    assert "g" * 32 not in str(refused.value)
    with pytest.raises(FleetFileError):
        FleetClient(FleetSettings("plant", keys=str(tmp_path / "none.toml")))


Answer = StopReport("cell", (ArmStopped("left"),)).encode()


def forged(query: Any) -> None:
    query.reply(query.key_expr, Answer)


def of_another_key(query: Any) -> None:
    asked, request = query.attachment.to_bytes(), query.payload.to_bytes()
    query.reply(query.key_expr, Answer, attachment=proof_of(b"x" * 32, asked, request, Answer))


def of_an_old_stop(query: Any) -> None:
    request = query.payload.to_bytes()
    query.reply(query.key_expr, Answer, attachment=proof_of(KEY, challenge(), request, Answer))


def of_another_request(query: Any) -> None:
    asked = query.attachment.to_bytes()
    other = b'{"version": 1, "arms": ["right"]}'
    query.reply(query.key_expr, Answer, attachment=proof_of(KEY, asked, other, Answer))


async def told_by(
    stack: AsyncExitStack,
    answer: Callable[[Any], None],
    *,
    listen: str = "tcp/127.0.0.1:0",
    connect: Sequence[str] = (),
    complete: bool = False,
) -> None:
    """Someone in the network who takes the gateway's name."""
    zenoh: Any = pytest.importorskip("zenoh")
    config = zenoh.Config()
    for name, value in (
        ("listen/endpoints", [listen]),
        ("connect/endpoints", [*connect]),
        ("scouting/multicast/enabled", False),
    ):
        config.insert_json5(name, json.dumps(value))
    session = await anyio.to_thread.run_sync(zenoh.open, config)
    stack.push_async_callback(anyio.to_thread.run_sync, session.close)
    key = stop_key("plant", "cell")
    declared = [  # each ends with the last reference to it
        session.declare_queryable(key, answer, complete=complete),
        session.liveliness().declare_token(alive_key("plant", "cell")),
    ]
    stack.callback(declared.clear)


@pytest.mark.slow
@pytest.mark.parametrize("answer", [forged, of_another_key, of_an_old_stop, of_another_request])
async def test_nobody_answers_for_a_gateway_that_is_dead(
    answer: Callable[[Any], None], plant: FleetSettings
) -> None:
    async with AsyncExitStack() as stack:
        await told_by(stack, answer, listen=plant.listen[0])
        async with FleetClient(plant) as client:
            await eventually_async(lambda: "cell" in client._present)
            done = await client.stop(timeout=2.0)
        assert not done.confirmed
        assert "cell" in done.missing
        assert "cell" in done.unproven


@pytest.mark.slow
async def test_who_has_answered_is_told_while_others_are_waited_for(plant: FleetSettings) -> None:
    """If what is told fails, the stop still reaches those that come later."""
    known: list[FleetStop] = []
    found: list[FleetStop] = []
    own = (f"tcp/127.0.0.1:{free_port()}",)
    late = replace(plant, gateway="late", listen=own, connect=plant.listen)

    def waiting(so_far: FleetStop) -> None:
        known.append(so_far)
        raise ZeroDivisionError

    async def stop(client: FleetClient) -> None:
        found.append(await client.stop(timeout=60.0, waiting=waiting))

    async with (
        FleetGateway(plant),
        FleetClient(replace(plant, expect=("cell", "late"))) as client,
        anyio.create_task_group() as tasks,
    ):
        tasks.start_soon(stop, client)
        await eventually_async(lambda: known)
        async with FleetGateway(late):
            await eventually_async(lambda: found)
    assert known == [FleetStop((StopReport("cell", ()),), ("late",), ())]
    assert found[0].confirmed, found


@pytest.mark.slow
async def test_a_gateway_that_is_started_again_during_a_stop_gets_it_too(
    plant: FleetSettings,
) -> None:
    heard: list[Any] = []  # by one that dies before it answers
    found: list[FleetStop] = []
    async with AsyncExitStack() as stack:
        await told_by(stack, heard.append, listen=plant.listen[0])
        async with FleetClient(plant) as client, anyio.create_task_group() as tasks:

            async def stop() -> None:
                found.append(await client.stop(timeout=20.0))

            tasks.start_soon(stop)
            await eventually_async(lambda: heard)
            await stack.aclose()
            heard.clear()
            async with FleetGateway(plant):
                await eventually_async(lambda: found)
    assert found[0].confirmed, found


@pytest.mark.cases(1)
@pytest.mark.parametrize("complete", [False, True])
async def test_a_liar_beside_a_gateway_takes_no_stop_from_it(
    complete: bool, plant: FleetSettings
) -> None:
    """Whatever it declares, the stop reaches the gateway, and the gateway's own answer counts."""
    async with AsyncExitStack() as stack:
        gateway = await stack.enter_async_context(FleetGateway(plant))
        lies: list[int] = []

        def lie(query: Any) -> None:
            lies.append(1)
            forged(query)

        await told_by(stack, lie, connect=plant.listen, complete=complete)
        async with FleetClient(plant) as client:
            await eventually_async(lambda: "cell" in client._present)
            done = await client.stop(timeout=30.0)
            assert done.confirmed, "the gateway has no arms, and proves it"
            assert done.reports == (StopReport("cell", ()),)
        async with FleetClient(replace(plant, keys="")) as client:
            await eventually_async(lambda: "cell" in client._present)
            done = await client.stop(timeout=30.0)
            assert not done.confirmed, "without a key nobody knows who answered"
            assert done.unproven == ("cell",)
        assert gateway._key == KEY


def of_another_arm(query: Any) -> None:
    asked, request = query.attachment.to_bytes(), query.payload.to_bytes()
    answer = StopReport("cell", (ArmStopped("right", "it may move"),)).encode()
    query.reply(query.key_expr, answer, attachment=proof_of(KEY, asked, request, answer))


@pytest.mark.cases(1)
@pytest.mark.parametrize("hangs", [False, True])
async def test_a_stop_waits_for_each_of_two_gateways_of_one_name(
    hangs: bool, plant: FleetSettings, caplog: pytest.LogCaptureFixture
) -> None:
    """The names are to differ: that they do not must not hide an arm that moves."""
    held: list[Any] = []
    async with AsyncExitStack() as stack:
        await stack.enter_async_context(FleetGateway(plant))
        client = await stack.enter_async_context(FleetClient(plant))
        other = held.append if hangs else of_another_arm
        await told_by(stack, other, connect=plant.listen)
        done = await client.stop(timeout=5.0)
        while done.confirmed and not held:  # the client had not seen the other one yet
            done = await client.stop(timeout=5.0)
        assert not done.confirmed
        if hangs:
            assert done.reports == (StopReport("cell", ()),)
            assert done.missing == ("cell",)
        else:
            assert done.reports[0].arms == (ArmStopped("right", "it may move"),)
            assert not done.missing
        held.clear()
        later = replace(plant, listen=("tcp/127.0.0.1:0",), connect=plant.listen)
        await stack.enter_async_context(FleetGateway(later))
        await eventually_async(lambda: "another gateway is named cell, too" in caplog.text)


async def test_a_text_is_the_name_of_one_arm(plant: FleetSettings) -> None:
    asked: list[Any] = []

    def hear(query: Any) -> None:
        asked.append(json.loads(query.payload.to_bytes())["arms"])
        forged(query)

    async with AsyncExitStack() as stack:
        await told_by(stack, hear, listen=plant.listen[0])
        async with FleetClient(replace(plant, keys="")) as client:
            await eventually_async(lambda: "cell" in client._present)
            assert (await client.stop("left", timeout=30.0)).unknown == ()
    assert asked == [["left"]]


async def test_a_gateway_needs_its_own_key_alone(tmp_path: Path) -> None:
    keys = tmp_path / "keys.toml"
    keys.write_text(f'other = "{KEY.hex()}"')
    with pytest.raises(FleetFileError, match="no key of this gateway, cell"):
        FleetGateway(FleetSettings("plant", "cell", keys=str(keys)))
