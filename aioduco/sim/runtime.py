"""The thread that runs the simulation: clock -> physics -> controller -> snapshot.

Which thread may use what:
- only this thread uses the world;
- the controller is changed only under the lock. The lock is held neither during a world step nor
  while a motion is planned, so a command waits for one tick at most;
- motions are planned outside the lock (see `planning`). Where simulated time has no fixed pace (as
  fast as possible, or locked) it stands still meanwhile, so that the cycle in which a motion begins
  does not depend on chance;
- readers take the latest snapshot, which is immutable, without a lock. Before that, the cycles that
  are due run (see `batches`).
"""

from __future__ import annotations

import contextlib
import functools
import logging
import math
import threading
import time
from typing import TYPE_CHECKING

from aioduco.errors import ParameterError
from aioduco.models.enums import RobotState, TaskState
from aioduco.models.rules import condition_holds
from aioduco.sim.batches import Batches
from aioduco.sim.clock import CycleSchedule, LoopStatistics, LoopTimes, checked_speed
from aioduco.sim.cycle import DriveCommand, SensedState
from aioduco.sim.physics.drives import Temperatures
from aioduco.sim.planner.path import JointSetPoint
from aioduco.sim.planning import PlanningThreads
from aioduco.sim.plant_changes import PlantChanges
from aioduco.sim.refusal import Pending, Refusal, SimulationFailed
from aioduco.sim.snapshot import SimulationSnapshot

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence

    from aioduco.models.pose import PoseLike
    from aioduco.models.rotation import Array
    from aioduco.sim.controller.state_machine import Controller
    from aioduco.sim.physics.world import World

    #: called with the state after a cycle, and with a function that describes the arm's contacts
    Observer = Callable[[SimulationSnapshot, Callable[[], str]], None]

_log = logging.getLogger(__name__)

#: interval of the controller's ticks while nothing happens [s of real time]
_STRIDE = 0.02
#: time step of the temperatures [s]
_WARMING = 0.1
#: longest real time for which a client may hold simulated time [s]: it may have been cut off
_HOLD = 2.0
#: polling interval while a change of the controller is under way [s of real time]
_CHANGE = 2e-5
#: simulated time at rest after which the physics need no further steps [s]
_SETTLING = 0.3

#: states of the robot in which the controller serves no client
_BOOTING = (RobotState.START, RobotState.INITIALIZE)
#: more cycles than any idle time contains
_MANY = 1_000_000
_NO_EFFORT_LIMIT: tuple[float, ...] = (math.inf,) * 6


class SimulatedClock:
    """Simulated time as `aioduco.models.controller_clock.Clock`: it can be held.

    Args:
        runtime: the simulation whose time it gives.
    """

    def __init__(self, runtime: SimulationRuntime) -> None:
        self._runtime = runtime

    def __repr__(self) -> str:
        return f"<SimulatedClock at {self.now():.3f} s>"

    def now(self) -> float:
        """Simulated time [s]; after the simulation has ended, the time of its end."""
        return self._runtime.now()

    def hold(self, at: float, *, lasting: bool = False) -> Callable[[], None]:
        """Hold simulated time at `at` [s], or now if later, until the returned function is called.

        Unless `lasting`, simulated time resumes after two seconds of real time in any case.
        """
        return self._runtime.hold(at, lasting=lasting)


