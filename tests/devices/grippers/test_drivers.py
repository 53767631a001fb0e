"""The drivers, against a peer that pymodbus decodes and encodes for."""

from __future__ import annotations

import inspect
import math
import time
from typing import Any

import anyio
import pytest
from example_modules import example
from for_each import for_each

from aioduco import ParameterError, errors
from aioduco.devices.bus import ModbusRtu, Port
from aioduco.devices.grippers import GRIPPERS, DhGripper, GripperState, PolledGripper, Robotiq
from aioduco.testing import eventually_async

from .peer import Peer

FAST = {"poll": 0.001, "timeout": 30.0}


def robotiq(**options: Any) -> tuple[Robotiq, Peer]:
    """A Robotiq gripper that closes on something at count 150, after one look while it moves.

    The first two looks tell of the motion before: one without, one with the bit that it follows.
    """
    peer = Peer(9)
    peer.registers[0x07D0] = 0

    def behave(reads: int) -> None:
        act, position = peer.registers[0x03E8] >> 8, peer.registers[0x03E9]
        if not act & 1:
            peer.registers[0x07D0], peer.registers[0x07D1] = 0, 0
        elif reads < 2:
            follows = act if reads else act & ~8
            peer.registers[0x07D0] = (follows | (1 << 4 if not act & 8 else 3 << 4 | 3 << 6)) << 8
        elif reads == 2:
            peer.registers[0x07D0] = (act | (3 << 4)) << 8
            peer.registers[0x07D1] = position
        else:
            caught = position > 150
            peer.registers[0x07D0] = (act | 3 << 4 | (2 if caught else 3) << 6) << 8
            peer.registers[0x07D1] = position
            peer.registers[0x07D2] = min(position, 150) << 8

    peer.before_read = behave
    return Robotiq(ModbusRtu(Port(peer.write, peer.read), 9), **{**FAST, **options}), peer


def dh(model: str = "dh_pge", **options: Any) -> tuple[DhGripper, Peer]:
    """A DH gripper that closes on something at 400, after one look while it moves."""
    peer = Peer(1)

    def behave(reads: int) -> None:
        if peer.registers[0x0100]:
            peer.registers[0x0200] = 2 if reads == 0 and peer.registers[0x0200] != 1 else 1
        if peer.written and peer.written[-1][0] == 0x0103:
            position = peer.registers[0x0103]
            # the first look tells of the motion before
            peer.registers[0x0201] = (1, 0, 2 if position < 400 else 1)[min(reads, 2)]
            peer.registers[0x0202] = max(position, 400)

    peer.before_read = behave
    return DhGripper(ModbusRtu(Port(peer.write, peer.read), 1), model, **{**FAST, **options}), peer


async def test_robotiq_moves_and_grips() -> None:
    gripper, peer = robotiq()
    async with gripper:
        assert gripper.state.holding is None  # it is not active
        await gripper.activate()
        await gripper.activate()  # it is ready: nothing is sent
        opened = await gripper.open()
        assert (opened.holding, opened.moving) == (False, False)
        assert opened.width == pytest.approx(0.085)
        gripped = await gripper.close(speed=0.15, force=235.0)
        assert gripped.holding
        assert gripped.width == pytest.approx((230 - 150) / 227 * 0.085)
        gripper.check_held()
        between = await gripper.move(0.0425, speed=0.02, force=20.0)
        assert between.width == pytest.approx(0.0425, abs=0.085 / 227)
        await eventually_async(lambda: gripper.state.read_at > between.read_at)
        assert gripper.state.age >= 0.0
    assert [values for _, values in peer.written] == [
        *([0, 0, 0], [0x0100, 0, 0]),
        [0x0900, 0, 0x6C80],  # half of the fastest, the middle of the forces
        *([0x0900, 255, 0xFFFF], [0x0900, 116, 0x0000]),
    ]
    assert {address for address, _ in peer.written} == {0x03E8}


