"""A gripper that stops reporting while it carries: errors say what was done to the arm."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any

import anyio
import pytest
from client.bench import HOME, Bench
from for_each import for_each

import aioduco
import aioduco.sync
from aioduco import errors
from aioduco._wire import rpc
from aioduco.devices.grippers import DigitalGripper, GripperState, PolledGripper
from aioduco.models.gripper_models import GripperModel, gripper_model
from aioduco.robot import Robot
from aioduco.testing import eventually, eventually_async

from .test_drivers import robotiq

PARALLEL = gripper_model("parallel")


class Hand(PolledGripper):
    """A gripper that holds something once it was closed, and reports what the test says."""

    def __init__(
        self, robot: Robot | None = None, *, max_age: float = 30.0, model: GripperModel = PARALLEL
    ) -> None:
        del robot
        super().__init__(model, poll=0.005, max_age=max_age)
        self.holding: bool | None = None
        self.error: Exception | None = None
        self.answers = anyio.Event()
        self.answers.set()

    async def _read(self) -> GripperState:
        await self.answers.wait()
        if self.error is not None:
            raise self.error
        return GripperState(0.02, self.holding, False, time.monotonic())

    async def _go(self, width: float, speed: float, force: float) -> None:
        del width, speed, force
        self.holding = True

    async def _halt(self) -> None:
        pass


#: short, and only once the gripper is silent: before that a busy machine may be late with a poll
SOON = 0.05


def answer_nothing(hand: Hand) -> None:
    hand.error = errors.ModbusTimeout("device 1 did not answer")


def fail(hand: Hand) -> None:
    hand.error = ValueError("a driver's own fault")


def hang(hand: Hand) -> None:
    hand.answers = anyio.Event()


def lose_power(hand: Hand) -> None:
    hand.holding = None


@for_each(
    "fall_silent, why",
    [
        (answer_nothing, "reported nothing for .* did not answer"),
        (fail, "reported nothing for .* own fault"),
        (hang, "reported nothing for"),
        (lose_power, "does not report it any more"),
    ],
)
async def test_a_gripper_that_falls_silent_ends_what_is_awaited(
    fall_silent: Callable[[Hand], None], why: str
) -> None:
    async with Hand() as hand:
        await hand.close()
        hand.check_held()

        async def carry() -> None:
            async with hand.carrying():
                fall_silent(hand)
                hand._max_age = SOON
                await anyio.sleep_forever()

        with pytest.raises(errors.HoldUnknown, match=why) as raised:
            await carry()
        assert "a motion that it awaited was stopped" in str(raised.value)
        with pytest.raises(errors.HoldUnknown, match="nothing was done to the arm"):
            hand.check_held()
        with pytest.raises(errors.HoldUnknown, match="nothing was done to the arm"):
            async with hand.carrying():
                pytest.fail("it is not known whether it holds something")


async def test_what_it_held_before_the_program_is_missed_too() -> None:
    """The arm went on without the part."""
    hand = Hand()
    hand.holding = True
    async with hand:

        async def carry() -> None:
            async with hand.carrying():
                hand.holding = False
                await anyio.sleep_forever()

        with anyio.fail_after(20.0), pytest.raises(errors.ObjectLost, match="was stopped"):
            await carry()


async def test_what_it_held_before_the_program_is_not_taken_for_held_without_power() -> None:
    hand = Hand()
    hand.holding = True
    async with hand:
        hand.check_held()
        lose_power(hand)
        await eventually_async(lambda: hand.state.holding is None)
        with pytest.raises(errors.HoldUnknown, match="does not report it any more"):
            hand.check_held()


async def test_a_gripper_that_reports_again_is_known_again() -> None:
    async with Hand() as hand:
        await hand.close()
        fail(hand)
        hand._max_age = SOON
        await eventually_async(lambda: bool(hand._unknown))
        hand._max_age = 30.0
        hand.error = None  # its failure did not end the polling
        await eventually_async(lambda: not hand._unknown)
        async with hand.carrying():
            hand.check_held()


async def test_a_gripper_that_is_not_polled_any_more_carries_nothing() -> None:
    async with Hand() as hand:
        await hand.close()
    hand._max_age = SOON
    with pytest.raises(errors.GripperError, match="not polled"):
        async with hand.carrying():
            pytest.fail("nothing would notice a loss")
    await eventually_async(lambda: hand.state.age > SOON)
    with pytest.raises(errors.HoldUnknown):
        hand.check_held()


@pytest.mark.slow
async def test_time_in_which_the_event_loop_stood_still_does_not_count() -> None:
    async with Hand(max_age=1.0) as hand:
        await hand.close()
        async with hand.carrying():
            hang(hand)
            time.sleep(1.5)  # noqa: ASYNC251 - a hung loop is what is tested: longer than max_age
            for _ in range(5):
                await anyio.lowlevel.checkpoint()
            hand.answers.set()
            before = hand.state.read_at
            await eventually_async(lambda: hand.state.read_at > before)


async def test_an_error_says_what_was_done_to_the_arm() -> None:
    async with Hand() as hand:
        await hand.close()

        async def carry(*, awaited: bool) -> None:
            async with hand.carrying():
                hand.holding = False
                if awaited:
                    await anyio.sleep_forever()
                hand._lost = True  # as a poll does that comes with the last await of the block

        with pytest.raises(errors.ObjectLost, match="had ended by then: nothing was done"):
            await carry(awaited=False)
        with pytest.raises(errors.ObjectLost, match="look where it lies; nothing was done"):
            hand.check_held()
        await hand.close()
        with pytest.raises(errors.ObjectLost, match="a motion that it awaited was stopped"):
            await carry(awaited=True)


async def test_a_robotiq_that_was_without_power_is_not_trusted() -> None:
    gripper, peer = robotiq()
    async with gripper:
        await gripper.activate()
        await gripper.close()

        async def carry() -> None:
            async with gripper.carrying():
                peer.before_read = lambda _: peer.registers.update({0x07D0: 0})
                await anyio.sleep_forever()

        with pytest.raises(errors.HoldUnknown, match="its power may have been off"):
            await carry()


async def test_the_arm_is_stopped_when_the_inputs_are_not_read_any_more() -> None:
    """A gripper on inputs is as silent as the samples of the state."""
    with Bench() as bench:
        bench.motion_time = 60.0
        async with (
            aioduco.connect(bench.host, bench.port) as robot,
            DigitalGripper(robot, 1, holds=1, max_age=30.0) as gripper,
        ):
            assert (await gripper.close()).holding

            async def carry() -> None:
                async with gripper.carrying():
                    task = await robot.motion.movej2(HOME, v=1.0, a=1.0).start()
                    bench.hold("getRobotIOStatus", rpc.IOStatus(digitalInputs=[True] * 16))
                    gripper._max_age = SOON
                    await task

            with pytest.raises(errors.HoldUnknown):
                await carry()
            assert not bench.moving()
            assert bench.commands[-2:] == ["movej2", "stop"]


async def test_an_input_that_the_controller_does_not_tell_is_named() -> None:
    with Bench() as bench:
        bench.answer("getRobotIOStatus", rpc.IOStatus(digitalInputs=[False] * 2))
        async with aioduco.connect(bench.host, bench.port) as robot:
            with pytest.raises(
                errors.ParameterError, match="num is 3, but must be a whole number from 1 to 2"
            ):
                await DigitalGripper(robot, 1, holds=3).start()


async def test_a_sample_from_before_a_movement_does_not_say_how_it_ended() -> None:
    """The input for shut was off before; that it is still off is not known."""
    with Bench() as bench:
        off = rpc.IOStatus(digitalInputs=[False] * 16)
        bench.answer("getRobotIOStatus", off)
        async with (
            aioduco.connect(bench.host, bench.port) as robot,
            DigitalGripper(robot, 1, shut=3, travel_time=0.001, timeout=30.0) as gripper,
        ):
            asked = len(bench.received("getRobotIOStatus"))
            bench.hold("getRobotIOStatus", off)
            await eventually_async(lambda: len(bench.received("getRobotIOStatus")) > asked)
            gripper._timeout = 0.3
            with pytest.raises(errors.GripperTimeout, match=r"its outputs stay .* may still move"):
                await gripper.close()


@for_each(
    "name, value",
    [
        ("name", 3),
        ("title", ""),
        ("stroke", -1.0),
        ("stroke", [1.0]),
        ("force", 3.0),
        ("force", (5.0, 1.0)),
        ("speed", "fast"),
        ("fastest", math.nan),
    ],
)
def test_the_figures_of_a_gripper_of_ones_own_are_checked(name: str, value: Any) -> None:
    changed: dict[str, Any] = {name: value}
    with pytest.raises(errors.ParameterError, match=f"^{name}"):
        Hand(model=PARALLEL._replace(**changed))


@for_each("model", ["parallel", None, 3])
def test_the_model_of_a_gripper_is_a_model(model: Any) -> None:
    with pytest.raises(errors.ParameterError, match="model is"):
        Hand(model=model)


async def test_a_gripper_is_polled_once_however_often_it_is_started() -> None:
    hand = Hand()
    async with hand:
        polls = len(hand._background)
        with pytest.raises(errors.GripperError, match=r"is started already.* Nothing was sent"):
            await hand.start()
        assert len(hand._background) == polls
    answer_nothing(hand)
    with pytest.raises(errors.ModbusTimeout):
        await hand.start()
    hand.error = None
    async with hand:  # neither its end nor a start that failed counts
        assert len(hand._background) == polls


def test_a_program_that_waits_notices_it_between_motions() -> None:
    with (
        Bench() as bench,
        aioduco.sync.connect(bench.host, bench.port) as robot,
        aioduco.sync.Gripper(robot, Hand) as gripper,
    ):
        gripper.close()
        gripper.check_held()
        hand = gripper._made
        assert isinstance(hand, Hand)
        answer_nothing(hand)
        hand._max_age = SOON
        eventually(lambda: hand._silent)
        with pytest.raises(errors.HoldUnknown, match="did not answer"):
            gripper.check_held()


async def test_errors_of_ones_own_driver_stand_for_no_cancellation_and_no_time_out() -> None:
    """A cancellation came out as the error of the driver, and that as one of another time-out."""

    class Gone(Hand):
        async def _go(self, width: float, speed: float, force: float) -> None:
            del width, speed
            if force:
                raise TimeoutError("the port does not answer")
            await anyio.sleep_forever()

        async def _halt(self) -> None:
            raise OSError("the port is gone")

    gripper = Gone(model=PARALLEL._replace(force=(0.0, 10.0)))
    with anyio.move_on_after(0.02) as scope:
        await gripper.close(force=0.0)
    assert scope.cancelled_caught
    with pytest.raises(TimeoutError, match="the port does not answer"):
        await gripper.close(force=10.0)
    gripper._timeout = 0.02
    with pytest.raises(errors.GripperTimeout, match="could not be halted"):
        await gripper.close(force=0.0)
