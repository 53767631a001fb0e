"""The suite passes on the simulator, and finds each deviation of another controller."""

from __future__ import annotations

import contextlib
import json
import signal
import socket
import threading
import time
from collections.abc import Iterator
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import pytest
from cli_runner import CliRunner
from client.bench import Bench
from test_cli import process

import aioduco.sync
from aioduco._wire.connection import Connection
from aioduco.cli.app import app
from aioduco.errors import (
    ConnectError,
    ConnectTimeout,
    HeartbeatLost,
    NotAController,
    StopUnconfirmed,
    TaskStopped,
)
from aioduco.models.enums import TaskState
from aioduco.sim import Simulator
from aioduco.sim.controller.tasks import TaskTable
from aioduco.testing import DropReply, FaultProxy, check_controller
from aioduco.testing.conformance import (
    CheckResult,
    ControllerReport,
    Verdict,
    check_session,
    moving,
)
from aioduco.testing.conformance.check_session import CheckSession
from aioduco.testing.conformance.moving import MOVING
from aioduco.testing.conformance.reading import READING


@pytest.fixture
def sim() -> Iterator[Simulator]:
    with Simulator() as sim:
        yield sim


def bring_up(sim: Simulator) -> None:
    with aioduco.sync.connect(sim.host, sim.port, heartbeat=None) as robot:
        robot.bring_up()


def verdicts(report: ControllerReport) -> dict[str, Verdict]:
    return {each.name: each.verdict for each in report.results}


def test_nothing_is_moved_unless_asked_and_nothing_differs_at_the_simulator(sim: Simulator) -> None:
    before = sim.joints.array.copy()
    seen: list[CheckResult] = []
    report = check_controller(sim.host, sim.port, progress=seen.append)
    assert report.ok, str(report)
    assert [each.verdict for each in report.results] == [Verdict.SAME] * len(READING)
    assert tuple(seen) == report.results
    assert (sim.joints.array == before).all()
    assert not sim.tasks


@pytest.mark.slow
def test_what_moves_the_arm_differs_in_nothing_either(sim: Simulator) -> None:
    bring_up(sim)
    report = check_controller(sim.host, sim.port, move=True)
    assert report.ok, str(report)
    assert len(report.results) > len(READING) + 10
    # On a busy machine an arm may stand before the next command comes.
    left = {name for name, verdict in verdicts(report).items() if verdict is Verdict.OPEN}
    assert left <= {"a motion between a stop and rest", "a motion that blends into the next"}
    assert not sim.view.moving


def test_an_arm_that_is_not_ready_is_not_moved(sim: Simulator) -> None:
    report = check_controller(sim.host, sim.port, move=True)
    moving = report.results[len(READING) :]
    assert {each.verdict for each in moving} == {Verdict.OPEN}
    assert "not enabled" in moving[0].found
    assert not sim.tasks


def test_another_controllers_ways_are_differences(
    sim: Simulator, monkeypatch: pytest.MonkeyPatch
) -> None:
    state = TaskTable.state
    monkeypatch.setattr(TaskTable, "state", lambda self, id_: state(self, id_) or 4)
    report = check_controller(sim.host, sim.port)
    (found,) = report.differences
    assert (found.section, found.name) == ("Tasks", "state of an id that was never given out")
    assert found.found == "4"
    assert not report.ok
    assert "| Tasks | state of an id that was never given out | 0 | 4 |" in report.markdown()


def test_functions_that_are_missing_are_named() -> None:
    with Bench() as bench:
        report = check_controller(bench.host, bench.port)
    (found,) = [each for each in report.results if each.name.startswith("functions that read")]
    assert found.verdict is Verdict.DIFFERENT
    assert "get_robot_version" in found.found


def test_no_controller() -> None:
    with pytest.raises(ConnectError):
        check_controller("127.0.0.1", 1)