async def test_dh_moves_and_grips() -> None:
    gripper, peer = dh()
    async with gripper:
        await gripper.activate()
        opened = await gripper.open(speed=0.058, force=50.0)
        assert opened.width == pytest.approx(0.026)
        assert opened.holding is False
        gripped = await gripper.close(speed=0.00058, force=15.0)
        assert gripped.width == pytest.approx(0.4 * 0.026)
        assert gripped.holding
    assert peer.written == [
        (0x0100, [1]),
        *((0x0101, [100]), (0x0104, [100]), (0x0103, [1000])),
        *((0x0101, [20]), (0x0104, [1]), (0x0103, [0])),
    ]


async def test_a_slow_bus_gives_no_state_of_the_motion_before() -> None:
    """A motion was said to be at its end before the fingers had begun to move."""
    gripper, peer = dh()

    async def slow(data: bytes) -> None:
        if data[1:4] == b"\x06\x01\x03":
            begun = time.monotonic()
            await eventually_async(lambda: time.monotonic() > begun + 0.35)
        await peer.write(data)

    gripper._modbus._port = Port(slow, peer.read)
    await gripper.activate()
    assert (await gripper.open()).width == pytest.approx(0.026)
    assert (await gripper.close()).holding


async def test_a_status_that_lags_gives_no_state_of_the_motion_before() -> None:
    """The bit that says whether the gripper follows may come later than the request."""
    gripper, _ = robotiq()
    await gripper.activate()
    assert (await gripper.open()).width == pytest.approx(0.085)
    assert (await gripper.close()).holding


async def test_the_ag_has_no_register_for_its_speed() -> None:
    gripper, peer = dh("dh_ag95")
    async with gripper:
        await gripper.activate()
        await gripper.open()
        with pytest.raises(errors.ParameterError):
            await gripper.open(speed=0.05)
    assert [address for address, _ in peer.written] == [0x0100, 0x0101, 0x0103]


async def test_a_gripper_that_is_not_activated() -> None:
    for gripper, peer in (robotiq(), dh()):
        async with gripper:
            with pytest.raises(errors.GripperNotActivated, match=r"activate"):
                await gripper.close()
            assert not peer.written
            # Read again and again meanwhile, it stays readable.
            assert (await gripper.read()).holding is None


async def test_out_of_range_is_not_sent() -> None:
    for gripper, peer in (robotiq(), dh()):
        for wrong in (
            {"width": -0.001},
            {"width": 0.2},
            {"width": math.nan},
            {"width": 0.01, "force": 1000.0},
            {"width": 0.01, "force": 0.0},
            {"width": 0.01, "speed": 10.0},
        ):
            with pytest.raises(errors.ParameterError):
                await gripper.move(**wrong)
        assert not peer.frames


@pytest.mark.parametrize(
    ("spoil", "error"),
    [
        (lambda _: b"", errors.ModbusTimeout),
        (lambda frame: frame[:-1] + bytes([frame[-1] ^ 1]), errors.ModbusGarbled),
    ],
)
async def test_no_answer_and_a_wrong_checksum(spoil: Any, error: type[Exception]) -> None:
    for make in (robotiq, dh):
        gripper, peer = make()
        gripper._modbus._timeout = 0.01
        peer.spoil = spoil
        with pytest.raises(error):
            await gripper.start()
        peer.spoil = bytes
        async with gripper:
            await gripper.activate()
            before = gripper.state
            peer.spoil = spoil
            with pytest.raises(error):
                await gripper.close()
            # What was known stays, and grows old.
            assert gripper.state.age > 0.0
            assert gripper.state.width == before.width


async def test_no_answer_while_it_is_activated() -> None:
    gripper, peer = robotiq()
    gripper._modbus._timeout = 0.01
    behave = peer.before_read

    def silent_from_then_on(reads: int) -> None:
        behave(reads)
        if peer.written:
            peer.spoil = lambda _: b""

    peer.before_read = silent_from_then_on
    with pytest.raises(errors.ModbusTimeout):
        await gripper.activate()


async def test_an_activation_that_does_not_end() -> None:
    gripper, peer = robotiq(timeout=0.01)
    peer.before_read = lambda _: None
    with pytest.raises(errors.GripperTimeout, match="was not ready"):
        await gripper.activate()


