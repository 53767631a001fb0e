"""Simulated grippers: they hold things by friction, and drop them."""

from __future__ import annotations

import math
import time
from types import SimpleNamespace
from typing import Any

import anyio
import numpy as np
import pytest
from example_modules import example
from for_each import for_each

import aioduco
import aioduco.sync
from aioduco import errors
from aioduco.devices.grippers import DhGripper, DigitalGripper, Robotiq, VacuumGripper
from aioduco.sim import Simulator
from aioduco.sim.physics.gripper import FingerControl, GripperOrder

from .carrying import carry

STEP = 0.001
#: a busy machine takes seconds over what takes a millisecond
PATIENT: dict[str, Any] = {"answer_timeout": 10.0, "timeout": 30.0}


# -- what the fingers are told: a state machine without physics ----------------------------------


def led(
    control: FingerControl, order: GripperOrder, start: float, stop: float, seconds: float
) -> float:
    """Let the fingers follow, down to an opening at which something stops them."""
    opening = start
    for _ in range(round(seconds / STEP)):
        aim = control.tick(order, opening, 0.0, STEP)
        opening = max(aim, stop)
    return opening


def test_fingers_go_at_their_speed_and_stop_at_what_is_there() -> None:
    control = FingerControl(0.08)
    order = GripperOrder(1, (0.0,), 0.1, 60.0)
    opening = led(control, order, 0.08, 0.03, 0.2)
    assert opening == pytest.approx(0.06, abs=1e-3)
    assert control.reading(opening).moving
    opening = led(control, order, opening, 0.03, 1.0)
    assert control.reading(opening)[2:] == (False, 1, False)
    # The drive presses with its force: as far beyond as its stiffness takes, or more.
    assert 0.03 - control.tick(order, opening, 0.0, STEP) >= 60.0 / 20_000.0
    # What was held is gone: they go on to where they were sent.
    opening = led(control, order, opening - 0.01, 0.0, 1.0)
    assert control.reading(opening)[2:] == (False, 0, True)
    assert opening == pytest.approx(0.0, abs=1e-3)


def test_fingers_go_through_their_stroke_and_halt() -> None:
    control = FingerControl(0.04)
    ends = GripperOrder(1, (0.08, 0.0, 0.08), 0.2, 60.0)
    opening = led(control, ends, 0.04, 0.0, 0.5)
    assert control.reading(opening).moving
    opening = led(control, ends, opening, 0.0, 1.0)
    assert (round(opening, 3), control.reading(opening).moving) == (0.08, False)
    closing = GripperOrder(2, (0.0,), 0.1, 60.0)
    opening = led(control, closing, opening, 0.0, 0.3)
    halted = led(control, GripperOrder(3, (), 0.0, 0.0), opening, 0.0, 0.3)
    assert halted == pytest.approx(opening, abs=1e-3)
    assert not control.reading(halted).moving


# -- the whole way: driver, wire, registers, fingers, box ----------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(10))
async def test_it_lifts_carries_and_puts_down(seed: int) -> None:
    trial = await carry(seed)
    assert trial.succeeded, trial


@pytest.mark.slow
@pytest.mark.parametrize(
    ("gripper", "mass", "force"), [("robotiq_2f85", 4.0, 20.0), ("vacuum", 9.0, None)]
)
async def test_what_is_too_heavy_for_the_force_stays(
    gripper: str, mass: float, force: float | None
) -> None:
    trial = await carry(0, gripper=gripper, mass=mass, force=force)
    assert not trial.lifted


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "driver", "stroke"),
    [
        ("robotiq_hand_e", Robotiq.at_tool, 0.050),
        ("dh_pge", DhGripper.at_tool, 0.026),
        ("robotiq_2f140", Robotiq.at_tool, 0.140),
        ("dh_ag95", DhGripper.at_tool, 0.095),
    ],
)
async def test_registers_of_each(name: str, driver: Any, stroke: float) -> None:
    async with (
        Simulator(speed=math.inf, gripper=name) as sim,
        aioduco.connect(sim.host, sim.port, clock=sim.clock) as robot,
        driver(robot, name, **PATIENT) as gripper,
    ):
        with pytest.raises(errors.GripperNotActivated):
            await gripper.close()
        await gripper.activate()
        assert (await gripper.open()).width == pytest.approx(stroke, abs=5e-4)
        half = await gripper.move(0.5 * stroke)
        assert half.width == pytest.approx(0.5 * stroke, abs=1e-3)
        assert half.holding is False
        shut = await gripper.close()
        assert shut.width == pytest.approx(0.0, abs=1e-3)
        assert shut.holding is False
        moved = np.abs(sim.positions[6:8] - 0.5 * stroke).max()
        assert moved < 1e-3
        if name.startswith("robotiq"):
            # Activated again, it forgets nothing; reset, it must be activated.
            sim.cabinet.tool_serial.peer.write_registers(1000, [0, 0, 0])  # type: ignore[union-attr]  # it is a slave
            with pytest.raises(errors.GripperNotActivated):
                await gripper.open()


