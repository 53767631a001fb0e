"""Motions and tasks for blocking programs."""

from __future__ import annotations

import inspect
from types import MethodType
from typing import TYPE_CHECKING, Any, Concatenate, Generic, ParamSpec, TypeVar

import anyio

from aioduco._process import trial
from aioduco._process.copying import Uncopied
from aioduco.errors import TaskError
from aioduco.models.ranges import WAIT
from aioduco.supervision.command import check_motions
from aioduco.supervision.task_command import shown
from aioduco.sync._blocking import Blocking
from aioduco.sync._generated_objects import MotionPathCalls, TaskCalls

if TYPE_CHECKING:
    from collections.abc import Callable, Coroutine, Iterable, Iterator

    from aioduco.models.enums import Outcome, TaskState
    from aioduco.supervision import command as aio_command
    from aioduco.supervision import task as aio_task
    from aioduco.supervision.task import OnCancel
    from aioduco.sync._runner import Runner


P = ParamSpec("P")
T = TypeVar("T")


class Task(TaskCalls):
    """A task that the controller accepted. `with task:` ties it to a block.

    Leaving the block waits for a motion with an end of its own, and ends a motion without one; then
    it raises the motion's error, as `wait` does, also one that the block has handled. If the block
    raises, the arm is stopped, paused or left moving, as `on_cancel` says.

    The controller stops, pauses and resumes all its tasks together, never one alone. So `cancel`,
    `pause` and `resume` act on all of them.
    """

    def __init__(self, runner: Runner, made: aio_task.Task) -> None:
        super().__init__(runner, made)
        runner.holds(made)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Task) and other._made is self._made

    def __hash__(self) -> int:
        return hash(self._made)

    def _leave(self, exc: BaseException | None) -> None:
        if exc is not None:
            if not self.done:
                super()._call(self._made._on_wait_cancelled())
        elif self._made.continuous is not None and not self.done:
            self.end()
        else:
            self.wait()

    def result(self) -> Outcome:
        """The outcome of a task that is done.

        Raises:
            TaskError: it is not done, or it neither finished nor blended: one of the subclasses.
        """
        return self._noting(self._made.result)

    def wait(self, timeout: float | None = None) -> Outcome:
        """Wait for the end of the task.

        An interrupt (Ctrl-C) stops the arm, or does what `on_cancel` says, before it is raised.

        Args:
            timeout: seconds for which to wait; 0 to only look; None for no limit.

        Returns:
            How it ended: finished or blended.

        Raises:
            ParameterError: the time is below 0.
            TaskError: it ended otherwise: one of the subclasses.
            TimeoutError: it has not ended in time; it continues.
        """
        limit = None if timeout is None else WAIT("timeout", timeout)
        # an end is known also after the robot was left, when nothing runs on its loop any more
        return self.result() if self.done else self._call(self._wait(limit))

    async def _wait(self, timeout: float | None) -> Outcome:
        if timeout is None:
            return await self._made
        try:
            with trial.at_own_pace(), anyio.move_on_after(timeout):
                await self._made.wait()
        except anyio.get_cancelled_exc_class():
            await self._made._on_wait_cancelled()
            raise
        if not self._made.done:
            raise TimeoutError(f"{self._made!r} has not ended within {timeout:g} s: it goes on")
        return self._made.result()

    def states(self) -> Iterator[TaskState]:
        """Iterate over the task's states, each of them once, until the end.

        Leaving the loop does not affect the arm. An interrupt while it waits does: see `wait`.
        """
        states = aiter(self._made)

        async def following() -> TaskState | None:
            try:
                return await anext(states, None)
            except anyio.get_cancelled_exc_class():
                await self._made._on_wait_cancelled()
                raise

        while True:
            state = self._call(following())
            if state is None:
                return
            yield state

    def progress(self) -> float | None:
        """Read the arm's position, and return the fraction of the way that is done, 0 to 1.

        Any thread may watch a motion by this: the thread that holds it stays the same.

        Returns:
            The fraction; None if it is unknown. It is known for `movej2` if the arm stood when the
            motion was accepted, and for every motion that has finished (1).

        Raises:
            ConnectionLost: the controller does not answer.
        """
        return self._runner.call(self._made.progress())

    def _call(self, work: Coroutine[Any, Any, T]) -> T:
        self._runner.holds(self._made)
        return self._noting(lambda: super(Task, self)._call(work))

    def _noting(self, function: Callable[[], T]) -> T:
        try:
            return function()
        except TaskError as exc:
            if self._runner.was_stopped_unheld(self._made):
                exc.add_note(
                    "the arm was stopped because the thread that held this motion made no call for "
                    "too long: let time pass by robot.sleep(), or see hold_limit of connect()"
                )
            raise


class MotionCommand(Blocking):
    """A motion as a value: checked, but not sent. `run` or `start` moves the arm.

    For `robot.motion.run`, and for motions that are carried out several times.
    """

    _made: aio_command.MotionCommand

    @property
    def awaitable(self) -> aio_command.MotionCommand:
        """The same motion for asyncio programs."""
        return self._made

    def __repr__(self) -> str:
        return f"<{shown(self._made.command)}: its run() or start() moves the arm>"

    def run(self) -> Outcome:
        """Send the motion and wait for its end.

        An interrupt (Ctrl-C) stops the arm before it is raised.

        Returns:
            How it ended: finished or blended.

        Raises:
            TaskError: it ended otherwise: one of the subclasses.
            Refused: the controller refused it.
            RobotStateError: the robot is not open, or its heartbeat does not beat.
            OutcomeUnknown: it was sent, but not answered; the arm was stopped.
            ConnectionLost: it was not sent.
        """
        self._made.mark_used()  # no warning of an unused motion: a failure raises an error
        return self._runner.call(self._run())

    async def _run(self) -> Outcome:
        return await self._made

    def start(self, *, deadline: float | None = None, on_cancel: OnCancel | None = None) -> Task:
        """Send the motion and return its task as soon as the controller has accepted it.

        Args:
            deadline: seconds after which the arm is stopped if the motion has not ended; None
                for no such limit.
            on_cancel: what happens to the arm if a wait for the task is interrupted: "stop",
                "pause", or "detach" (it moves on); None for what the robot was opened with.

        Raises:
            Refused: the controller refused it.
            RobotStateError: the robot is not open, or its heartbeat does not beat.
            OutcomeUnknown: it was sent, but not answered; the arm was stopped.
            ConnectionLost: it was not sent.
        """
        self._made.mark_used()
        work = self._made.start(deadline=deadline, on_cancel=on_cancel)
        with trial.started():
            return Task(self._runner, self._runner.call(work, undo=_on_wait_cancelled))