class SimulationRuntime(PlantChanges):
    """Runs a controller and its arm in a thread of its own.

    Args:
        controller: the state machine.
        plant: the physics; once the thread runs, only the thread uses it.
        cycle: duration of one controller cycle [s].
        effort: largest torques of the joints, for their temperatures [N m].
        speed: simulated seconds per real second; inf for as fast as possible.
        sense: gives the force sensor's signal for the force and torque on it [N, N m]; None if it
            measures them exactly.
        encode: gives the measured joints for those of the arm [rad], likewise.
        on_network: called on the thread when the controller's network goes down (False: the
            controller restarts, None: it was shut down) and when it comes back (True).
    """

    def __init__(
        self,
        controller: Controller,
        plant: World,
        *,
        cycle: float = 0.001,
        effort: Sequence[float] = _NO_EFFORT_LIMIT,
        speed: float = 1.0,
        sense: Callable[[Array], Array] | None = None,
        encode: Callable[[Array], Array] | None = None,
        on_network: Callable[[bool | None], None] = lambda _up: None,
    ) -> None:
        self._controller = controller
        self.cycle = cycle
        self._pace = CycleSchedule(cycle, speed)
        self._speed = speed
        self._times = LoopTimes()
        self._sense, self._encode = sense, encode
        self._on_network = on_network
        self._lock = threading.Lock()
        self.planning: PlanningThreads = PlanningThreads(
            controller, self._lock, self._changing, self._fail
        )
        super().__init__(plant)
        self._batches = Batches(self._pace, self._wake, self._has_waiters)
        self._snapshot_ready = threading.Condition()
        self._watchers = 0
        #: token of the change of the controller that is under way; the snapshot is older
        self._change: object | None = None
        #: id of the thread that makes the change; None if a cycle makes it
        self._changer: int | None = None
        self._holds: dict[object, float] = {}
        self._lasting: set[object] = set()
        #: real time of the first command that no cycle has taken yet [s]
        self._given_at = math.inf
        #: real time at which a hold that had stopped simulated time was last released [s]
        self._released_at = -math.inf
        self._holding = threading.Condition()
        self._waiters: dict[int, list[threading.Event]] = {}
        self._closing = False
        self._failure: Exception | None = None
        #: called after every cycle
        self.observer: Observer | None = None
        self._thread = threading.Thread(target=self._run, name="sim-loop", daemon=True)
        self._network: bool | None = True
        self._warmth = Temperatures(effort)
        self._temperatures = self._warmth.joints, self._warmth.boards
        self._warm_at = 0.0
        self._touched = plant.touched
        self._count = self._quiet = 0
        #: while simulated time is locked, the cycle up to which it may run
        self._limit: int | None = None
        self._stands = threading.Event()
        self._things: Mapping[str, PoseLike] | None = None
        self._misplaced: Exception | None = None
        self._busy: bool = False
        self._braked: bool | None = None
        at = plant.reading()
        wrench = at.wrench if sense is None else sense(at.wrench)
        self._drive = DriveCommand(JointSetPoint.at_rest(at.q), brake=True)
        self._snapshot = SimulationSnapshot(
            SensedState(0.0, 0.0, at.q, at.qd, wrench, at.external_torque),
            at,
            at.qdd,
            self._drive.setpoint,
            controller.view(),
            controller.collisions.torque,
            self._temperatures,
        )

    # -- for handlers and tests, from any thread -----------------------------------------------

    def check(self) -> None:
        """Check that the simulation has not failed.

        Raises:
            SimulationFailed: It has.
        """
        if self._failure is not None:
            raise SimulationFailed(self._failure) from self._failure

    @property
    def snapshot(self) -> SimulationSnapshot:
        """The latest snapshot.

        Raises:
            SimulationFailed: The simulation has failed, so the latest snapshot is out of date.
        """
        self.check()
        self._catch_up()
        return self._snapshot

    def _catch_up(self) -> None:
        # A change holds the lock that every cycle needs; the due cycles ran before it began.
        wait = self._changer != threading.get_ident() and not self._within
        self._batches.catch_up(wait=wait)

    @contextlib.contextmanager
    def command(self) -> Iterator[Controller]:
        """Give the controller for commands; readers see their effect when the context ends.

        By then a commanded motion has been planned, or its task has ended.

        Raises:
            SimulationFailed: The simulation has failed.
        """
        self.check()
        if self._within:  # a program of the controller makes a call, under the lock of the tick
            yield self._controller
            return
        self._catch_up()
        with self.planning.giving_way(), self._changing() as controller:
            before = controller.unplanned
            yield controller
            came = controller.unplanned
            self._given_at = min(self._given_at, time.monotonic())
        self._wake.set()
        if came is not None and came != before:
            self.planning.plan(came)

    @contextlib.contextmanager
    def _changing(self) -> Iterator[Controller]:
        """Give the controller under the lock; then update the snapshot and wake waiting callers."""
        with self._lock:
            self._change, self._changer = object(), threading.get_ident()
            try:
                yield self._controller
            finally:
                self._snapshot = self._snapshot.seen(self._controller.view())
                self._change = self._changer = None
                released = self._take_answered()
        for event in released:
            event.set()

    def task_state(self, id_: int) -> TaskState:
        """State of a task. Waits until the snapshot shows the cycle in which it came about."""
        self._catch_up()
        state = self._controller.tasks.state(id_)
        # Poll without the lock, for which the loop would compete again and again at top speed.
        if (change := self._change) is not None and not self._within:
            while self._change is change:
                time.sleep(_CHANGE)
        return state

    def wait(self, id_: int) -> TaskState:
        """Wait until a task has ended, and give its final state.

        For a motion that may blend into the next one, the wait ends before the motion ends: see
        `MotionQueue.read_ahead`.

        Raises:
            Refusal: The simulation ended before the task, or failed (`SimulationFailed`).
            Pending: The call comes from a program, which the controller itself continues.
        """
        if self._within:
            raise Pending(id_)
        tasks = self._controller.tasks
        with self._lock:
            if (state := tasks.answer(id_)).ended:
                return state
            ended = threading.Event()
            self._waiters.setdefault(id_, []).append(ended)
        if not self._closing:  # checked after the registration: `release` sets the flag first
            ended.wait()
        if not (state := tasks.answer(id_)).ended:
            self.check()
            raise Refusal("the simulation ended before the task")
        return state

    def wait_until(self, predicate: Callable[[], bool], timeout: float) -> bool:
        """Wait until a condition holds, which is checked at most once per cycle.

        Args:
            predicate: the condition.
            timeout: the longest wait, in simulated time [s].

        Returns:
            Whether the condition holds.

        Raises:
            ValueError: `timeout` is not a number.
        """
        if math.isnan(timeout):
            raise ValueError("timeout is nan, but must be a time [s]")
        end = self.snapshot.time + timeout
        with self._snapshot_ready:
            self._watchers += 1
        try:
            # Called without the lock: a predicate may call the controller, which needs the loop.
            while not condition_holds("predicate", predicate()):
                snapshot = self.snapshot
                if snapshot.time >= end or self._closing:
                    return False
                with self._snapshot_ready:
                    self._snapshot_ready.wait_for(functools.partial(self._newer, snapshot))
            return True
        finally:
            with self._snapshot_ready:
                self._watchers -= 1

    @property
    def _within(self) -> bool:
        return threading.current_thread() is self._thread

    def _newer(self, seen: SimulationSnapshot) -> bool:
        return self._snapshot is not seen or self._closing

    def now(self) -> float:
        """Simulated time [s]; after the simulation has ended or failed, the time of its end."""
        self._catch_up()
        return self._snapshot.time

    def hold(self, at: float, *, lasting: bool = False) -> Callable[[], None]:
        """Hold simulated time at `at` [s], or now if later, until the returned function is called.

        Unless `lasting`, simulated time resumes after two seconds of real time in any case.

        Raises:
            ValueError: `at` is not a number.
        """
        if math.isnan(at):
            raise ValueError("at is nan, but must be a time [s]: nothing is held")
        key = object()

        def release_hold() -> None:
            with self._holding:
                held = self._holds.pop(key, None) is not None
                self._lasting.discard(key)
                if held and at <= self._snapshot.time:
                    self._released_at = time.monotonic()
                self._holding.notify_all()

        self._catch_up()
        with self._holding:
            self._holds[key] = at
            if lasting:
                self._lasting.add(key)
        return release_hold

    def lock(self) -> None:
        """Lock simulated time: from now on it stands still, and only `advance` moves it.

        While it is locked, every cycle is computed, also those in which nothing happens.
        """
        with self._holding:
            self._stands.clear()
            self._limit = self._count
            self._holding.notify_all()
        self._wake.set()
        self._await_stand()
        self._limit = self._count  # the thread may have been within a cycle

    def unlock(self) -> None:
        """Unlock simulated time, so that it runs by itself again."""
        with self._holding:
            self._limit = None
            self._holding.notify_all()

    def advance(self, cycles: int) -> None:
        """Run a number of cycles, and return when they have run.

        Raises:
            RuntimeError: simulated time is not locked.
            Refusal: The simulation has ended, or failed (`SimulationFailed`).
        """
        with self._holding:
            self._limit = self._locked() + cycles
            self._stands.clear()
            self._holding.notify_all()
        self._await_stand()

    def arrange(self, things: Mapping[str, PoseLike]) -> None:
        """Reset the physics: the arm at its set-point, things at their poses [m, rad].

        Raises:
            RuntimeError: simulated time is not locked.
            ParameterError: there is no such thing.
            Refusal: The simulation has ended, or failed (`SimulationFailed`).
        """
        with self._holding:
            self._locked()
            self._things, self._misplaced = things, None
            self._stands.clear()
            self._holding.notify_all()
        self._await_stand()
        if self._misplaced is not None:
            raise self._misplaced

    def _locked(self) -> int:
        if self._limit is None:
            raise RuntimeError("simulated time is not locked: nothing was done")
        return self._limit

    def _await_stand(self) -> None:
        if not self._closing:  # checked after the event was cleared: `release` sets the flag first
            self._stands.wait()
        if self._closing:
            self.check()
            raise Refusal("the simulation ended")

    def set_speed(self, speed: float) -> None:
        """Set another speed: simulated seconds per real second."""
        self._speed = checked_speed(speed)
        self._wake.set()

    def statistics(self) -> LoopStatistics:
        """Timing of the cycles."""
        return self._times.statistics(self._pace.slipped)

    def start(self) -> None:
        """Start the threads."""
        self._thread.start()
        self.planning.start()

    def release(self) -> None:
        """Wake every call that waits for a task; from now on no call waits any more."""
        self._closing = True
        self._stands.set()
        self.planning.end()
        with self._lock:
            waiters, self._waiters = self._waiters, {}
        for events in waiters.values():
            for event in events:
                event.set()
        with self._snapshot_ready:
            self._snapshot_ready.notify_all()
        with self._holding:
            self._holding.notify_all()
        self._wake.set()

    def close(self) -> None:
        """End the threads, and wait until they have ended."""
        self.release()
        if self._thread.is_alive():
            self._thread.join()
        self.planning.join()

    # -- the thread ----------------------------------------------------------------------------

    def _run(self) -> None:
        try:
            self._loop()
        except Exception as exc:
            self._fail(exc)
        finally:
            self._batches.end()

    def _fail(self, exc: Exception) -> None:
        _log.exception("the simulation failed")
        self._failure = exc
        self._change = None
        self.release()

    def _loop(self) -> None:
        clock, pace = time.monotonic, self._pace
        idle = False
        # The clock is read once at the end of a cycle, and once more after a sleep.
        now = clock()
        pace.begin(now)
        while not self._closing:
            if self._holds or self._limit is not None:
                self._stand_still(idle=idle)
                now = clock()
                if idle and self._limit is not None:
                    idle = False
                    pace.begin(now)
            if self._speed != pace.speed:
                self._batches.end()
                pace.change(self._speed, now, idle=idle)
            if idle:
                passed = self._stride()
                if passed is None:
                    continue
                cycles, now = passed, clock()
            else:
                cycles, paced = 1, pace.period > 0.0  # else each cycle follows the one before
                begun = self._batches.await_cycle(now) if paced else now
                if begun is None:
                    now = clock()
                    continue
                if self._changes or self._braked is not self._drive.brake:
                    self._change_plant()
                self._plant.step(self._drive.setpoint)
                pace.ran()
                self._tick(begun)
                now = clock()
                self._times.add(self._batches.late, now - begun)
                if paced:
                    self._batches.ran()
            if self._busy and not idle:
                self._quiet = 0
            elif idle != self._is_idle(cycles):
                idle = not idle
                self._batches.end()
                pace.begin(now, idle=idle)

    def _stride(self) -> int | None:
        """Run the cycles of a while in which nothing happens.

        Returns:
            Their number; None if simulated time was locked meanwhile, and none ran.
        """
        if self._wake.wait(_STRIDE):
            self._wake.clear()
        self._stand_still(idle=True)
        if self._limit is not None:
            return None
        cycles = self._tick(time.monotonic(), idle=True)
        self._pace.ran(cycles)
        return cycles

    def _has_waiters(self) -> bool:
        """Whether a caller waits for one of the next cycles."""
        if self._watchers or self.observer or self._holds or self._limit is not None:
            return True
        if self._controller.unplanned is not None:
            return True  # else a caller would wait for many cycles, which compete with the planning
        return bool(self._waiters) and self._controller.motion.time_left < self._batches.longest

    def _change_plant(self) -> None:
        """Make the changes since the last cycle, the brakes' included."""
        self._make_changes()
        if self._braked is not self._drive.brake:
            self._braked = self._drive.brake
            self._plant.brake(self._braked)

    def _allowed(self) -> int:
        """Number of cycles that may run until simulated time must stand still."""
        until = min(tuple(self._holds.values()), default=math.inf)
        left = (until - self._count * self.cycle) / self.cycle
        held = math.ceil(min(max(left, 0.0), _MANY))
        limit = self._limit
        return held if limit is None else min(held, max(0, limit - self._count))

    def _stand_still(self, *, idle: bool) -> None:
        """Wait while a client holds or locks simulated time."""
        if (not self._holds and self._limit is None) or self._allowed():
            return
        self._batches.end()
        with self._holding:
            while not self._holding.wait_for(self._may_go_on, _HOLD):
                at = self._count * self.cycle
                over = [
                    key
                    for key, end in self._holds.items()
                    if end <= at and key not in self._lasting
                ]
                for key in over:
                    del self._holds[key]
                if over:
                    _log.warning("simulated time was held for %g s, and goes on", _HOLD)
        self._pace.begin(time.monotonic(), idle=idle)  # the cycles of the wait are not made up for

    def _may_go_on(self) -> bool:
        """Whether simulated time may run on; while it is locked, arrange the scene on request."""
        if self._limit is not None and self._limit <= self._count:
            if (things := self._things) is not None:
                self._things = None
                try:
                    self._plant.arrange(self._drive.setpoint.q, things)
                except ParameterError as exc:
                    self._misplaced = exc
            self._stands.set()
        return self._closing or self._allowed() > 0

    def _tick(self, now: float, *, idle: bool = False) -> int:
        """Run one cycle, or while nothing happens all that are due; return their number.

        Args:
            now: real time [s].
            idle: whether nothing happens.
        """
        controller = self._controller
        reading = self._plant.reading()
        qdd, external = reading.qdd, reading.external_torque
        wrench = reading.wrench if self._sense is None else self._sense(reading.wrench)
        followed = self._drive.setpoint  # the set-point that moved the arm to where it is now
        with self._lock:
            if controller.unplanned is not None:
                self._wait_for_plans()
            cycles = self._idle_cycles() if idle else 1
            self._given_at = math.inf
            self._count += cycles
            at = self._count * self.cycle
            if at - self._warm_at >= _WARMING:
                self._warm(at, reading.torque)
            q = reading.q if self._encode is None else self._encode(reading.q)
            sensed = SensedState(at, now, q, reading.qd, wrench, external, self._touched)
            simulated = controller.simulated
            self._change = object()
            if self._told:
                told, self._told = self._told, []
                for tell in told:
                    tell()
            self._drive = controller.tick(sensed)
            view = controller.view()
            network = None if controller.halted else view.robot not in _BOOTING
            if network and not self._network:
                # Before the snapshot: who sees the controller started can connect.
                self._network = network
                self._on_network(network)
            if simulated is not None:
                followed, qdd = simulated, simulated.qdd
            self._snapshot = snapshot = SimulationSnapshot(
                controller.sensed,
                reading,
                qdd,
                followed,
                view,
                controller.collisions.torque,
                self._temperatures,
            )
            self._change = None
            # Before a command can come: else the cycle in which it counts would depend on chance.
            self._busy = controller.busy
            released = self._take_answered() if controller.tasks.newly_answered else ()
            if controller.unplanned is not None:
                self.planning.plan_in_background()
        if (observer := self.observer) is not None:
            observer(snapshot, self._touched)
        for event in released:
            event.set()
        if self._watchers:
            with self._snapshot_ready:
                self._snapshot_ready.notify_all()
        if network is not self._network:
            self._network = network
            self._on_network(network)
        return cycles

    def _idle_cycles(self) -> int:
        """Number of cycles that pass in which nothing happens. Call under the lock.

        A caller that holds simulated time and gives a command reads the time at which the
        controller receives the command. So no command comes between this and the tick, and the time
        after one passes behind the tick. Real time before the release of a hold is not caught up
        with, even if this thread did not notice the hold.
        """
        self._pace.drop(self._released_at)
        return min(self._pace.due(min(time.monotonic(), self._given_at)), self._allowed())

    def _wait_for_plans(self) -> None:
        """Plan all motions where time has no fixed pace; the lock is held on entry and return."""
        while self._controller.unplanned is not None and not self._closing:
            if self._limit is None and not math.isinf(self._speed):
                return
            self._lock.release()
            try:
                self.planning.plan()
            finally:
                self._lock.acquire()

    def _warm(self, at: float, torque: Array) -> None:
        """Update the temperatures for the torques since the last update."""
        powered = self._snapshot.view.robot in (RobotState.DISABLE, RobotState.ENABLE)
        self._warmth.tick(at - self._warm_at, torque, powered=powered)
        self._temperatures = self._warmth.joints, self._warmth.boards
        self._warm_at = at

    def _take_answered(self) -> list[threading.Event]:
        """Events of callers whose tasks have ended or were passed on. Call under the lock."""
        released: list[threading.Event] = []
        for id_ in self._controller.tasks.take_answered():
            released += self._waiters.pop(id_, ())
        return released

    def _is_idle(self, cycles: int) -> bool:
        """Whether the arm has stood still for so long that the physics would change nothing."""
        changing = self._busy or self._braked is not self._drive.brake
        changing = changing or self._acted_upon or not self._plant.still
        changing = changing or self._limit is not None
        self._quiet = 0 if changing else self._quiet + cycles
        return self._quiet * self.cycle >= _SETTLING
