"""Checks that move the arm: the last joint by 17 degrees, the first one by 6, slowly."""

from __future__ import annotations

import contextlib
import threading
import time
from typing import TYPE_CHECKING, Final

from aioduco._wire.rpc import Op
from aioduco.errors import DucoError
from aioduco.models.enums import ProgramState, SafetyState, TaskState
from aioduco.testing.conformance.check_session import MOTION, CheckSession, NotTried
from aioduco.testing.conformance.reading import check

if TYPE_CHECKING:
    from aioduco.testing.conformance.reading import Found, Looked


#: the checks of this module, in their order
MOVING: Final[list[Looked]] = []
#: how far the last joint turns at most, there and back [rad], and how fast [rad/s]
_TURN: Final = 0.3
_SLOW: Final = 0.1
#: motions that were carried out after a stop, from which on none is expected to be refused
_SURE: Final = 2
#: how far the first joint turns, once [rad]
_LEG: Final = 0.1
#: largest distance from a target at which it counts as reached [rad]
_AT: Final = 2e-3


@check(MOVING, "Tasks", "a motion that does not block", "an id above 8, FINISHED at its target")
def _finished(session: CheckSession) -> Found:
    goal = session.joints()
    goal[5] += _TURN / 3
    id_ = session.move(goal)
    state = session.own_end_of(id_)
    apart = abs(session.joints()[5] - goal[5])
    there = f"{apart:.2g} rad from its target"
    return id_ > 8 and state is TaskState.FINISHED and apart < _AT, f"id {id_}, {state}, {there}"


@check(MOVING, "Tasks", "a motion that blocks", "4")
def _blocking(session: CheckSession) -> Found:
    answer = session.let_go(None, session.turn(-_TURN / 3, block=True))
    return answer == TaskState.FINISHED, f"{answer}"


@check(MOVING, "States", "while a motion runs", "task 1, program 2")
def _running(session: CheckSession) -> Found:
    id_ = session.turn(_TURN, v=_SLOW)
    session.begun(id_)
    task, program = session.task(id_), session.call("get_robot_state")[1]
    in_time = (task, program) == (TaskState.RUNNING, ProgramState.RUNNING)
    return in_time, f"task {int(task)}, program {program}"


@check(
    MOVING,
    "Stop, pause, resume",
    "stop in mid motion",
    "stop answers 4, the motion 3, and the arm stands",
)
def _stopped(session: CheckSession) -> Found:
    id_ = session.turn(-_TURN, v=_SLOW)
    session.begun(id_)
    begin = time.monotonic()
    answer = session.call("stop", True, timeout=MOTION)
    took, moving = time.monotonic() - begin, session.moving()
    state = session.task(id_)
    same = (answer, state, moving) == (TaskState.FINISHED, TaskState.STOPPED, False)
    still = "moves" if moving else "stands"
    return same, f"stop answers {answer}, the motion {int(state)}, it {still} after {took:.2f} s"


@check(MOVING, "Tasks", "a motion that abort ended", "5")
def _aborted(session: CheckSession) -> Found:
    id_ = session.turn(_TURN, v=_SLOW)
    session.begun(id_)
    session.call("abort", True, timeout=MOTION)
    state = session.end_of(id_)
    return state is TaskState.INTERRUPT, f"{int(state)}"


@check(
    MOVING, "Stop, pause, resume", "pause and resume", "task 2 and the arm stands; 4 at its target"
)
def _paused(session: CheckSession) -> Found:
    goal = session.joints()
    goal[5] -= _TURN
    id_ = session.move(goal, v=_SLOW)
    session.begun(id_)
    session.call("pause", True, timeout=MOTION)
    moving, paused = session.moving(), session.task(id_)
    session.call("resume", True, timeout=MOTION)
    ended = session.let_go(id_, session.end_of(id_))  # it may be told as paused for a moment
    there = abs(session.joints()[5] - goal[5]) < _AT
    same = (moving, paused, ended, there) == (False, TaskState.PAUSED, TaskState.FINISHED, True)
    return same, (
        f"paused: task {int(paused)}, {'moves' if moving else 'stands'}; resumed: {int(ended)}, "
        f"{'at' if there else 'not at'} its target"
    )


@check(MOVING, "Tasks", "a motion that blends into the next", "5 and 4")
def _blended(session: CheckSession) -> Found:
    """Blend two motions of the first joint, there and back: the last one does not move the tool."""
    start = session.joints()
    middle = [start[0] + _LEG, *start[1:]]
    first = session.move(middle, v=_SLOW, r=0.01)
    second = session.move(start)
    in_time = abs(session.joints()[0] - start[0]) < _LEG / 2
    states = session.own_end_of(first), session.own_end_of(second)
    if not in_time:
        raise NotTried("the second motion came late, since this computer was busy")
    there = abs(session.joints()[0] - start[0]) < _AT
    same = states == (TaskState.INTERRUPT, TaskState.FINISHED) and there
    return same, f"{int(states[0])} and {int(states[1])}"


