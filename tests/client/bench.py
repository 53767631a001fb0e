"""A controller for tests of the client: tasks with durations, but no arm and no physics.

Motions queue up, blend if they have a radius and a successor, stop, pause and resume, all on the
real clock. What it does not know it refuses. Anything can be overridden by `answer`.
"""

from __future__ import annotations

import itertools
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from aioduco import Robot, Task
from aioduco._wire import rpc
from aioduco.models.enums import ProgramState, TaskState
from aioduco.testing import RecordingServer

#: index of the blend radius among the arguments of each motion
RADIUS = {"movej2": 3, "movel": 3, "movej_pose2": 3, "movec": 4, "tcp_move": 3}
HOME = [0.0, 0.0, 1.5, 0.0, -1.5, 0.0]
POSE = [0.5, 0.1, 0.6, 3.1, 0.0, -1.5]
#: where the flange of a GCR5-910 is at HOME
FLANGE = [0.4982, 0.1479, 0.4773, -3.0706, 0.0706, -1.5658]
ENABLED = [6, 0, 5, 1]


@dataclass
class BenchTask:
    """A task: when it begins and ends, if nothing comes between."""

    name: str
    begin: float
    end: float
    blends: bool = False
    successor: bool = False
    motion: bool = True
    state: TaskState = TaskState.IDLE
    ended_at: float | None = None
    history: list[TaskState] = field(default_factory=list)