async def test_a_fault() -> None:
    gripper, peer = robotiq()
    peer.before_read = lambda _: peer.registers.update({0x07D0: 0x3900, 0x07D1: 0x0E00})
    with pytest.raises(errors.GripperFault, match="current was too high") as raised:
        await gripper.read()
    assert raised.value.code == 0x0E


async def test_cancelled_it_halts() -> None:
    gripper, peer = robotiq()
    async with gripper:
        await gripper.activate()
        behave = peer.before_read
        peer.before_read = lambda reads: behave(min(reads, 2))  # it moves for ever
        with anyio.CancelScope() as scope:
            async with anyio.create_task_group() as group:
                group.start_soon(gripper.close)
                await eventually_async(lambda: peer.written[-1][1][0] == 0x0900)
                await eventually_async(lambda: gripper.state.moving)
                scope.cancel()
    assert peer.written[-1] == (0x03E8, [0x0100, 255, 0x6C80])  # rGTO off


@pytest.mark.parametrize("halts", [True, False])
async def test_dh_is_halted_where_it_is_or_not_said_to_be(
    monkeypatch: pytest.MonkeyPatch, halts: bool
) -> None:
    async def silent() -> None:
        raise errors.ModbusTimeout("device 1 did not answer")

    gripper, peer = dh()
    async with gripper:
        await gripper.activate()
        gripper._timeout = 0.1
        peer.before_read = lambda _: peer.registers.update({0x0201: 0, 0x0202: 777})
        if not halts:
            monkeypatch.setattr(gripper, "_halt", silent)
        said = "was halted" if halts else "could not be halted, and may still move"
        with pytest.raises(errors.GripperTimeout, match=said):
            await gripper.close()
    assert (peer.written[-1] == (0x0103, [777])) is halts


async def test_a_dh_that_is_to_open_is_halted_before_it_has_begun() -> None:
    """The state was that of the motion before: fingers opened after the cancellation."""
    gripper, peer = dh()
    async with gripper:
        await gripper.activate()
        assert (await gripper.close()).holding
        opens, write = anyio.Event(), peer.write

        async def seen(data: bytes) -> None:
            await write(data)
            if data[1:4] == b"\x06\x01\x03":
                peer.before_read = lambda _: None  # it holds the object still
                opens.set()

        gripper._modbus._port = Port(seen, peer.read)
        async with anyio.create_task_group() as group:
            group.start_soon(gripper.open)
            await opens.wait()
            group.cancel_scope.cancel()
    assert peer.written[-1] == (0x0103, [400])


async def test_an_object_that_is_lost_ends_what_is_awaited() -> None:
    gripper, peer = robotiq()
    async with gripper:
        await gripper.activate()
        await gripper.open()
        with pytest.raises(errors.ObjectLost, match="holds nothing"):
            async with gripper.carrying():
                pytest.fail("nothing is held")
        await gripper.close()
        async with gripper.carrying():
            pass
        for wrong in (KeyError, SystemExit, KeyboardInterrupt):  # they come out as they are
            with pytest.raises(wrong):
                async with gripper.carrying():
                    raise wrong

        async def carry() -> None:
            async with gripper.carrying():
                peer.before_read = lambda _: peer.registers.update({0x07D0: 0xF900})
                await anyio.sleep_forever()

        with pytest.raises(errors.ObjectLost, match=r"^the Robotiq .* lost what it held"):
            await carry()
        with pytest.raises(errors.ObjectLost):
            gripper.check_held()


async def test_before_its_start_it_has_no_state() -> None:
    with pytest.raises(errors.GripperError, match="in its block"):
        _ = robotiq()[0].state


