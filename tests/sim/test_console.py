"""Rules from outputs to inputs, and commands of a person at the machine."""

from __future__ import annotations

import contextlib
import math
import socket
from collections.abc import Callable
from contextlib import closing
from itertools import product

import numpy as np
import pytest
from for_each import for_each

from aioduco.kinematics import arm
from aioduco.models.enums import OperationMode, TaskState
from aioduco.sim.cabinet.signals import Signals
from aioduco.sim.console import COMMANDS, Console
from aioduco.sim.controller.signal_rules import SignalRule, SignalRules
from aioduco.sim.physics.world import World
from aioduco.sim.planner.path import JointSetPoint
from aioduco.sim.server.line_server import LineServer
from aioduco.sim.simulator import READY, Simulator

from .conftest import Connect, Program, standing_time


def test_an_input_follows_its_output_after_a_time() -> None:
    signals, rules = Signals(), SignalRules()
    rules.add(SignalRule(1, 3, 0.5))
    rules.add(SignalRule(1, "tool 2", 0.1, inverted=True))
    rules.add(SignalRule("tool 1", 4))
    seen = []
    for cycle in range(30):
        signals.standard_out[1] = 5 <= cycle < 15
        signals.tool_out[1] = cycle == 7
        rules.tick(cycle * 0.1, signals)
        seen.append((signals.standard_in[3], signals.tool_in[2], signals.standard_in[4]))
    closed, opened, held = (list(states) for states in zip(*seen, strict=True))
    assert [cycle for cycle, on in enumerate(closed) if on] == list(range(10, 20))
    assert [cycle for cycle, on in enumerate(opened) if not on] == list(range(6, 16))
    assert [cycle for cycle, on in enumerate(held) if on] == [7]
    assert not rules.busy
    rules.add(SignalRule(2, 3))  # instead of the first
    signals.standard_out[1] = True
    rules.tick(3.0, signals)
    rules.tick(9.0, signals)
    assert not signals.standard_in[3]


@for_each(
    "rule, what",
    [
        ((0, 1), "output is 0"),
        ((1, 17), "input is 17"),
        (("tool 3", 1), "output is 'tool 3'"),
        ((1, "lamp 1"), "input is 'lamp 1'"),
        ((1, 1, -0.1), "after is -0.1"),
        ((1, 1, math.inf), "after is inf"),
    ],
)
def test_a_rule_of_what_is_not_there(rule: tuple[int, int, float], what: str) -> None:
    with pytest.raises(ValueError, match=what):
        SignalRule(*rule)


def test_a_gripper_tells_when_it_has_closed(connect: Connect) -> None:
    simulator = Simulator(speed=math.inf)
    simulator.rule(output=1, input=3, after=0.5)  # before the start
    with simulator as sim:
        sim.rule(output=1, input=4, inverted=True)
        robot = connect(sim)
        sim.wait_until(lambda: robot.get_standard_digital_in(4))
        began = sim.time
        robot.set_standard_digital_out(1, True, True)
        sim.wait_until(lambda: robot.get_standard_digital_in(3), 60.0)
        assert round((sim.time - began) * 1000) >= 500
        assert not robot.get_standard_digital_in(4)


def test_rules_hold_for_a_simulator_that_is_started_again(connect: Connect) -> None:
    simulator = Simulator(speed=math.inf)
    simulator.rule(output=1, input=4, inverted=True)
    simulator.rule(output=2, input=5, after=1.0)
    with simulator as sim:
        connect(sim).set_standard_digital_out(2, True, True)
        sim.wait_until(lambda: sim.signals.standard_in[4])
    with simulator as sim:
        sim.wait_until(lambda: sim.signals.standard_in[4])
        sim.wait_until(lambda: sim.time > 2.0)
        assert not sim.signals.standard_in[5]


