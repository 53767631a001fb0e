"""The program's commands on the simulator's own controller: the set-points that should come.

The controller of the simulator runs here without threads, wire and physics: its arm follows the
set-points exactly. Time is an argument. Only motions along a path are rehearsed; for other commands
that move an arm the rehearsal is blind until the arm stands again.
"""

from __future__ import annotations

import math
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, NamedTuple, cast

import numpy as np

from aioduco.models.enums import RobotState, TaskState
from aioduco.sim.controller.state_machine import Controller
from aioduco.sim.cycle import PlantReading, SensedState
from aioduco.sim.force.control import ForceControl
from aioduco.sim.force.sensor import DOWN
from aioduco.sim.handlers import Handlers
from aioduco.sim.handlers.base import HandlerContext, arguments_of
from aioduco.sim.planner.mover import Mover
from aioduco.sim.snapshot import SimulationSnapshot

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from aioduco.kinematics import Arm
    from aioduco.models.rotation import Array
    from aioduco.sim.runtime import SimulationRuntime
    from aioduco.sim.twin.data import Six, TwinCommand


#: cycle of the rehearsing controller [s]
CYCLE = 0.004
#: time for which its set-points are kept, and so the longest delay that is measured [s]
_KEPT = 2.0
_ROWS = round(_KEPT / CYCLE)
#: set-points around the last place among which the next one is looked for
_BESIDE = 25
#: distance up to which arm and rehearsal stand at one place [rad]
_THERE = 1e-3
#: set-points closer together than this are one place [rad]
_SAME = 2e-4
_ZEROS = np.zeros(6)

#: motions along a path
PATHS = frozenset(
    (
        *("movej", "movej2", "movej_pose", "movej_pose2", "movel", "movec", "tcp_move"),
        *("tcp_move_2p", "wobj_move", "wobj_move_2p", "move_circle", "move_spiral"),
        *("spline", "spline_op"),
    )
)
#: commands that change how motions are carried out
SETTINGS = frozenset(
    (
        *("speed", "set_blend_ahead", "set_tool_data", "set_wobj", "set_wobj_offset"),
        *("set_load_data", "enable_speed_optimization", "disable_speed_optimization"),
        *("enable_acc_optimization", "disable_acc_optimization", "enable_singularity_control"),
        *("disable_singularity_control", "enable_vibration_control", "disable_vibration_control"),
    )
)
#: commands that end or hold motions
HALTS = frozenset(("stop", "abort", "pause", "resume"))
#: beginnings of the names of functions that move or hold an arm in ways that are not rehearsed
_UNKNOWN_WAYS = (
    *("move", "servo", "speedj", "speedl", "teach_mode", "replay", "run_program", "track"),
    *("fc_", "start_realtime", "realtime", "combine_motion", "enable_combine", "simulation"),
    *("enable_eaxis", "switch_mode", "log_error"),
)


class Match(NamedTuple):
    """A set-point of the arm beside those of the rehearsal.

    Attributes:
        distance: largest joint angle between it and the path of the last two seconds [rad].
        joint: the joint with that angle, 1 to 6.
        delay: how long ago the rehearsal was there [s]; 0 while it stands there.
        moving: whether the rehearsal moved in these two seconds.
    """

    distance: float
    joint: int
    delay: float
    moving: bool


