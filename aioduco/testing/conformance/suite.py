"""All checks of a controller, one after the other."""

from __future__ import annotations

import contextlib
import time
from typing import TYPE_CHECKING

from aioduco.errors import (
    ConnectError,
    DucoError,
    HeartbeatLost,
    StopUnconfirmed,
    TaskStopped,
)
from aioduco.models.host_port import host_port
from aioduco.testing.conformance.check_session import CheckSession, Differs, NotTried
from aioduco.testing.conformance.controller_report import CheckResult, ControllerReport, Verdict

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco.testing.conformance.reading import Looked


def check_controller(
    host: str,
    port: int = 7003,
    *,
    move: bool = False,
    progress: Callable[[CheckResult], object] | None = None,
) -> ControllerReport:
    """Compare what a controller does with what the simulated one does.

    First come checks that only read. With `move`, others follow that turn the last joint by up to
    0.3 rad (17°) and the first one by 0.1 rad (6°), slowly, there and back: the arm must be
    enabled, and nobody within its reach. After each of them the arm is stopped. One of them sends a
    single heartbeat and no further one.

    Each check is compared with one behaviour of the simulator, and names its heading in the ledger.
    No other program should use the controller meanwhile.

    Args:
        host: address of the controller.
        port: its TCP port.
        move: whether the arm may be moved.
        progress: called with each result as soon as there is one.

    Returns:
        The report. A difference is not an error of the controller: the simulator's ledger must be
        corrected.

    Raises:
        ConnectError: there is no controller, or it can no longer be reached.
        HeartbeatLost: this program stood still, as in a computer that slept; the arm was stopped.
        StopUnconfirmed: it is not known that the arm stands, after a check that moved it.
        TaskStopped: another program has stopped or paused the arm: it was not moved again.
    """
    from aioduco.testing.conformance.moving import MOVING  # noqa: PLC0415 - loads NumPy
    from aioduco.testing.conformance.reading import READING  # noqa: PLC0415

    session = CheckSession(host, port)
    results: list[CheckResult] = []
    try:
        session.open()
        for looked in READING:
            _add(results, _checked(session, looked), progress)
        if move:
            for looked in MOVING:
                _add(results, _moved(session, looked), progress)
        version = ""
        with contextlib.suppress(DucoError):
            version = str(session.call("get_robot_version"))
    finally:
        session.close()
    return ControllerReport(host_port(host, port), version, move, tuple(results))


def _add(
    results: list[CheckResult],
    result: CheckResult,
    progress: Callable[[CheckResult], object] | None,
) -> None:
    results.append(result)
    if progress is not None:
        progress(result)


def _checked(session: CheckSession, looked: Looked) -> CheckResult:
    section, name, expected, look = looked
    begin = time.monotonic()
    try:
        same, found = look(session)
        verdict = Verdict.SAME if same else Verdict.DIFFERENT
    except Differs as reason:
        verdict, found = Verdict.DIFFERENT, str(reason)
    except NotTried as reason:
        verdict, found = Verdict.OPEN, f"not tried: {reason}"
    except (ConnectError, HeartbeatLost, StopUnconfirmed, TaskStopped):  # no further check may be
        raise
    except DucoError as error:
        verdict, found = Verdict.DIFFERENT, f"{type(error).__name__}: {error}"
    took = round(time.monotonic() - begin, 3)
    return CheckResult(section, name, expected, found, verdict, took)


def _moved(session: CheckSession, looked: Looked) -> CheckResult:
    section, name, expected, look = looked

    def guarded(session: CheckSession) -> tuple[bool, str]:
        session.ready()
        try:
            return look(session)
        finally:
            # Whatever the result, the next check begins at rest.
            session.rest()

    return _checked(session, (section, name, expected, guarded))