@pytest.mark.slow
async def test_the_arm_moves_while_the_gripper_is_silent() -> None:
    """Its state is asked for apart from motions: one that never answers holds none of them up."""
    async with (
        Simulator(speed=math.inf, gripper="robotiq_2f85") as sim,
        aioduco.connect(sim.host, sim.port, clock=sim.clock) as robot,
        Robotiq.at_tool(robot) as gripper,
    ):
        await robot.bring_up()
        sim.cabinet.tool_serial.peer = None
        with pytest.raises(errors.ModbusTimeout):  # behind what was on its way
            await gripper.read()
        known = gripper.state
        await robot.motion.movej2([0.1, 0.0, 1.5, 0.0, -1.5, 0.0], v=1.0, a=2.0)
        assert gripper.state is known


@pytest.mark.slow
async def test_signals_of_a_gripper_on_outputs() -> None:
    async with (
        Simulator(speed=math.inf, gripper="parallel") as sim,
        aioduco.connect(sim.host, sim.port, clock=sim.clock, state_rate=100) as robot,
        DigitalGripper(robot, 1, shut=3, opened=2, travel_time=1.0, timeout=30.0) as gripper,
    ):
        assert gripper.state.width == pytest.approx(0.08)
        with pytest.raises(errors.ParameterError, match="no positions between"):
            await gripper.move(0.04)
        with pytest.raises(errors.ParameterError, match="cannot be set"):
            await gripper.close(speed=0.1)
        closed = await gripper.close()
        assert (closed.width, closed.holding) == (0.0, False)
        with pytest.raises(errors.ObjectLost):
            gripper.check_held()
        opened = await gripper.open()
        assert opened.holding is False
        assert opened.width == pytest.approx(0.08)


async def test_a_gripper_on_an_output_without_sensors_takes_its_time() -> None:
    async with (
        Simulator(speed=math.inf) as sim,
        aioduco.connect(sim.host, sim.port, clock=sim.clock) as robot,
        DigitalGripper(robot, "tool 1", open="tool 2", travel_time=0.05, timeout=30.0) as gripper,
    ):
        closed = await gripper.close()
        assert (closed.width, closed.holding) == (None, None)
        assert (sim.signals.tool_out[1], sim.signals.tool_out[2]) == (True, False)
        opened = await gripper.open()
        assert opened.width == pytest.approx(0.08)
        assert (sim.signals.tool_out[1], sim.signals.tool_out[2]) == (False, True)
        for wrong in ("tool 3", "cabinet 1", 17):
            with pytest.raises(errors.ParameterError):
                DigitalGripper(robot, wrong)


@pytest.mark.slow
async def test_a_cup_that_finds_nothing() -> None:
    async with (
        Simulator(speed=math.inf, gripper="vacuum") as sim,
        aioduco.connect(sim.host, sim.port, clock=sim.clock) as robot,
        VacuumGripper(
            robot, 1, vacuum=1, blow_off=2, build_up=0.1, blow_time=0.02, timeout=30.0
        ) as cup,
    ):
        assert (await cup.close()).holding is False
        with pytest.raises(errors.ObjectLost):
            cup.check_held()
        assert (await cup.open()).holding is False
        assert not sim.signals.standard_out[2]
        for wrong in (cup.move(0.0), cup.close(force=10.0)):
            with pytest.raises(errors.ParameterError):
                await wrong
        await cup.aclose()
        with pytest.raises(errors.GripperError, match="block has ended"):
            await cup.close()
        assert not sim.signals.standard_out[1]


