"""A connected robot for the duration of a command."""

from __future__ import annotations

import time
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Final

from aioduco.cli.exit_codes import (
    Terminated,
    cannot_listen,
    ended_by_errors,
    fail,
    say_error,
)
from aioduco.cli.output import say
from aioduco.cli.questions import GIVES_WAY, ask

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from aioduco.cli.addresses import RobotAddress
    from aioduco.envelope import Envelope
    from aioduco.kinematics import Arm
    from aioduco.models.enums import RobotState, SafetyState
    from aioduco.models.pose import JointsLike, Pose
    from aioduco.models.state import RobotStates
    from aioduco.sync import Robot


#: seconds between two checks whether the work has ended
_LOOK: Final = 0.1
#: seconds without an answer after which that is said
_SILENT: Final = 1.0
#: difference of a joint from which an arm is elsewhere [rad]
_ELSEWHERE: Final = 0.01
#: distance of a tool's tip from which it is elsewhere [m]
_ELSEWHERE_LINE: Final = 0.002


@contextmanager
def observing_session(address: RobotAddress, **options: Any) -> Iterator[Robot]:
    """Connect without a heartbeat: the program that moves the arm keeps its supervision.

    Errors and signals end the command. Disconnecting stops nothing.

    Args:
        address: address of the controller.
        options: further options of `connect`.
    """
    import aioduco.sync  # noqa: PLC0415 - for commands with a robot alone

    options = {"heartbeat": None, "lag_limit": None, **options}
    with (
        ended_by_errors(at=address.where),
        aioduco.sync.connect(address.host, address.port, **options) as robot,
    ):
        yield robot


@contextmanager
def control_session(address: RobotAddress, **options: Any) -> Iterator[Robot]:
    """Connect with a heartbeat. However the command ends, the arm is stopped first.

    A robot of a cell is kept within the cell's limits.

    Args:
        address: address of the controller.
        options: further options of `connect`.
    """
    import aioduco.sync  # noqa: PLC0415 - for commands with a robot alone

    options = {"lag_limit": None, **options}
    with ended_by_errors("interrupted: the arm was stopped, and stands", address.where):
        limits = limits_at(address)
        with aioduco.sync.connect(address.host, address.port, **options) as robot:
            if limits is not None:
                robot.envelope = limits
            yield robot


@contextmanager
def guided_session(address: RobotAddress, states: RobotStates, *, yes: bool) -> Iterator[Robot]:
    """Ask, and let a hand guide the arm in the block. However the command ends, the arm stands.

    Args:
        address: address of the controller.
        states: what the question is about: the command ends if they have changed since.
        yes: whether not to ask.
    """
    ask(GIVES_WAY.format(address), "Let it give way?", yes=yes)
    # A person may take any time: hand guiding must not stop because no call is made.
    with control_session(address, hold_limit=None) as robot:
        require_same_state(robot, states.robot, states.safety)
        robot.bring_up()
        with robot.motion.teach_mode.start():
            yield robot


def reported_name(robot: Robot) -> str:
    """The arm that the controller reports, in its words; empty if it reports none."""
    from aioduco.errors import UnknownFunction  # noqa: PLC0415 - quick help
    from aioduco.kinematics.catalogue import arm_named  # noqa: PLC0415

    try:
        return arm_named(robot.version.get_robot_type())
    except UnknownFunction:
        return ""


def reported_arm(robot: Robot) -> Arm | None:
    """The arm that the controller reports; None if it reports none, or an unknown one."""
    from aioduco.kinematics.catalogue import model_named  # noqa: PLC0415 - quick help

    return model_named(reported_name(robot))


def require_reported_arm(robot: Robot, option: str) -> Arm:
    """The arm that the controller reports; end the command if it reports none that is known.

    Args:
        robot: the robot.
        option: the option that says which arm it is, for the message.
    """
    found = reported_arm(robot)
    if found is None:
        fail(f"the controller tells no arm that is known: {option} says which one it is")
    return found


def require_same_state(robot: Robot, state: RobotState, safety: SafetyState) -> None:
    """End the command if the arm, which it brings up, was stopped or switched since its question.

    Args:
        robot: the robot.
        state: state of the robot at the question.
        safety: state of the safety controller then.
    """
    now = robot.state.get_robot_state()
    if (now.robot, now.safety) != (state, safety):
        fail(
            f"the arm is no longer as when the question was asked: {now}; nothing was sent that "
            "moves it. Give the command again"
        )