class MotionPath(MotionPathCalls):
    """A path of motions that blend, for use in `with`. `robot.motion.path` makes it.

    When the block is left, the arm has reached the end of the last motion. If the block raises, the
    arm is stopped, paused or left moving, as `on_cancel` says. Leaving a block that did not raise
    raises the error of the first motion that failed, also one that the block has handled.
    """

    def add(self, motion: MotionCommand) -> Task:
        """Send a motion behind the others, and return its task when it is accepted.

        While the controller has `ahead` motions, this first waits until one of them has ended. So
        the program is ahead of the arm: put an action for a certain place into an `op` of the
        motion, or behind the block.

        Args:
            motion: the motion, such as `robot.motion.movel.prepare(..., r=0.03)`.

        Raises:
            ParameterError: it is not a motion; nothing was sent.
            TaskError: a motion before it did not succeed; nothing was sent.
            Refused: the controller refused it.
            RobotStateError: the block was left, or the arm was stopped since; nothing was sent.
            HeartbeatLost, OutcomeUnknown, ConnectionLost: as `MotionCommand.start` says.
        """
        (command,) = awaitables([motion])
        work = self._made.add(command)
        return Task(self._runner, self._runner.call(work, undo=_on_wait_cancelled))

    def _enter(self) -> None:
        self._runner.call(self._made.__aenter__())

    def _leave(self, exc: BaseException | None) -> None:
        for task in self._made.tasks:
            self._runner.holds(task)
        self._runner.call(self._made.__aexit__(None if exc is None else type(exc), exc, None))


def awaitables(motions: Iterable[Any]) -> list[aio_command.MotionCommand]:
    """Return the same motions for asyncio programs.

    Raises:
        MotionCarriedOut: an element is the outcome of a motion.
        ParameterError: an element is something else than a motion.
    """
    given = list(motions)
    check_motions(
        given, MotionCommand, "Make motions that are to be run by .prepare: movel.prepare(…)"
    )
    return [each.awaitable for each in given]


def _on_wait_cancelled(task: aio_task.Task) -> Coroutine[Any, Any, None]:
    return task._on_wait_cancelled()


class MotionFunction(Uncopied, Generic[P]):
    """A motion of a section: call it to carry it out.

        robot.motion.movej2(home, v=1.0, a=1.0)                    # returns when it has ended
        task = robot.motion.movej2.start(home, v=1.0, a=1.0)       # returns when it is accepted
        leg = robot.motion.movej2.prepare(home, v=1.0, a=1.0)      # nothing is sent

    All three take the same arguments.
    """

    def __init__(
        self, runner: Runner | None, make: Callable[..., aio_command.MotionCommand], doc: str | None
    ) -> None:
        self._runner = runner  # None where it was read from the class, as help() does
        self._make = make
        self.__doc__ = doc
        self.__name__: str = make.__name__
        self.__qualname__: str = make.__qualname__
        self.__module__ = make.__module__

    def __repr__(self) -> str:
        return f"<motion {self.__name__}>"

    @property
    def __signature__(self) -> inspect.Signature:
        return inspect.signature(self._make).replace(return_annotation="Outcome")

    def __get__(self, instance: object, owner: type | None = None) -> MotionFunction[P]:
        # With this method, help() and editors treat the object as a function. It is bound already.
        return self

    def __call__(self, *args: P.args, **kwargs: P.kwargs) -> Outcome:
        """Carry the motion out, and return when it has ended: see `MotionCommand.run`."""
        return self.prepare(*args, **kwargs).run()

    def start(self, *args: P.args, **kwargs: P.kwargs) -> Task:
        """Start the motion, and return when it is accepted: see `MotionCommand.start`."""
        return self.prepare(*args, **kwargs).start()

    def prepare(self, *args: P.args, **kwargs: P.kwargs) -> MotionCommand:
        """Check the arguments, and return the motion as a value; nothing is sent."""
        if self._runner is None:
            raise TypeError(f"{self.__name__} is a motion of a robot: robot.motion.{self.__name__}")
        return MotionCommand(self._runner, self._make(*args, **kwargs))


class moves(Generic[P]):  # noqa: N801  # a decorator
    """Turns a method that returns an asyncio motion into a function that carries it out."""

    def __init__(self, method: Callable[Concatenate[Any, P], aio_command.MotionCommand]) -> None:
        self._method = method
        self.__doc__ = method.__doc__

    def __get__(self, section: Any, owner: type | None = None) -> MotionFunction[P]:
        if section is None:
            # read from the class, as help() does: there is no robot to run it, and no section
            return MotionFunction(None, self._method, self.__doc__)
        make: Callable[P, aio_command.MotionCommand] = MethodType(self._method, section)
        return MotionFunction(section._runner, make, self.__doc__)
