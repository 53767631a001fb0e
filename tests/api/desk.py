"""A controller for tests of the sections: the bench, with all motions, and those that go on."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from client.bench import Bench, BenchTask

from aioduco import TaskState
from aioduco._wire import idl
from aioduco.testing import eventually

#: where the time in ms stands among the arguments of what goes on; None if it has none
HELD: dict[str, int | None] = {
    "speedj": 2,
    "speedl": 2,
    "move_jog": None,
    "move_jog_eaxis": None,
    "teach_mode": None,
}
ENDINGS = {"speed_stop", "stop_manual_move", "end_teach_mode"}
FOREVER = 1e9


class Desk(Bench):
    """A controller with tasks, some of which go on.

    Attributes:
        early: whether the task of a motion that goes on is finished as soon as it has begun.
        deaf: whether the functions that end what goes on are without effect.
        forgets_time: whether motions at a velocity go on after their time.
    """

    def __init__(self) -> None:
        super().__init__()
        self.early = False
        self.forgets_time = False
        self.deaf = False
        self._going: BenchTask | None = None
        for name, index in HELD.items():
            self.answer(name, self._goes_on(name, index))
        self.begins("simulation")
        self.answer("get_robot_version", "V3.8.0")
        for name in ENDINGS:
            self.answer(name, self._ending(name))

    @contextmanager
    def otherwise(self) -> Iterator[None]:
        """A block whose answers hold in it alone."""
        before = dict(self._answers)
        yield
        self._answers.update(before)

    def moves(self, name: str) -> None:
        """Make a function start a motion that ends by itself."""

        def start(*args: Any) -> int:
            with self._lock:
                now = time.monotonic()
                return self._add(BenchTask(name, now, now + self.motion_time))

        self.answer(name, start)

    def blocks(self, name: str) -> None:
        """Make a function that starts a motion answer at its end, unless `block` is false."""
        start = self._answers[name]
        parameters = idl.functions()[name].parameters

        def called(*args: Any) -> int:
            task_id: int = start(*args)
            if dict(zip(parameters, args, strict=True)).get("block", True):
                eventually(lambda: TaskState(self.task_state(task_id)).ended, 60.0)
                return self.task_state(task_id)
            return task_id

        self.answer(name, called)

    def fails(self, name: str, answer: Any, reason: str) -> None:
        """Make a function answer so, after it has added the reason to the list of errors."""

        def call(*_: Any) -> Any:
            self.errors = [*self.errors, reason]
            return answer

        self.answer(name, call)

    def begins(
        self, name: str, lasting: float = 0.02, end: TaskState | None = None, error: str = ""
    ) -> None:
        """Make a function start a task that moves nothing.

        Args:
            name: the function.
            lasting: how long the task takes [s].
            end: a state in which it is at once.
            error: what is then added to the controller's list.
        """

        def start(*args: Any) -> int:
            with self._lock:
                now = time.monotonic()
                task = BenchTask(name, now, now + lasting, motion=False)
                task.state = end or task.state
                self.errors = [*self.errors, error] if error else self.errors
                return self._add(task)

        self.answer(name, start)

    def moving(self) -> bool:
        """Whether the arm moves."""
        with self._lock:
            now = time.monotonic()
            if self._going is not None and now < self._going.end:
                return self._going.name != "teach_mode"  # nobody pushes it
        return super().moving()

    @property
    def going_on(self) -> bool:
        """Whether something goes on."""
        with self._lock:
            return self._going is not None and time.monotonic() < self._going.end

    def _goes_on(self, name: str, index: int | None) -> Callable[..., int]:
        def start(*args: Any) -> int:
            with self._lock:
                now = time.monotonic()
                ms = -1 if index is None else args[index]
                end = FOREVER if ms < 0 or self.forgets_time else now + ms / 1000
                self._over(now)
                self._going = BenchTask(name, now, end)
                task = BenchTask(name, now, now if self.early else end)
                return self._add(task)

        return start

    def halted(self) -> None:
        """What goes on is over, and nobody told it to end."""
        with self._lock:
            now = time.monotonic()
            self._over(now)

    def _over(self, now: float) -> None:
        """What goes on is over."""
        going, self._going = self._going, None
        if going is None or now >= going.end:
            return
        for task in self.tasks.values():
            if task.name == going.name and not task.state.ended:
                task.end = now

    def _ending(self, name: str) -> Callable[[bool], int]:
        def end(block: bool) -> int:
            with self._lock:
                now = time.monotonic()
                if not self.deaf:
                    self._over(now)
                return self._add(BenchTask(name, now, now, motion=False))

        return end

    def _stop(self, block: bool) -> int:
        with self._lock:
            task_id = super()._stop(block)
            # Hand guiding is a mode of its own: this one outlives a stop.
            if self._going is not None and self._going.name != "teach_mode":
                self._going = None
            return task_id