@for_each("wrong", ["robotiq_2f85", None])
def test_what_makes_no_driver_is_refused(wrong: Any) -> None:
    robot = aioduco.sync.connect("127.0.0.1", 1)
    with pytest.raises(errors.ParameterError, match="what makes the driver of a robot"):
        aioduco.sync.Gripper(robot, wrong)


@pytest.mark.slow
def test_for_programs_that_wait() -> None:
    with (
        Simulator(speed=math.inf, gripper="dh_ag95") as sim,
        aioduco.sync.connect(sim.host, sim.port, clock=sim.clock) as robot,
        aioduco.sync.Gripper(robot, DhGripper.at_tool, "dh_ag95", **PATIENT) as gripper,
    ):
        gripper.activate()
        assert gripper.model.title == "DH AG-95"
        assert gripper.open().width == pytest.approx(0.095, abs=5e-4)
        assert gripper.move(0.05).width == pytest.approx(0.05, abs=1e-3)
        assert gripper.close().holding is False
        assert gripper.read().width == pytest.approx(0.0, abs=1e-3)
        gripper.halt()
        with pytest.raises(errors.ObjectLost):
            gripper.check_held()
        assert gripper.state.age >= 0.0


def test_without_a_gripper_the_model_is_what_it_was() -> None:
    with Simulator(speed=math.inf) as sim:
        model = sim._running().pictures.model
        assert (model.nq, model.nu, model.neq, model.ntendon) == (6, 6, 0, 0)
        assert model.opt.impratio == 1.0
        assert sim.gripper is None
        assert sim.cabinet.tool_serial.peer is None


def test_a_simulator_takes_a_gripper_or_a_tool() -> None:
    with pytest.raises(errors.ParameterError, match="robotiq_2f85"):
        Simulator(gripper="hand")
    with pytest.raises(ValueError, match="one of the two"):
        Simulator(gripper="parallel", tool=[])


@pytest.mark.slow
async def test_the_example_of_a_dh_gripper(capsys: pytest.CaptureFixture[str]) -> None:
    with Simulator(speed=math.inf, gripper="dh_ag95") as sim:
        await example("gripper_dh").main(sim.host, sim.port)
    empty, apart = capsys.readouterr().out.splitlines()
    assert empty == "holds something: False"
    # the fingers still swing by parts of a millimetre when they meet
    assert 0.0 <= float(apart.removeprefix("the fingers are ").removesuffix(" mm apart")) < 1.0


class Outputs:
    """Stands for a robot: it has switched an output when the answer is lost, or cancelled."""

    def __init__(self, lost: int = 0) -> None:
        self.on: dict[int, bool] = {}
        self.lost = lost
        self.io = self.feed = self

    async def set_standard_digital_out(self, num: int, value: bool) -> None:
        self.on[num] = value
        if num == self.lost:
            self.lost = 0
            await anyio.sleep(math.inf)

    async def latest(self, *, max_age: float) -> Any:
        del max_age
        return SimpleNamespace(io=SimpleNamespace(received_at=time.monotonic()))


async def test_a_blow_off_that_is_cancelled_as_it_begins_is_switched_off() -> None:
    outputs: Any = Outputs(2)
    async with VacuumGripper(outputs, 1, blow_off=2) as cup:
        with anyio.move_on_after(0.05):
            await cup.open()
    assert outputs.on == {1: False, 2: False}


@pytest.mark.parametrize("held", [True, False])
async def test_a_cancelled_command_leaves_a_state_that_is_not_known(held: bool) -> None:
    outputs: Any = Outputs()
    gripper: Any = (
        VacuumGripper(outputs, 1, build_up=0.01)
        if held
        else DigitalGripper(outputs, 1, travel_time=0.01)
    )
    async with gripper:
        await (gripper.close() if held else gripper.open())
        outputs.lost = 1
        with anyio.move_on_after(0.05):
            await (gripper.open() if held else gripper.close())
        state = await gripper.read()
        assert (state.width, state.holding) == (None, None)