class Bench(RecordingServer):
    """A controller with tasks.

    Attributes:
        motion_time: how long a motion lasts [s].
        braking_time: how long the arm moves on after a stop [s].
        states: what get_robot_state returns.
        tasks: all tasks by id.
        ends: what a motion ends as: change it for motions that fail.
    """

    def __init__(self) -> None:
        self.motion_time = 0.2
        self.braking_time = 0.02
        self.states = list(ENABLED)
        self.emergency_stop = False
        self.collision = False
        self.errors: list[str] = []
        self.ends = TaskState.FINISHED
        self.tasks: dict[int, BenchTask] = {}
        self._ids = itertools.count(1000)
        self._lock = threading.RLock()
        self._stopped_at = -1.0
        self._paused_at: float | None = None
        self._gates: list[threading.Event] = []
        answers: dict[str, Any] = {
            "get_robot_state": lambda: list(self.states),
            "getRobotStatus": self._status,
            "getRobotIOStatus": rpc.IOStatus(digitalInputs=[True] * 16),
            "get_actual_joints_position": HOME,
            "get_tcp_pose": POSE,
            "get_flange_pose": FLANGE,
            "get_last_error": lambda: list(self.errors),
            "rpc_heartbeat": lambda milliseconds: None,
            "robotmoving": self.moving,
            "get_noneblock_taskstate": self.task_state,
            "stop": self._stop,
            "abort": self._stop,
            "pause": self._pause,
            "resume": self._resume,
            "collision_detection_reset": self._reset_collision,
            "power_on": lambda block: self._switch("power_on", 5),
            "power_off": lambda block: self._switch("power_off", 4),
            "enable": lambda block: self._switch("enable", 6),
            "disable": lambda block: self._switch("disable", 5),
            "set_standard_digital_out": 4,
            "get_standard_digital_out": True,
        }
        for name in RADIUS:
            answers[name] = self._motion(name)
        super().__init__(answers)

    def __exit__(self, *exc: Any) -> None:
        for gate in self._gates:
            gate.set()
        super().__exit__(*exc)

    # -- for tests -----------------------------------------------------------------------------

    def hold(self, function: str, answer: Any = 4) -> threading.Event:
        """Let calls of a function hang until the event that is returned is set."""
        gate = threading.Event()
        self._gates.append(gate)

        def held(*args: Any) -> Any:
            gate.wait(30.0)
            return answer(*args) if callable(answer) else answer

        self.answer(function, held)
        return gate

    def arrive(self) -> None:
        """Have the motion that runs end now, in a test that does not want to be in time for it.

        Those behind it begin at once.
        """
        with self._lock:
            now, sooner = time.monotonic(), 0.0
            for task in self.tasks.values():
                if self._advance(task, now) is TaskState.RUNNING:
                    sooner, task.end = task.end - now, now
                elif not task.state.ended:
                    task.begin, task.end = task.begin - sooner, task.end - sooner

    def lead(self, function: str, count: int) -> list[int]:
        """Let a motion end when the next one is there, or it is the last, however long that takes.

        The program has asked for its state ten times then: it would have sent more by then.

        Args:
            function: the function by which the program sends its motions.
            count: number of them.

        Returns:
            How many motions had not ended when each was accepted.
        """
        self.motion_time = 100.0
        found: list[int] = []
        start, polls = self._answers[function], 0

        def live() -> int:
            return sum(not task.state.ended for task in self.tasks.values())

        def started(*args: Any) -> int:
            answer: int = start(*args)
            found.append(live())
            return answer

        def polled(task: int) -> int:
            nonlocal polls
            with self._lock:
                polls += 1
                if polls >= 10 and (live() > 1 or len(self.tasks) == count):
                    polls = 0
                    self.arrive()
                return self.task_state(task)

        self.answer(function, started)
        self.answer("get_noneblock_taskstate", polled)
        return found

    def moving(self) -> bool:
        """Whether the arm moves."""
        with self._lock:
            now = time.monotonic()
            if now < self._stopped_at + self.braking_time:
                return True
            return any(
                task.motion and self._advance(task, now) is TaskState.RUNNING
                for task in self.tasks.values()
            )

    def task_state(self, task_id: int) -> int:
        """State of a task."""
        with self._lock:
            task = self.tasks.get(task_id)
            return int(TaskState.IDLE if task is None else self._advance(task, time.monotonic()))

    @property
    def stops(self) -> int:
        """How often the arm was stopped."""
        return len(self.received("stop"))

    @property
    def commands(self) -> list[str]:
        """The functions that were called, without reads, supervision and heartbeat.

        Stops in a row count as one: a stop whose answer a busy machine delays is sent again.
        """
        quiet = ("get", "robotmoving", "rpc_heartbeat")
        called = [c.method for c in self.received() if not c.method.startswith(quiet)]
        return [
            name
            for name, before in zip(called, [None, *called], strict=False)
            if (name, before) != ("stop", "stop")
        ]

    # -- the controller ------------------------------------------------------------------------

    def _motion(self, name: str) -> Callable[..., int]:
        def start(*args: Any) -> int:
            with self._lock:
                now = time.monotonic()
                begin = now
                for task in self.tasks.values():
                    if task.motion and not self._advance(task, now).ended:
                        task.successor = True
                        begin = max(begin, task.end)
                return self._add(
                    BenchTask(
                        name, begin, begin + self.motion_time, blends=args[RADIUS[name]] > 0.0
                    )
                )

        return start

    def _add(self, task: BenchTask) -> int:
        task_id = next(self._ids)
        self.tasks[task_id] = task
        return task_id

    def _advance(self, task: BenchTask, now: float) -> TaskState:
        """The state of a task at a time."""
        if task.state.ended:
            return task.state
        if self._paused_at is not None and task.motion and task.begin <= self._paused_at:
            return TaskState.PAUSED
        if now >= task.end:
            if task.blends and task.successor and self.ends is TaskState.FINISHED:
                task.state = TaskState.INTERRUPT
            else:
                task.state = self.ends if task.motion else TaskState.FINISHED
            task.ended_at = task.end
        elif now >= task.begin:
            task.state = TaskState.RUNNING
        return task.state

    def _stop(self, block: bool) -> int:
        with self._lock:
            now = time.monotonic()
            running = False
            for task in self.tasks.values():
                if not self._advance(task, now).ended:
                    running = running or task.motion
                    task.state, task.ended_at = TaskState.STOPPED, now
            if running:
                self._stopped_at = now
            self._paused_at = None
            self.states[1] = 0
            return self._add(BenchTask("stop", now, now, motion=False))

    def _pause(self, block: bool) -> int:
        with self._lock:
            now = time.monotonic()
            states = [self._advance(task, now) for task in self.tasks.values() if task.motion]
            if not all(state.ended for state in states):
                self.states[1] = ProgramState.PAUSED
            self._paused_at = now
            return self._add(BenchTask("pause", now, now, motion=False))

    def _resume(self, block: bool) -> int:
        with self._lock:
            now = time.monotonic()
            if self._paused_at is not None:
                for task in self.tasks.values():
                    if not task.state.ended:
                        task.begin += now - self._paused_at
                        task.end += now - self._paused_at
                self._paused_at = None
            self.states[1] = ProgramState.STOPPED
            return self._add(BenchTask("resume", now, now, motion=False))

    def _switch(self, name: str, robot: int) -> int:
        with self._lock:
            now = time.monotonic()
            self.states[0] = robot
            if name == "power_on":
                self.states[2] = 5
            return self._add(BenchTask(name, now, now, motion=False))

    def _reset_collision(self) -> int:
        self.collision = False
        return 4

    def _status(self) -> rpc.RobotStatus:
        return rpc.RobotStatus(
            jointActualPosition=HOME,
            jointExpectPosition=HOME,
            cartActualPosition=POSE,
            cartExpectPosition=POSE,
            jointActualVelocity=[0.0] * 6,
            cartActualVelocity=[0.0] * 6,
            collision=self.collision,
            emcStopSignal=self.emergency_stop,
            robotState=self.states[0],
        )


async def under_way(bench: Bench, robot: Robot, **options: Any) -> Task:
    """A motion that goes on until something ends it."""
    bench.motion_time = 600.0
    return await robot.motion.movej2(HOME, v=1.0, a=1.0).start(**options)