@contextlib.contextmanager
def listener(answer: bytes) -> Iterator[tuple[str, int]]:
    """The address of a program that is no controller: it sends this text to all that comes."""
    with socket.create_server(("127.0.0.1", 0)) as server:

        def serve() -> None:
            with contextlib.suppress(OSError):
                while True:
                    connection, _ = server.accept()
                    threading.Thread(target=answer_all, args=(connection,), daemon=True).start()

        def answer_all(connection: socket.socket) -> None:
            with connection, contextlib.suppress(OSError):
                while connection.recv(4096):
                    connection.sendall(answer)

        threading.Thread(target=serve, daemon=True).start()
        yield server.getsockname()
        server.shutdown(socket.SHUT_RDWR)


def test_what_is_no_controller() -> None:
    with listener(b"SSH-2.0-OpenSSH_9.2\r\n") as address, pytest.raises(NotAController):
        check_controller(*address)


def test_what_never_answers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(check_session, "CALL", 0.1)
    with listener(b"") as address, pytest.raises(ConnectTimeout):
        check_controller(*address)


def test_a_controller_that_freezes_ends_the_check_at_once(
    sim: Simulator, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: list[CheckResult] = []
    with FaultProxy(sim.host, sim.port) as proxy:

        def freeze(result: CheckResult) -> None:
            seen.append(result)
            proxy.freeze()
            monkeypatch.setattr(CheckSession.call, "__kwdefaults__", {"timeout": 0.1})
            monkeypatch.setattr(check_session, "CALL", 0.1)

        with pytest.raises(ConnectTimeout, match=r"answers nothing any more .*the check ends"):
            check_controller(proxy.host, proxy.port, progress=freeze)
    assert len(seen) == 1
    assert len(proxy.connections()) == 2  # that of the check, and one to see whether it answers


@pytest.mark.slow
def test_a_function_that_is_not_answered_ends_no_check_while_others_are(sim: Simulator) -> None:
    with FaultProxy(sim.host, sim.port) as proxy:
        proxy.on("get_robot_type", DropReply())
        report = check_controller(proxy.host, proxy.port)
    assert len(report.results) == len(READING)
    assert verdicts(report)["functions that read and take nothing"] is Verdict.DIFFERENT


@pytest.fixture
def lost_connection(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of what moves the arm, only the check that ends a connection in mid motion."""
    (looked,) = (each for each in MOVING if each[1] == "a connection that ends in mid motion")
    monkeypatch.setattr("aioduco.testing.conformance.moving.MOVING", (looked,))


@pytest.mark.slow
@pytest.mark.usefixtures("lost_connection")
def test_an_arm_that_cannot_be_stopped_is_said_and_not_moved_again(
    sim: Simulator, monkeypatch: pytest.MonkeyPatch
) -> None:
    bring_up(sim)
    monkeypatch.setattr("aioduco.testing.conformance.check_session._REST_LIMIT", 0.2)
    with FaultProxy(sim.host, sim.port) as proxy:

        def cut() -> None:
            sim.wait_until(lambda: sim.moving, timeout=60)
            proxy.refuse()
            proxy.cut()

        cutting = threading.Thread(target=cut)
        cutting.start()
        with pytest.raises(StopUnconfirmed, match="emergency stop"):
            check_controller(proxy.host, proxy.port, move=True)
        cutting.join()


def test_a_stop_by_another_program_ends_the_check(
    sim: Simulator, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The next check moved the arm again."""
    bring_up(sim)
    task, done = CheckSession.task, False

    def task_of(session: CheckSession, id_: int) -> TaskState:
        nonlocal done
        if not done:
            done = True
            session.begun(id_)
            with session.another() as connection:
                connection.call("stop", (True,), 30.0)
        return task(session, id_)

    monkeypatch.setattr(CheckSession, "task", task_of)
    monkeypatch.setattr(moving, "_TURN", 6.0)  # a motion that does not end before
    seen: list[CheckResult] = []
    with pytest.raises(TaskStopped, match="another program"):
        check_controller(sim.host, sim.port, move=True, progress=seen.append)
    assert len(seen) == len(READING)
    assert not sim.view.moving


def test_a_second_interrupt_does_not_keep_the_arm_from_being_stopped(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    with Bench() as bench:
        session = CheckSession(bench.host, bench.port)
        ask = session._own.call
        interrupts = [KeyboardInterrupt(), KeyboardInterrupt()]

        def interrupted(*given: Any) -> Any:
            if interrupts:
                raise interrupts.pop()
            return ask(*given)

        monkeypatch.setattr(session._own, "call", interrupted)
        with pytest.raises(KeyboardInterrupt):
            session.rest()
        session.close()
        assert bench.received("stop")


def test_no_check_follows_when_the_program_stood_still(monkeypatch: pytest.MonkeyPatch) -> None:
    """As in a computer that slept: the arm went on to turn when it woke up."""
    slept = 0.0
    monkeypatch.setattr(check_session, "boot_time", lambda: time.monotonic() + slept)

    def sleep(_: CheckResult) -> None:
        nonlocal slept
        slept = 100.0

    with Bench() as bench:
        with pytest.raises(HeartbeatLost, match="stood still for 95 s or more"):
            check_controller(bench.host, bench.port, move=True, progress=sleep)
        assert not bench.received("movej2")


@pytest.mark.slow
@pytest.mark.usefixtures("lost_connection")
def test_a_motion_of_another_thread_comes_before_the_last_stop(
    sim: Simulator, monkeypatch: pytest.MonkeyPatch
) -> None:
    bring_up(sim)
    before = sim.joints.array.copy()
    another = CheckSession.another

    def late(session: CheckSession) -> AbstractContextManager[Connection]:
        if threading.current_thread() is not threading.main_thread():
            time.sleep(0.3)  # as by a slow network
        return another(session)

    def interrupted(*_: object) -> bool:
        raise KeyboardInterrupt

    monkeypatch.setattr(CheckSession, "another", late)
    monkeypatch.setattr(CheckSession, "begun", interrupted)
    with pytest.raises(KeyboardInterrupt):
        check_controller(sim.host, sim.port, move=True)
    for each in threading.enumerate():
        if each.name == "aioduco check":
            each.join()
    assert not sim.moving
    assert abs(sim.joints.array - before).max() < 0.1


def run(*words: Any, answer: str = "") -> tuple[int, str]:
    result = CliRunner().invoke(app, ["check", *map(str, words)], input=answer)
    return result.exit_code, result.output


@pytest.mark.slow
def test_the_command(sim: Simulator, tmp_path: Path) -> None:
    where = (sim.host, "--port", sim.port)
    status, said = run(*where, "-o", tmp_path / "report.json")
    assert status == 0, said
    assert "0 different" in said
    assert json.loads((tmp_path / "report.json").read_text("utf-8"))["moved"] is False
    assert run(*where, "-o", tmp_path / "report.md")[0] == 0
    assert "## The same" in (tmp_path / "report.md").read_text("utf-8")
    assert run(*where, "-o", tmp_path / "report.txt")[0] == 2
    status, said = run(*where, "--move", answer="n\n")
    assert status == 3
    assert "17 degrees" in said
    assert not sim.tasks
    assert run("127.0.0.1", "--port", 1)[0] == 1


@pytest.mark.slow
@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_check_that_is_told_to_end_leaves_a_standing_arm(
    sim: Simulator, number: signal.Signals, code: int
) -> None:
    bring_up(sim)
    with process("check", sim.host, "--port", str(sim.port), "--move", "--yes") as checking:
        sim.wait_until(lambda: sim.moving, timeout=60)
        checking.send_signal(number)
        said, errors = checking.communicate(timeout=100)
    assert checking.returncode == code, said + errors
    assert not sim.moving
    assert "Traceback" not in errors


@pytest.mark.slow
def test_the_command_says_by_its_status_that_something_differs() -> None:
    with Bench() as bench:
        assert run(bench.host, "--port", bench.port)[0] == 1