def test_a_rule_goes_before_the_gripper_that_is_wired_to_the_input(connect: Connect) -> None:
    with Simulator(speed=math.inf, gripper="parallel") as sim:
        robot = connect(sim)
        sim.rule(output=5, input=1)
        with standing_time(sim):
            robot.set_standard_digital_out(5, True, True)
            sim.advance(10)
            assert robot.get_standard_digital_in(1)
            assert robot.get_standard_digital_in(2)  # without a rule: the fingers are open


# -- in words ------------------------------------------------------------------------------------


def test_commands_do_what_they_say(sim: Simulator, robot: Program) -> None:
    say = Console(sim).answer
    assert [say("input 3 on"), say("input tool 1 on"), say("voltage 2 7.5")] == ["ok"] * 3
    assert robot.get_standard_digital_in(3)
    assert robot.get_tool_digital_in(1)
    assert robot.get_standard_analog_voltage_in(2) == 7.5
    assert say("input 3 off") == "ok"
    assert not robot.get_standard_digital_in(3)
    robot.set_standard_digital_out(5, True, True)
    assert [say("output 5"), say("output 6"), say("output tool 1")] == ["on", "off", "off"]
    assert say("rule 5 7 0.01") == say("rule 5 tool 2 inverted") == "ok"
    sim.wait_until(lambda: robot.get_standard_digital_in(7))

    assert say("push 0 0 -20") == "ok"
    sim.wait_until(lambda: robot.get_tcp_force()[2] < -15.0)
    assert say("push") == say("load 0") == "ok"
    sim.wait_until(lambda: abs(robot.get_tcp_force()[2]) < 1.0)
    assert say("mode remote") == "ok"
    assert robot.get_robot_state()[3] == OperationMode.REMOTE
    assert say("collide 2") == "ok"
    assert robot.getRobotStatus().collisionAxis == 2
    assert say("estop") == "ok"
    assert robot.to(*READY) == TaskState.ILLEGAL
    told = say("state")
    assert "moving no\nstates " in told
    assert "error list: emergency stop pressed" in told
    assert say("release") == say("speed 50") == "ok"
    assert sim.speed == 50.0
    assert say("drop") == "1 connections were cut"
    assert say("help").count("\n") == len(COMMANDS) - 1 == say("").count("\n")


@for_each(
    "line, said",
    [
        ("jump", "there is no command 'jump'; there are input, output"),
        ("inptu 3 on", "did you mean 'input'?"),
        ("input 3", "on or off?; usage: input [tool] NUM on|off"),
        ("input three on", "which signal?"),
        ("input 17 on", "there is no signal 17"),
        ("push 1 2", "2 numbers; usage: push [FX FY FZ"),
        ("push a b c", "'a b c' are no numbers"),
        ("mode fast", "one of manual, auto, remote"),
        ("estop now", "'now' is too much"),
        ("collide 9", "joint is 9"),
        ("rule 1 99", "input is 99"),
        ("speed -1", "speed"),
        ("push nan 0 0", "'nan 0 0' are no numbers"),
        ("push 0 0 1e300", "must be a number from -10000 to 10000 N"),
        ("load 1e9", "must be a number from 0 to 1000 kg"),
        ("voltage 1.5 1", "1.5 is no whole number"),
        ("collide inf", "inf is no whole number"),
    ],
)
def test_a_command_that_makes_no_sense_says_so(cell: Simulator, line: str, said: str) -> None:
    answer = Console(cell).answer(line)
    assert answer.startswith("error: ")
    assert said in answer


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_no_number_enters_that_is_none(sim: Simulator, bad: float) -> None:
    rail = {"rail": [(-1.0, 1.0, 0.5, 2.0, 0.0, bad)]}
    refused: list[Callable[[], object]] = [
        lambda: sim.push([0.0, 0.0, 0.0, 0.0, 0.0, bad]),
        lambda: sim.load(bad),
        lambda: sim.load(1.0, (0.0, bad, 0.0)),
        lambda: sim.rule(1, 2, after=bad),
        lambda: sim.collide(bad),  # type: ignore[arg-type]
        lambda: sim.signals.voltage_in.__setitem__(1, bad),
        lambda: sim.signals.tool_voltage_in.__setitem__(1, bad),
        lambda: Simulator(joints=[bad] * 6),
        lambda: Simulator(mounting=(0.0, 0.0, bad, 0.0, 0.0, 0.0)),
        lambda: Simulator(pedestal=bad),
        lambda: Simulator(cycle=bad),
        lambda: Simulator(vibration_time=bad),
        lambda: Simulator(program_lag=bad),
        lambda: Simulator(heartbeat_slack=bad),
        lambda: Simulator(values={"a": [1.0, bad]}),
        lambda: Simulator(external_axes=rail),
    ]
    if math.isnan(bad):
        refused += [
            lambda: Simulator(speed=bad),
            lambda: setattr(sim, "speed", bad),
            lambda: sim.clock.hold(bad),
            lambda: sim.wait_until(lambda: False, bad),
            lambda: sim.advance(bad),  # type: ignore[arg-type]
        ]
    before = sim.joints
    for number, enter in enumerate(refused):
        with pytest.raises(ValueError, match=r"is|would|must|finite"):
            pytest.fail(f"number {number} was taken: {enter()}")
    sim.wait_until(lambda: sim.time > 0.1)
    assert sim.joints == pytest.approx(before, abs=1e-4)