class Rehearsal:
    """Rehearses commands on the simulator's controller.

    Args:
        arm: the arm.

    Attributes:
        blind: why nothing is predicted now; empty if it is.
        unknown_since: time of the last command that may move the arm in a way that is not
            rehearsed [s].
    """

    def __init__(self, arm: Arm) -> None:
        self._arm = arm
        #: the last call of each setting, which a new controller gets, too
        self._settings: dict[tuple[str, Any], tuple[Any, ...]] = {}
        self._run: _Run | None = None
        self.blind: str = "the arm was not seen standing yet"
        self.unknown_since: float = -math.inf

    @property
    def idle(self) -> bool:
        """Whether no motion is rehearsed."""
        return self._run is None or not self._run.controller.busy

    def rests_at(self, expected: Six) -> bool:
        """Whether it stands, at these set-points [rad]."""
        run = self._run
        return run is not None and self.idle and run.place(np.array(expected)).distance < _THERE

    @property
    def setpoint(self) -> tuple[Array, Array] | None:
        """Joints of the set-point and their speeds [rad, rad/s]; None while it is blind."""
        return None if self._run is None else self._run.setpoint

    def hide(self, why: str, since: float = -math.inf) -> None:
        """Predict nothing until the next `begin`; `since` as `unknown_since`."""
        self.blind = why
        self._run = None
        self.unknown_since = max(self.unknown_since, since)

    def begin(self, q: Six, time: float) -> None:
        """Begin with an enabled arm that stands at q [rad]."""
        self._run = _Run(self._arm, np.array(q), time)
        self.blind = ""
        for (function, _), arguments in self._settings.items():
            self._run.call(function, arguments)

    def command(self, command: TwinCommand) -> bool | None:
        """Carry out a command of the program.

        Returns:
            Whether the rehearsal accepts it; None if it does not judge that.
        """
        function, arguments = command.function, command.arguments
        if function in SETTINGS:
            if not command.accepted:
                return None
            name = arguments[0] if function == "set_tool_data" else None
            self._settings.pop((function, name), None)
            self._settings[function, name] = arguments
        elif function not in PATHS and function not in HALTS:
            if function.startswith(_UNKNOWN_WAYS) and command.accepted is not False:
                self.hide(f"{function} is not rehearsed", command.time)
            return None
        if self._run is None:
            return None
        accepted = self._run.call(function, arguments)
        if function not in PATHS:
            return None
        if accepted is not True:
            if command.accepted:
                # a tool of the pendant, for instance, is not known here
                self.hide(f"{function} cannot be rehearsed: {self._run.reason}", command.time)
            return accepted
        if not command.accepted:
            self.hide(f"{function} was not accepted", command.time)
        return True

    def advance(self, time: float) -> None:
        """Run to a time [s]."""
        if self._run is not None:
            self._run.advance(time)

    def match(self, expected: Six) -> Match | None:
        """Compare a set-point of the arm at the present time; None while it is blind."""
        return None if self._run is None else self._run.match(np.array(expected))


