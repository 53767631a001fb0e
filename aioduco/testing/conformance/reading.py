"""Checks that only read: nothing moves, and nothing is changed."""

from __future__ import annotations

import contextlib
import math
import time
from typing import TYPE_CHECKING, Final

import numpy as np

from aioduco._wire.framing import Malformed
from aioduco._wire.idempotence import CallKind, call_kind
from aioduco._wire.idl import functions
from aioduco._wire.messages import Inbox, Message, MessageType
from aioduco.errors import ConnectError, ControllerError, DucoError, UnknownFunction
from aioduco.kinematics import arm, models
from aioduco.models.enums import OperationMode, ProgramState, RobotState, SafetyState, TaskState
from aioduco.models.pose import Pose
from aioduco.sim.handlers import NOT_PUBLIC
from aioduco.testing.conformance.check_session import CheckSession, NotTried

if TYPE_CHECKING:
    from collections.abc import Callable


#: whether the controller behaves like the simulated one, and what was found
Found = tuple[bool, str]
Looked = tuple[str, str, str, "Callable[[CheckSession], Found]"]
#: the checks of this module, in their order
READING: Final[list[Looked]] = []

#: number of connections that programs of this package open at once, and some more
_CONNECTIONS: Final = 12
_CALLS: Final = 200
#: tolerance of joints that are read twice from a standing arm, or computed from their pose [rad]
_STILL: Final = 1e-3
#: tolerance of a pose computed from a catalogue's lengths: each arm has its own calibration [m]
_CALIBRATION: Final = 5e-3


def check(
    checks: list[Looked], section: str, name: str, expected: str
) -> Callable[[Callable[[CheckSession], Found]], Callable[[CheckSession], Found]]:
    """Add a check to others.

    Args:
        checks: the checks.
        section: heading of the ledger.
        name: what is looked at.
        expected: what the simulated controller does.
    """

    def add(look: Callable[[CheckSession], Found]) -> Callable[[CheckSession], Found]:
        checks.append((section, name, expected, look))
        return look

    return add


@check(READING, "States", "get_robot_version", "a text")
def _version(session: CheckSession) -> Found:
    found = session.call("get_robot_version")
    return isinstance(found, str) and bool(found), repr(found)


@check(
    READING,
    "Transport",
    "functions that read and take nothing",
    "answered, but for seven of the motors that the vendor does not publish",
)
def _functions(session: CheckSession) -> Found:
    """Call each function that reads and takes no arguments."""
    wrong: list[str] = []
    silent: list[str] = []
    count = 0
    for name, function in functions().items():
        if call_kind(name) is not CallKind.READ or function.parameters:
            continue
        count += 1
        try:
            session.call(name)
        except UnknownFunction:
            wrong.append(f"{name} is unknown")
        except ControllerError as error:
            (silent if name in NOT_PUBLIC else wrong).append(str(error))
        except ConnectError:
            raise
        except DucoError as error:
            wrong.append(f"{name}: {error}")
    answered = f"{count - len(wrong) - len(silent)} of {count} are answered"
    return not wrong, "; ".join([answered, *wrong])


@check(
    READING, "Transport", "a function that does not exist", "exception, and the connection goes on"
)
def _unknown(session: CheckSession) -> Found:
    name = "no_such_function"
    answers = _exchange(session, Message(MessageType.CALL, name, 7, b"\0"))
    if not answers:
        return False, "the connection ends"
    known = answers[0].kind is MessageType.EXCEPTION
    goes_on = len(answers) == 2
    return known and goes_on, (
        f"{answers[0].kind.name.lower()}, and the connection {'goes on' if goes_on else 'ends'}"
    )


def _exchange(session: CheckSession, message: Message) -> list[Message]:
    """Send a message and then a call; return the answers to both, as many as come."""
    import socket  # noqa: PLC0415 - for this check alone

    inbox = Inbox()
    found: list[Message] = []
    behind = Message(MessageType.CALL, "robotmoving", 8, b"\0")
    with (
        socket.create_connection(session.address, timeout=5.0) as sock,
        contextlib.suppress(OSError, Malformed),
    ):
        for each in (message, behind):
            sock.sendall(each.encode())
            while (answer := inbox.take()) is None:
                data = sock.recv(4096)
                if not data:
                    return found
                inbox.feed(data)
            found.append(answer)
        return found
    session.require_answers(f"{message.name} was not answered")
    return found


@check(READING, "Transport", "an answer's name and number", "those of its call")
def _numbers(session: CheckSession) -> Found:
    answers = _exchange(session, Message(MessageType.CALL, "robotmoving", 41, b"\0"))
    if not answers:
        return False, "no answer"
    first = answers[0]
    return (first.name, first.seqid) == ("robotmoving", 41), f"{first.name}, {first.seqid}"