def test_what_cannot_be_computed_is_said_and_moves_nothing() -> None:
    world = World(arm("gcr5_910"), q=np.array(READY))
    stand = JointSetPoint.at_rest(np.array(READY))
    world.step(stand)
    world.data.xfrc_applied[:] = math.nan
    with pytest.raises(ArithmeticError, match="too large to compute with"):
        world.step(stand)


def test_lines_are_answered_in_order_until_the_port_is_closed() -> None:
    with closing(LineServer(str.upper, 0)) as lines:
        with socket.create_connection(("127.0.0.1", lines.port), timeout=30) as client:
            client.sendall("one\ntwö\n".encode())
            client.shutdown(socket.SHUT_WR)
            with client.makefile("rb") as answer:
                assert answer.read().decode().split() == ["ONE", "TWÖ"]
        with pytest.raises(OSError, match="in use"):
            LineServer(str.upper, lines.port)
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection(("127.0.0.1", lines.port), timeout=30)


@for_each("length, method", product([1, 5000], ["POST", "GET", "OPTIONS"]))
def test_no_part_of_a_request_of_a_browser_is_a_command(method: str, length: int) -> None:
    seen: list[str] = []

    def answer(line: str) -> str:
        seen.append(line)
        return "ok"

    with closing(LineServer(answer, 0)) as lines:
        request = f"{method} /{'a' * length} HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\nestop\n".encode()
        with socket.create_connection(("127.0.0.1", lines.port), timeout=60.0) as client:
            client.sendall(request)
            with contextlib.suppress(ConnectionError):  # it is closed with the rest unread
                assert client.recv(100) == b""
    assert seen == []


@for_each("length", [999, 1000, 1001, 5000])
def test_no_part_of_a_line_that_is_too_long_is_a_command(length: int) -> None:
    seen: list[str] = []

    def answer(line: str) -> str:
        seen.append(line.strip())
        return "ok"

    with (
        closing(LineServer(answer, 0)) as lines,
        socket.create_connection(("127.0.0.1", lines.port), timeout=60.0) as client,
        client.makefile("rb") as answers,
    ):
        client.sendall(b"#" * length + b"estop\nstate\n")
        assert answers.readline().startswith(b"error: a line has")
        assert answers.readline() == b"ok\n"
        client.sendall(b"#" * 999 + b"\n")  # 1,000 bytes with its end
        assert answers.readline() == b"ok\n"
    assert seen == ["state", "#" * 999]