def guiding(robot: Robot) -> Callable[[], None]:
    """A check that ends the command if an arm that a hand guides was stopped, or switched off.

    A stop by another program is seen if the controller says at the beginning, while the arm stands,
    that something runs: it need not say that of hand guiding.

    Args:
        robot: the robot, whose hand guiding has just begun.
    """
    from aioduco.models.enums import ProgramState, RobotState, SafetyState  # noqa: PLC0415 - quick help

    def runs(states: RobotStates) -> bool:
        return states.program in (ProgramState.RUNNING, ProgramState.TASK_RUNNING)

    said = runs(robot.state.get_robot_state())

    def check() -> None:
        now = robot.state.get_robot_state()
        unsafe = now.safety not in (SafetyState.RUN, SafetyState.REDUCE, SafetyState.MODEL)
        if now.robot is not RobotState.ENABLE or unsafe or (said and not runs(now)):
            fail(
                f"the arm is stopped, and no hand guides it any more: {now}; nothing more was "
                "stored"
            )

    return check


def require_still_at(robot: Robot, joints: JointsLike, pose: Pose | None = None) -> None:
    """End the command if the arm is no longer where the question before a motion was about.

    A person may take minutes for the answer, in which another program or a hand moves the arm, or
    puts another tool or work object into use.

    Args:
        robot: the robot.
        joints: joint angles of the arm at the question [rad].
        pose: pose of its tool in the work object then, if the motion depends on it.
    """
    what = ""
    if not robot.state.get_actual_joints_position().almost_equal(joints, _ELSEWHERE):
        what = "the arm"
    elif pose is not None and not robot.state.get_tcp_pose_coord().almost_equal(
        pose, position=_ELSEWHERE_LINE, rotation=_ELSEWHERE
    ):
        what = "the tip of its tool, or its work object,"
    if what:
        fail(
            f"{what} is elsewhere than before the question was asked: nothing was sent that moves "
            "the arm. Give the command again"
        )


@contextmanager
def page_session(address: RobotAddress, where: str) -> Iterator[None]:
    """Serve a page about an arm. Errors and signals end the command.

    Args:
        address: address of the controller.
        where: where the page listens, for the message if that is not possible.
    """
    from aioduco.errors import DucoError  # noqa: PLC0415 - for commands with a page alone

    with ended_by_errors(at=address.where):
        try:
            yield
        except DucoError:
            raise  # no controller: some are errors of the system, too, and none of this page's port
        except OSError as error:
            cannot_listen(where, error)


def limits_at(address: RobotAddress) -> Envelope | None:
    """The limits that a robot's cell has for it; None without a cell, or limits."""
    import aioduco  # noqa: PLC0415

    return aioduco.Cell.load(address.cell).envelope(address.name) if address.cell else None


def wait_until_ended(
    what: str, robot: Robot, going: Callable[[], bool], seconds: float | None
) -> bool:
    """Print what is running, and wait until it ends: by itself, after a time, or by Ctrl-C.

    It says when the robot's feed is no longer answered, and when it is again.

    Args:
        what: the line to print; once it is printed, Ctrl-C is the way to end the work.
        robot: the robot that the work observes.
        going: returns whether the work is still running.
        seconds: longest time to wait; None for no limit.

    Returns:
        Whether the feed was answered at the end.

    Raises:
        Terminated: on SIGTERM and SIGHUP.
    """
    until = None if seconds is None else time.monotonic() + seconds
    silent_since, silent = time.monotonic(), False
    try:
        say(f"{what}; Ctrl-C ends it")
        while going() and (until is None or time.monotonic() < until):
            left = _LOOK if until is None else until - time.monotonic()
            robot.sleep(min(_LOOK, max(0.0, left)))
            error = robot.feed.error
            if error is None:
                silent_since = time.monotonic()
            if (error is not None and time.monotonic() - silent_since > _SILENT) != silent:
                silent = not silent
                said = f"the controller does not answer: {error}" if silent else "it answers again"
                say_error(said)
    except Terminated:
        raise
    except KeyboardInterrupt:
        say()  # so that the ^C has a line of its own
    return not silent