@pytest.mark.cases(1)
@pytest.mark.parametrize("make", [robotiq, dh])
async def test_after_its_block_it_moves_nothing(make: Any) -> None:
    gripper, peer = make()
    async with gripper:
        await gripper.activate()
        await gripper.open()
    sent = len(peer.frames)
    for command in (gripper.open, gripper.close, gripper.activate, gripper.read):
        with pytest.raises(errors.GripperError, match=r"block has ended\. Nothing was sent"):
            await command()
    assert len(peer.frames) == sent
    await gripper.halt()
    assert len(peer.frames) > sent, "fingers that another task left moving can be halted"
    async with gripper:
        assert (await gripper.close()).holding


@pytest.mark.parametrize("make", [robotiq, dh])
async def test_a_halt_does_not_activate(make: Any) -> None:
    """The halt of a Robotiq sets rACT, which begins an activation if it was off."""
    gripper, peer = make()
    async with gripper:
        await gripper.halt()
        assert not peer.written
        await gripper.activate()
        await gripper.open()
        written = len(peer.written)
        await gripper.halt()
        assert len(peer.written) == written + 1


async def test_an_activation_is_halted_or_not_said_to_be() -> None:
    gripper, peer = robotiq()
    peer.before_read = lambda _: peer.registers.update({0x07D0: 0x1100})
    await gripper.halt()
    assert peer.written == [(0x03E8, [0, 0, 0])]  # rACT off
    slow, other = dh()
    other.before_read = lambda _: other.registers.update({0x0200: 2})
    with pytest.raises(errors.GripperError, match="cannot be halted"):
        await slow.halt()
    assert not other.written


async def test_the_end_of_the_block_leaves_a_movement_of_another_task_to_it() -> None:
    gripper, peer = robotiq()
    states: list[GripperState] = []

    async def close() -> None:
        states.append(await gripper.close())

    async with anyio.create_task_group() as others:
        async with gripper:
            await gripper.activate()
            behave = peer.before_read
            peer.before_read = lambda reads: behave(min(reads, 2))  # it moves for ever
            others.start_soon(close)
            await eventually_async(lambda: gripper.state.moving)
        peer.before_read = behave
    assert states[0].holding


def test_models_have_figures_and_a_source() -> None:
    for name, model in GRIPPERS.items():
        assert model.name == name
        assert 0.0 < model.force[0] <= model.force[1]
        assert model.source
    with pytest.raises(errors.ParameterError, match="robotiq_2f85"):
        Robotiq(ModbusRtu(Port(Peer(9).write, Peer(9).read), 9), "robotiq")


async def test_a_driver_of_ones_own_is_short_and_works() -> None:
    module = example("gripper_of_your_own")
    assert len(inspect.getsource(module).splitlines()) <= 50
    peer = Peer(1)
    peer.before_read = lambda _: peer.registers.update({0x10: 250, 0x11: 2})
    gripper: PolledGripper = module.MyGripper(ModbusRtu(Port(peer.write, peer.read), 1))
    async with gripper:
        state = await gripper.close(force=20.0)
        assert state.width == pytest.approx(0.025)
        assert state.holding
        await gripper.halt()
    assert peer.written == [(0, [0, 50, 20]), (2, [1])]


@pytest.mark.parametrize("make", [robotiq, dh])
async def test_a_force_that_cannot_be_set_is_the_largest(make: Any) -> None:
    """A model of your own may have one force, and one speed."""
    fixed = make()[0].model._replace(force=(50.0, 50.0), speed=(0.05, 0.05))
    gripper, peer = make(model=fixed)
    async with gripper:
        await gripper.activate()
        await gripper.close()
    largest = {0x0101: 100, 0x0104: 100} if make is dh else {0x03EA: 0xFFFF}
    assert {address: peer.registers[address] for address in largest} == largest


@for_each(
    "model", ["parallel", "vacuum", "robotiq_2f58", 3, math.nan, ["dh_pge"], GRIPPERS["vacuum"]]
)
def test_a_model_of_another_make_is_refused(model: Any) -> None:
    for kind, own in ((Robotiq, "robotiq_2f85"), (DhGripper, "dh_ag95")):
        port = Port(Peer(1).write, Peer(1).read)
        with pytest.raises(ParameterError, match="model is"):
            kind(ModbusRtu(port, 1), model)
        assert kind(ModbusRtu(port, 1), own).model.name == own
