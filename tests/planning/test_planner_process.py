"""The planner and its process: its problem, its scene, and what a cancellation ends."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from typing import Any

import anyio
import anyio.to_thread
import pytest

from aioduco import Joints, NoPathFound, PlanningError
from aioduco.planning import Planner, Scene, planner
from aioduco.planning.problem import PlanningProblem, WorkerScene
from aioduco.sim.scene import Box

HERE = Joints.deg(0, 0, 90, 0, -90, 0)
BOX = Box(at=(0.5, 0.0, 0.2), size=(0.1, 0.1, 0.1), name="box")
PATIENCE = 30.0  # until a test gives up [s]


class Process:
    """Stands for the process: it answers each problem by an error that names its time-out.

    It starts once `may_start` is set, and answers once `may_answer` is set.
    """

    made: list[Process]
    may_start: threading.Event
    may_answer: threading.Event

    def __init__(self, module: str, **_: Any) -> None:
        self.sent: list[Any] = []
        self.killed = False
        self.channel = self.popen = self
        self._lock = threading.Condition()
        self.pid = len(self.made)
        self.made.append(self)
        assert self.may_start.wait(PATIENCE)

    def require_own(self) -> None:
        """It is never that of a parent."""

    def send(self, value: object) -> None:
        if self.killed:
            raise BrokenPipeError
        self.sent.append(value)

    def receive(self) -> Any:
        if not self.sent:
            return None  # it has started
        with self._lock:
            assert self._lock.wait_for(lambda: self.killed or self.may_answer.is_set(), PATIENCE)
        if self.killed:
            raise EOFError
        return NoPathFound(f"answer {self.problems[-1]:g}")

    def kill(self) -> None:
        with self._lock:
            self.killed = True
            self._lock.notify_all()

    def answer(self) -> None:
        self.may_answer.set()
        with self._lock:
            self._lock.notify_all()

    def end(self) -> str:
        self.kill()
        return ""

    def close(self) -> None:
        self.kill()

    @property
    def problems(self) -> list[float]:
        return [each.timeout for each in self.sent if isinstance(each, PlanningProblem)]

    @property
    def scenes(self) -> list[int]:
        """Number of bodies in each scene that it has got."""
        return [each.model.nbody for each in self.sent if isinstance(each, WorkerScene)]


@pytest.fixture
def processes(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[Process]]:
    Process.made = []
    Process.may_start, Process.may_answer = threading.Event(), threading.Event()
    Process.may_start.set()
    monkeypatch.setattr(planner, "LinkedProcess", Process)
    yield Process.made
    Process.may_start.set()
    for process in Process.made:
        process.kill()


async def until(condition: Any) -> None:
    with anyio.fail_after(PATIENCE):
        while not condition():
            await anyio.lowlevel.checkpoint()


async def ask(planning: Planner, number: float, answers: list[str]) -> None:
    """Ask for a plan whose time-out is its number."""
    try:
        await planning.plan(HERE, HERE, timeout=number)
    except PlanningError as error:
        answers.append(str(error))


async def test_cancelling_a_plan_that_waits_leaves_the_other_one_alone(
    processes: list[Process],
) -> None:
    answers: list[str] = []
    with Planner(Scene()) as planning:
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(ask, planning, 1.0, answers)
            await until(lambda: processes and processes[0].problems)
            async with anyio.create_task_group() as waiting:
                waiting.start_soon(ask, planning, 2.0, answers)
                await anyio.wait_all_tasks_blocked()
                waiting.cancel_scope.cancel()
            assert not processes[0].killed
            processes[0].answer()
        await ask(planning, 3.0, answers)
    assert answers == ["answer 1", "answer 3"]
    # the second one has not been solved by anyone
    assert [each.problems for each in processes] == [[1.0, 3.0]]


async def test_cancelling_a_plan_in_the_works_leaves_the_next_one_alone(
    processes: list[Process],
) -> None:
    answers: list[str] = []
    with Planner(Scene()) as planning:
        async with anyio.create_task_group() as tasks:
            async with anyio.create_task_group() as first:
                first.start_soon(ask, planning, 1.0, answers)
                await until(lambda: processes and processes[0].problems)
                tasks.start_soon(ask, planning, 2.0, answers)
                await anyio.wait_all_tasks_blocked()
                first.cancel_scope.cancel()
            assert processes[0].killed
            await until(lambda: len(processes) > 1 and processes[1].problems)
            processes[1].answer()
    assert answers == ["answer 2"]
    assert [each.problems for each in processes] == [[1.0], [2.0]]


async def test_a_plan_that_is_cancelled_before_the_process_exists_is_not_solved(
    processes: list[Process],
) -> None:
    answers: list[str] = []
    Process.may_start.clear()
    Process.may_answer.set()
    with Planner(Scene()) as planning:
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(ask, planning, 1.0, answers)
            await until(lambda: processes)
            tasks.cancel_scope.cancel()
        Process.may_start.set()
        await ask(planning, 2.0, answers)
    assert answers == ["answer 2"]
    assert processes[0].killed
    assert [number for each in processes for number in each.problems] == [2.0]


def test_an_interrupted_plans_answer_is_not_taken_for_the_next_one(
    processes: list[Process], monkeypatch: pytest.MonkeyPatch
) -> None:
    Process.may_answer.set()
    receive = Process.receive

    def interrupted(self: Process) -> Any:
        if self.problems == [1.0]:
            raise KeyboardInterrupt
        return receive(self)

    monkeypatch.setattr(Process, "receive", interrupted)
    with Planner(Scene()) as planning:
        with pytest.raises(KeyboardInterrupt):
            planning.plan_blocking(HERE, HERE, timeout=1.0)
        with pytest.raises(NoPathFound, match="answer 2"):
            planning.plan_blocking(HERE, HERE, timeout=2.0)
    assert [each.problems for each in processes] == [[1.0], [2.0]]


def solve(planning: Planner) -> None:
    with pytest.raises(NoPathFound, match="answer"):
        planning.plan_blocking(HERE, HERE)


def test_another_scene_of_the_same_revision_is_sent(processes: list[Process]) -> None:
    Process.may_answer.set()
    bare, full = Scene(), Scene("gcr5_910", [BOX])
    assert bare.revision == full.revision
    with Planner(bare) as planning:
        solve(planning)
        planning.scene = full
        solve(planning)
        solve(planning)
    (process,) = processes
    assert process.scenes == [bare.compiled().nbody, full.compiled().nbody]
    assert bare.compiled().nbody < full.compiled().nbody


def test_a_change_while_the_scene_is_compiled_is_sent_with_the_next_plan(
    processes: list[Process], monkeypatch: pytest.MonkeyPatch
) -> None:
    Process.may_answer.set()
    compiled = Scene.compiled

    def changed_meanwhile(self: Scene) -> Any:
        model = compiled(self)
        if "box" not in self:
            self.add(BOX)
        return model

    monkeypatch.setattr(Scene, "compiled", changed_meanwhile)
    with Planner(Scene()) as planning:
        solve(planning)
        solve(planning)
        solve(planning)
    (process,) = processes
    assert len(process.scenes) == 2
    assert process.scenes[0] < process.scenes[1]


def test_a_process_that_never_says_that_it_has_started_is_ended(
    processes: list[Process], monkeypatch: pytest.MonkeyPatch
) -> None:
    """The plan waited for ever, however short its time-out."""

    def silent(self: Process) -> None:
        with self._lock:
            assert self._lock.wait_for(lambda: self.killed, PATIENCE)
        raise EOFError

    monkeypatch.setattr(planner, "_START", 0.0)
    with Planner(Scene()) as planning:
        with monkeypatch.context() as patch:
            patch.setattr(Process, "receive", silent)
            with pytest.raises(PlanningError, match="has not started"):
                planning.plan_blocking(HERE, HERE, timeout=1.0)
        monkeypatch.setattr(planner, "_START", PATIENCE)
        Process.may_answer.set()
        with pytest.raises(NoPathFound, match="answer 2"):
            planning.plan_blocking(HERE, HERE, timeout=2.0)
    assert len(processes) == 2


@pytest.mark.parametrize("where", ["send", "receive"])
def test_ctrl_c_leaves_no_process_that_is_at_another_problem(
    processes: list[Process], monkeypatch: pytest.MonkeyPatch, where: str
) -> None:
    """The next plan was the answer to the one before, or its request began within another."""

    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    def sent(self: Process, value: object) -> None:
        send(self, value)
        if isinstance(value, WorkerScene):
            raise KeyboardInterrupt

    send = Process.send
    with Planner(Scene()) as planning:
        with monkeypatch.context() as patch:
            if where == "send":
                patch.setattr(Process, "send", sent)
            else:  # and again, while the first one is dealt with
                patch.setattr(
                    Process, "receive", lambda self: interrupted() if self.problems else None
                )
                patch.setattr(threading.Timer, "join", interrupted)
            with pytest.raises(KeyboardInterrupt):
                planning.plan_blocking(HERE, HERE, timeout=1.0)
        Process.may_answer.set()
        with pytest.raises(NoPathFound, match="answer 2"):
            planning.plan_blocking(HERE, HERE, timeout=2.0)
    assert processes[-1].problems == [2.0]
    assert len(processes) == 2
