"""Texts for people who do not write Python name what they have instead."""

from __future__ import annotations

import logging
import sys

import pytest
from for_each import for_each

import aioduco
from aioduco.cli.command_terms import commands, in_commands
from aioduco.integrations.panel.panel import _BUTTONS
from aioduco.integrations.ros.trajectory_goals import _IN_PLACE_OF, said
from aioduco.models.enums import OperationMode, ProgramState, RobotState, SafetyState
from aioduco.models.names import place
from aioduco.models.state import RobotStates
from aioduco.models.user_terms import TermsFormatter, in_terms_of
from aioduco.supervision.bringup import BringUp, RecoverReport


def states(program: ProgramState) -> RobotStates:
    return RobotStates(
        sequence=0,
        received_at=0.0,
        robot=RobotState.ENABLE,
        program=program,
        safety=SafetyState.RUN,
        mode=OperationMode.AUTO,
    )


def test_functions_are_replaced_and_nothing_else_is() -> None:
    names = {"stop": "STOP", "recover": "HELP", "rearm_heartbeat": "HELP"}
    for text, told in {
        "call robot.rearm_heartbeat() or robot.recover(), and go on": "call HELP, and go on",
        "robot.stop(), or stop() again": "STOP, or STOP again",
        "task.stop() of robot.motion.movel, robot.envelope": None,
        "a stop to recover from": None,
        "nonstop() robot.stopped": None,
    }.items():
        assert in_terms_of(names, text) == (told or text)


@for_each("names", [_IN_PLACE_OF, commands(), commands("10.0.0.7:7003"), _BUTTONS])
def test_every_door_names_what_it_has(names: dict[str, str]) -> None:
    assert all(place(name) or hasattr(aioduco.Robot, name) for name in names)
    told = ["the event loop hung; call robot.rearm_heartbeat() or robot.recover() to go on"]
    for program in (ProgramState.PAUSED, ProgramState.RUNNING):
        with pytest.raises(aioduco.RobotStateError) as refused:
            BringUp().next(states(program), emergency_stop=False, collision=False)
        told.append(str(refused.value))
    if "fc_force_set_value" in names:
        told.append(RecoverReport(states(ProgramState.STOPPED), True, sensor_tared=True).advice)
    for text in told:
        assert "robot." in text
        assert "robot." not in in_terms_of(names, text)
    assert said(told[0]) == "the event loop hung; call ~/recover to go on"


def test_the_user_of_commands_has_one_for_each_function_of_the_manual() -> None:
    assert in_commands("robot.motion.movel(...), get_tcp_pose() or robot.force.fc_start") == (
        "`aioduco call movel`(...), `aioduco call get_tcp_pose` or `aioduco call fc_start`"
    )
    assert in_commands("robot.rearm_heartbeat() or robot.recover()") == "`aioduco recover`"


def test_commands_name_the_arm_of_the_command_that_says_them() -> None:
    at = "10.0.0.7:7003"
    for text, told in {
        "call robot.recover()": f"call `aioduco recover {at}`",
        "bring_up()": f"`aioduco bring-up {at}`",
        "robot.motion.move_jog or robot.force.fc_start": (
            f"`aioduco jog --host {at}` or `aioduco call fc_start --host {at}`"
        ),
        "change robot.envelope": "change the envelope in the file that gives it",
    }.items():
        assert in_commands(text, at) == told


def test_log_messages_are_in_these_terms_and_tracebacks_stay() -> None:
    try:
        robot_recover()  # type: ignore[name-defined]  # raises
    except NameError:
        record = logging.LogRecord(
            "aioduco", logging.ERROR, "", 1, "call robot.%s()", ("recover",), sys.exc_info()
        )
    told = TermsFormatter(lambda text: in_terms_of({"recover": "HELP"}, text)).format(record)
    assert told.startswith("call HELP\nTraceback")
    assert "robot_recover()" in told