class _Run:
    """A controller from one begin to the next."""

    def __init__(self, arm: Arm, q: Array, time: float) -> None:
        self.controller = Controller(
            lambda at: Mover(arm, at, CYCLE), q, ForceControl(arm, CYCLE, DOWN)
        )
        self._q, self._qd = q, _ZEROS
        self.time = time - 60.0
        while self.controller.view().robot is not RobotState.ENABLE:
            for name in ("power_on", "enable"):
                if not self.controller.busy:
                    self.controller.power.request(name)
                    self._settle()
        self.time = time
        self.moved_at = -math.inf
        self.reason = ""
        # the set-points of the last cycles, twice, so that they are always in one piece
        self._path = np.tile(q, (2 * _ROWS, 1))
        self._times = np.full(2 * _ROWS, time)
        self._next = 0
        self._near = 0
        runtime = cast("SimulationRuntime", _UnthreadedRuntime(self))
        self._handlers = Handlers(HandlerContext(arm, runtime, self.controller, "TWIN"))

    @property
    def setpoint(self) -> tuple[Array, Array]:
        """Joints of the set-point and their speeds [rad, rad/s]."""
        return self._q, self._qd

    def _settle(self) -> None:
        """Run while the power changes; nothing moves, so that the cycles may be long."""
        while self.controller.busy:
            self.time += 0.1
            self._tick()

    def _tick(self) -> None:
        drive = self.controller.tick(self.sensed)
        self._q, self._qd = drive.setpoint.q, drive.setpoint.qd

    @property
    def sensed(self) -> SensedState:
        return SensedState(self.time, self.time, self._q, self._qd, _ZEROS, _ZEROS)

    def call(self, function: str, arguments: tuple[Any, ...]) -> bool | None:
        """Make a call that does not block; return whether it was accepted, None if it failed."""
        names = arguments_of(function)[: len(arguments)]
        if "block" in names:
            at = names.index("block")
            arguments = (*arguments[:at], False, *arguments[at + 1 :])
        before = len(self.controller.view().errors)
        try:
            answer = getattr(self._handlers, function)(*arguments)
        except Exception as exc:  # arguments of another version of the wire, for instance
            self.reason = repr(exc)
            return None
        task = self.controller.tasks.get(answer)
        if task is None:
            return None
        errors = self.controller.view().errors
        self.reason = errors[-1] if len(errors) > before else task.state.name
        return not task.state.ended or task.state is TaskState.FINISHED

    def advance(self, time: float) -> None:
        if not self.controller.busy and time - self.moved_at > _KEPT + 1.0:
            self.time = time  # it stands, and so do all set-points that are kept
            self._times[:] = time
            return
        while self.time + CYCLE <= time:
            self.time += CYCLE
            before = self._q
            self._tick()
            if self._q is not before and bool(np.any(self._qd)):
                self.moved_at = self.time
            for row in (self._next, self._next + _ROWS):
                self._path[row], self._times[row] = self._q, self.time
            self._next = (self._next + 1) % _ROWS

    def place(self, q: Array) -> Match:
        """Compare a set-point with the present one."""
        apart = np.abs(self._q - q)
        joint = int(apart.argmax())
        return Match(float(apart[joint]), joint + 1, 0.0, False)

    def match(self, q: Array) -> Match:
        moving = self.time - self.moved_at < _KEPT
        if not moving:
            return self.place(q)
        # first where the arm was last, since almost always it is a little further now
        found = self._nearest(q, max(0, _ROWS - 1 - self._near - _BESIDE))
        if found.distance > _SAME and self._near + _BESIDE < _ROWS - 1:
            found = self._nearest(q, 0)
        self._near = min(_ROWS - 2, round(found.delay / CYCLE))
        return found

    def _nearest(self, q: Array, first: int) -> Match:
        """The nearest place among the kept set-points from one on, the oldest being number 0."""
        path = self._path[self._next + first : self._next + _ROWS]
        times = self._times[self._next + first : self._next + _ROWS]
        begin, step = path[:-1], path[1:] - path[:-1]
        length = np.einsum("ij,ij->i", step, step)
        along = np.einsum("ij,ij->i", q - begin, step) / np.maximum(length, 1e-18)
        share = np.minimum(np.maximum(along, 0.0), 1.0)
        apart = np.abs(begin + share[:, None] * step - q)
        distances = apart.max(axis=1)
        # The latest time at which it was as near: a place where it stands is not late.
        last = int(np.flatnonzero(distances <= distances.min() + _SAME)[-1])
        delay = self.time - float(times[last] + share[last] * (times[last + 1] - times[last]))
        joint = int(apart[last].argmax())
        return Match(float(distances[last]), joint + 1, max(0.0, delay), True)


class _UnthreadedRuntime:
    """The part of `SimulationRuntime` that handlers of motions and settings use."""

    cycle = CYCLE

    def __init__(self, run: _Run) -> None:
        self._run = run
        self._controller = run.controller

    @contextmanager
    def command(self) -> Iterator[Controller]:
        yield self._controller

    @property
    def snapshot(self) -> SimulationSnapshot:
        sensed, controller = self._run.sensed, self._controller
        q = sensed.q
        none = PlantReading(q, q, _ZEROS, _ZEROS, _ZEROS, _ZEROS, _ZEROS, _ZEROS)
        at = controller.motion.setpoint
        warmth = (_ZEROS, _ZEROS)
        return SimulationSnapshot(sensed, none, _ZEROS, at, controller.view(), (0.0,) * 6, warmth)

    def wait(self, id_: int) -> int:
        """Return the task instead of waiting for it: time stands still during a call."""
        return id_

    def load(self, _mass: float, _centre: object, told: Callable[[], object]) -> None:
        """Tell the sensor at once: there are no physics."""
        told()