@check(
    MOVING,
    "Tasks",
    "motions that make no sense",
    "five joints 7, a speed of 0 or below 8; nothing moves",
)
def _refused(session: CheckSession) -> Found:
    """Send calls that must not move the arm, whatever the controller answers."""
    here = session.joints()
    calls: dict[str, tuple[list[float], float]] = {
        "five joints": (here[:5], _SLOW),
        "a speed of 0": (here, 0.0),
        "a speed below 0": (here, -_SLOW),
        "a joint beyond its limit": ([*here[:5], 50.0], _SLOW),
    }
    found = []
    for name, (goal, v) in calls.items():
        answer = session.call("movej2", goal, v, 1.0, 0.0, True, Op(), False, timeout=MOTION)
        found.append(f"{name}: {answer}")
        if session.moving():
            return False, f"{name} moves the arm"
    expected = [TaskState.ILLEGAL, *[TaskState.PARAMETER_MISMATCH] * 2]
    same = [int(each.rpartition(" ")[2]) for each in found[:3]] == expected
    return same, ", ".join(found)


@check(MOVING, "Tasks", "a motion between a stop and rest", "4")
def _while_stopping(session: CheckSession) -> Found:
    """Send a motion after a stop, before the arm is at rest: it waits for that.

    On a busy computer it may come when the arm stands already, and the stop's task is not over yet:
    one refusal shows more than a motion that was carried out.
    """
    carried_out = 0
    for direction in (-1, 1) * 5:
        session.begun(session.turn(direction * _TURN, v=0.5))
        goal = session.joints()
        stop = session.call("stop", False)
        id_ = session.move(goal)
        in_time = not session.task(stop).ended
        state = session.end_of(id_)
        session.rest()
        if in_time and state is not TaskState.FINISHED:
            return False, f"{int(state)}"
        carried_out += in_time
        if carried_out == _SURE:
            break
    if carried_out:
        return True, f"{int(TaskState.FINISHED)}"
    raise NotTried("the arm stood each time before the motion came")


@check(
    MOVING, "Transport", "a connection that ends in mid motion", "the motion goes on to its target"
)
def _lost_connection(session: CheckSession) -> Found:
    """End the connection of a blocking call in mid motion, without a heartbeat."""
    goal = session.joints()
    goal[5] += _TURN
    over = threading.Event()
    thread = threading.Thread(
        target=_call_and_disconnect, args=(session, goal, over), name="aioduco check", daemon=True
    )
    thread.start()
    try:
        session.begun()
    finally:  # also if the check is told to end: the stop after it comes behind the motion
        over.set()
        thread.join(MOTION)
    session.until(lambda: not session.moving())
    there = abs(session.joints()[5] - goal[5]) < _AT
    return there, "the motion goes on to its target" if there else "the arm stops"


def _call_and_disconnect(session: CheckSession, goal: list[float], over: threading.Event) -> None:
    """Call a blocking motion, and end its connection when `over` is set."""
    with contextlib.suppress(DucoError), session.another() as connection:

        def end() -> None:
            over.wait()
            connection.abandon("the check ends it")

        threading.Thread(target=end, name="aioduco check, end", daemon=True).start()
        connection.call("movej2", (goal, _SLOW, 1.0, 0.0, True, Op(), False), MOTION)


@check(MOVING, "Velocities, jogs, hand guiding", "speedj for a second", "4, turned by as much")
def _velocity(session: CheckSession) -> Found:
    before = session.joints()[5]
    answer = session.call("speedj", [0.0] * 5 + [_SLOW], 1.0, 1000, True, timeout=MOTION)
    if not session.until(lambda: not session.moving(), 10.0):
        return False, "it does not end"
    turned = session.joints()[5] - before
    if turned < 0.5 * _SLOW:
        session.let_go(None, answer)
    return answer == TaskState.FINISHED and 0.5 * _SLOW < turned < 1.5 * _SLOW, (
        f"{answer}, turned by {turned:.3f} rad"
    )


@check(
    MOVING,
    "Heartbeat",
    "a heartbeat that ends in mid motion",
    "the arm stands, and there is no safety stop",
)
def _heartbeat(session: CheckSession) -> Found:
    """Send one heartbeat and none after it, in mid motion; then read the robot's state."""
    id_ = session.turn(-_TURN, v=_SLOW)
    session.begun(id_)
    session.call("rpc_heartbeat", 300)
    begin = time.monotonic()
    stands = session.until(lambda: not session.moving(), 5.0)
    took, state = time.monotonic() - begin, session.end_of(id_)
    robot, _, safety, _ = session.call("get_robot_state")
    if not stands:
        return False, "the arm moves on"
    same = state is not TaskState.FINISHED and safety == SafetyState.RUN
    return same, (
        f"the arm stands after {took:.2f} s, the motion {int(state)}, robot {robot}, "
        f"safety {safety}"
    )