@check(READING, "Transport", f"{_CONNECTIONS} connections at once", "all are served")
def _connections(session: CheckSession) -> Found:
    with contextlib.ExitStack() as stack:
        for number in range(_CONNECTIONS):
            try:
                connection = stack.enter_context(session.another())
                connection.call("robotmoving", (), 5.0)
            except DucoError as error:
                session.require_answers(f"{number} connections are open")
                return False, f"the one after {number} is not served: {error}"
    return True, f"{_CONNECTIONS} are served at once"


@check(READING, "States", "get_robot_state", "four states that are known")
def _states(session: CheckSession) -> Found:
    found = session.call("get_robot_state")
    kinds = (RobotState, ProgramState, SafetyState, OperationMode)
    if len(found) != len(kinds):
        return False, f"{found}"
    unknown = [
        f"{kind.__name__} {value}"
        for kind, value in zip(kinds, found, strict=True)
        if value not in {int(each) for each in kind}
    ]
    return not unknown, f"{found}" + (f": unknown {', '.join(unknown)}" if unknown else "")


@check(READING, "States", "joints in getRobotStatus", "at least six, finite")
def _status(session: CheckSession) -> Found:
    status = session.call("getRobotStatus")
    joints = ("jointActualPosition", "jointExpectPosition", "jointActualVelocity", "slaveReady")
    wrong = [name for name in joints if len(getattr(status, name)) < 6]
    wrong += [
        name
        for name in joints[:3]
        if not all(math.isfinite(each) for each in getattr(status, name))
    ]
    lengths = ", ".join(f"{len(getattr(status, name))} {name}" for name in joints)
    return not wrong, lengths


@check(READING, "States", "the two ways to read the joints of a standing arm", "the same")
def _agree(session: CheckSession) -> Found:
    if session.moving():
        raise NotTried("the arm moves")
    status = session.call("getRobotStatus")
    apart = np.abs(np.array(status.jointActualPosition[:6]) - np.array(session.joints())).max()
    return bool(apart < _STILL), f"{apart:.2g} rad apart"


@check(READING, "What is read", "cal_fkine", "that of a known model within 5 mm")
def _forward(session: CheckSession) -> Found:
    """Compare its forward kinematics, without tool and work object, with those of the models."""
    joints = [0.3, -0.4, 1.4, 0.2, -1.2, 0.5]
    none = [0.0] * 6
    pose = Pose.of(session.call("cal_fkine", joints, none, none))
    apart = {
        name: float(np.linalg.norm(arm(name).fkine(joints)[:3, 3] - np.array(pose[:3])))
        for name in models()
    }
    name = min(apart, key=lambda each: apart[each])
    return apart[name] < _CALIBRATION, f"{1e3 * apart[name]:.2g} mm from that of the {name}"


@check(READING, "What is read", "cal_ikine of a pose, near its joints", "those joints")
def _inverse(session: CheckSession) -> Found:
    joints, none = [0.3, -0.4, 1.4, 0.2, -1.2, 0.5], [0.0] * 6
    pose = session.call("cal_fkine", joints, none, none)
    back = session.call("cal_ikine", pose, joints, none, none)
    apart = max(abs(a - b) for a, b in zip(joints, back, strict=True)) if len(back) == 6 else None
    return apart is not None and apart < _STILL, (
        f"{back}" if apart is None else f"{apart:.2g} rad from the joints it came of"
    )


@check(READING, "Tasks", "state of an id that was never given out", "0")
def _unknown_task(session: CheckSession) -> Found:
    state = session.call("get_noneblock_taskstate", 2**31 - 7)
    return state == TaskState.IDLE, f"{state}"


@check(READING, "Transport", f"{_CALLS} calls, one after another", "below 100 ms at p90")
def _round_trip(session: CheckSession) -> Found:
    times = []
    for _ in range(_CALLS):
        begin = time.perf_counter()
        session.call("get_noneblock_taskstate", 1)
        times.append(time.perf_counter() - begin)
    times.sort()
    p50, p90, p99 = (times[int(share * len(times))] for share in (0.5, 0.9, 0.99))
    # by p90: two calls of 200 are delayed by whatever else this computer does
    found = f"{1e3 * p50:.2g} ms at p50, {1e3 * p90:.2g} at p90, {1e3 * p99:.2g} at p99"
    return p90 < 0.1, found


@check(READING, "What is read", "cal_ikine beyond the reach", "the joints given as near")
def _reach(session: CheckSession) -> Found:
    near, none = [0.3, -0.4, 1.4, 0.2, -1.2, 0.5], [0.0] * 6
    back = session.call("cal_ikine", [9.0, 0.0, 0.0, 0.0, 0.0, 0.0], near, none, none)
    return back == near, f"{back}"
