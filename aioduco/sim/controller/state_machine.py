"""The controller as a state machine: no clock, no thread, no wire, no physics.

`tick` is called once per cycle with the values of the arm's sensors, and returns the command to its
drives. Commands come between ticks; each makes a task and returns its id. Motions are planned when
they are queued, or after `plan_in_background` by the code that runs the controller, while other
commands and ticks go on.

Invariants:
- set-points reach the drives only while the robot is enabled and no STOP0 holds;
- a stop is accepted in every state, and does not wait for anything else to end;
- tasks that a safety stop has ended stay ended: only power off, power on, enable end the stop;
- while the controller simulates, the arm's brakes hold, and set-points move a simulated arm. That
  arm follows them exactly, and everything else in this module uses it as the arm.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from aioduco.models.enums import OperationMode, ProgramState, RobotState, SafetyState, TaskState
from aioduco.sim.cabinet.axis_schemes import SimulatedExternalAxes
from aioduco.sim.cabinet.signals import Signals
from aioduco.sim.cabinet.tools import FrameTable, NamedFrame
from aioduco.sim.controller.force_tasks import ForceTasks
from aioduco.sim.controller.monitoring import CollisionDetector, HeartbeatWatchdog, Standstill
from aioduco.sim.controller.motion_queue import DeferredMotion, DeferredMotions, MotionQueue
from aioduco.sim.controller.motion_settings import OptimizationSwitches, WeaveSelection
from aioduco.sim.controller.power import PowerControl
from aioduco.sim.controller.programs import ProgramExecution, ProgramRun
from aioduco.sim.controller.recorder import Recorder
from aioduco.sim.controller.safety import Admission, SafetyController
from aioduco.sim.controller.signal_rules import SignalRules
from aioduco.sim.controller.tasks import MotionPhase, TaskTable
from aioduco.sim.cycle import DriveCommand, SensedState
from aioduco.sim.planner.path import JointSetPoint, PlanError
from aioduco.sim.planner.realtime_follower import RealtimeQueue
from aioduco.sim.planner.track_pool import TrackPool

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco.models.rotation import Array
    from aioduco.sim.controller.motion_queue import Following, Plan, Planning
    from aioduco.sim.controller.triggers import MotionTriggers
    from aioduco.sim.force.control import ForceControl
    from aioduco.sim.force.sensor import ForceSensor
    from aioduco.sim.planner.mover import Drafted, Mover


#: distance of a joint from its set-point that trips the position deviation stop [rad]
DEVIATION = 0.2
_ERRORS = 20  # number of the latest messages in the error list
# Named here for use in the cycle: looking up a member of an enumeration takes ten times as long.
_ENABLED, _STOP1, _MANUAL = RobotState.ENABLE, SafetyState.STOP1, OperationMode.MANUAL
_IDLE, _PAUSED = MotionPhase.IDLE, MotionPhase.PAUSED
_POWERED = (RobotState.DISABLE, RobotState.ENABLE)
_ZEROS = np.zeros(6)
_ZEROS.flags.writeable = False


class ControllerState(NamedTuple):
    """The controller's state at one instant, for readers without a lock.

    Attributes:
        robot, program, safety, mode: as get_robot_state reports them.
        moving: whether the arm moves, as robotmoving reports it: without the swing after a motion.
        emergency_stop: whether the emergency stop is pressed.
        collision_axis: joint that detected a collision, 1 to 6, or 0.
        error: 1 while a safety stop holds, else 0.
        errors: the error list.
        speed: global speed [%].
        tool: the tool in use.
        wobj: the work object in use.
        force_control: whether force control is on.
        sensor: how the controller interprets the signal of the force sensor.
        standing: whether the arm has stood for a while.
        simulation: whether motions move the controller's own simulation, while the arm stands.
    """

    robot: RobotState
    program: ProgramState
    safety: SafetyState
    mode: OperationMode
    moving: bool
    emergency_stop: bool
    collision_axis: int
    error: int
    errors: tuple[str, ...]
    speed: float
    tool: NamedFrame
    wobj: NamedFrame
    force_control: bool
    sensor: ForceSensor
    standing: bool
    simulation: bool


class _Simulation(NamedTuple):
    """The controller's own simulation.

    Attributes:
        arm: set-point that the simulated arm has reached, which is the latest one.
        bare: signal of the force sensor without load and force when the simulation began.
        axes: positions of the external axes at that time.
    """

    arm: JointSetPoint
    bare: tuple[float, ...]
    axes: dict[int, float]


class Controller:
    """Decides in each cycle what the arm does.

    Args:
        mover: makes a mover that stands at the given joints [rad].
        q: the arm's joints at the start [rad]. Shape (6,).
        force: reaction of the arm to forces.

    Attributes:
        sensed: measurements of the arm in this cycle; of the simulated arm while there is one.
        motion: the motions that run and wait.
        power: changes between power off and enabled.
    """

    def __init__(self, mover: Callable[[Array], Mover], q: Array, force: ForceControl) -> None:
        self.tasks: TaskTable = TaskTable()
        self.signals: Signals = Signals()
        self.frames: FrameTable = FrameTable()
        self.heartbeat: HeartbeatWatchdog = HeartbeatWatchdog()
        self.commands: RealtimeQueue = RealtimeQueue()
        self.pool: TrackPool = TrackPool()
        self.optimization: OptimizationSwitches = OptimizationSwitches()
        self.weaving: WeaveSelection = WeaveSelection()
        self.external_axes: SimulatedExternalAxes = SimulatedExternalAxes()
        self.collisions: CollisionDetector = CollisionDetector(np.full(6, np.inf))
        self.recorder: Recorder = Recorder()
        self.rules: SignalRules = SignalRules()
        self.read_ahead: tuple[int, int] = (0, 1)
        self.last_motion: str = ""  # the function of the motion that was accepted last
        self.program_lag: float = 0.0
        self.mode: OperationMode = OperationMode.AUTO
        self.halted: bool = False
        self.power: PowerControl = PowerControl(self.tasks)
        self.motion: MotionQueue = MotionQueue(self.tasks, mover, q)
        self._execution = ProgramExecution(self.tasks)
        self.sensed: SensedState = SensedState(0.0, 0.0, q, _ZEROS, _ZEROS, _ZEROS)
        self._real = self.sensed
        self._simulation: _Simulation | None = None
        self._leaving: list[int] = []  # tasks that end once readers see the real arm again
        self.force: ForceTasks = ForceTasks(self.tasks, self.motion, force, self.sensed)
        self._safety = SafetyController()
        self._deferred = DeferredMotions(self.tasks)
        self._admission = Admission(
            self.power, self._safety, self.motion, self._execution, self._deferred
        )
        self._at_rest = True
        self._standstill = Standstill()
        self._errors: tuple[str, ...] = ()
        self._speed = 100.0
        self._told: tuple[object, ...] = ()  # values from which the latest view was made
        self._view: ControllerState | None = None
        self._jog = 0  # id of the task of the latest jog with a path
        self._jog_ends = TaskState.STOPPED

    # -- state for other modules -------------------------------------------------------------

    @property
    def safety(self) -> SafetyState:
        """State of the safety controller."""
        return self._safety.state(self.power.state)

    @property
    def program(self) -> ProgramState:
        """State of the program, or of all motions together."""
        manual = self.mode is OperationMode.MANUAL
        return self._execution.state(self.motion.phase, manual=manual)

    @property
    def moving(self) -> bool:
        """Whether the arm moves, or is going to move in the next cycle."""
        return self.motion.moving or self.force.moving or not self._at_rest

    @property
    def in_motion(self) -> bool:
        """Whether the arm moves, apart from the swing after a motion that has ended.

        During a stop or a pause it counts as moving: right after a stop is accepted, no cycle has
        yet checked whether the arm stands.
        """
        halting = self.motion.phase in (MotionPhase.STOPPING, MotionPhase.PAUSING)
        return halting or self.motion.moving or self.force.moving or self._standstill.turning

    @property
    def idle(self) -> bool:
        """Whether no motion runs or waits."""
        return self.motion.phase is _IDLE and not self._deferred

    @property
    def simulated(self) -> JointSetPoint | None:
        """Set-point that the simulated arm has reached; None while motions move the real arm."""
        return None if self._simulation is None else self._simulation.arm

    @property
    def busy(self) -> bool:
        """Whether something is under way that needs every cycle."""
        phase = self.motion.phase
        if (phase is not _IDLE and phase is not _PAUSED) or self._execution.running:
            return True
        changing = self.recorder.active or self.rules.busy or bool(self._leaving or self._deferred)
        return self.power.busy or self.moving or changing

    def view(self) -> ControllerState:
        """The state, for readers; the same object for as long as the state does not change."""
        motion, control = self.motion, self.force.control
        safety, frames = self._safety, self.frames
        phase = motion.phase
        # All values on which the state depends, cheap to read: most cycles change none of them.
        told = (
            self.power.state,
            self._execution.state(phase, manual=self.mode is _MANUAL),
            safety.fault,
            self.mode,
            phase,
            motion.moving,
            control.active and control.moving,
            self._standstill.turning,
            self._at_rest,
            safety.emergency_stop,
            self.collisions.axis,
            self._errors,
            self._speed,
            frames.current_tool,
            frames.current_wobj,
            control.active,
            control.sensor,
            self._simulation is None,
        )
        if self._view is None or told != self._told:
            self._told, self._view = told, self._made_view()
        return self._view

    def _made_view(self) -> ControllerState:
        return ControllerState(
            self.power.state,
            self.program,
            self.safety,
            self.mode,
            self.in_motion,
            self._safety.emergency_stop,
            self.collisions.axis,
            int(self._safety.fault is not None),
            self._errors,
            self._speed,
            self.frames.tool(),
            self.frames.wobj(),
            self.force.control.active,
            self.force.control.sensor,
            not self.moving,
            self._simulation is not None,
        )

    # -- commands: each makes a task, and returns its id -------------------------------------

    def move(self, name: str, plan: Plan, triggers: MotionTriggers | None = None) -> int:
        """Queue a motion with its triggers."""
        return self._accept(name, None, lambda id_: self.motion.append(id_, plan, triggers))

    def follow(self, name: str, following: Following) -> int:
        """Queue a motion whose targets arrive while it runs."""
        return self._accept(name, following, lambda id_: self.motion.follow(id_, following))

    def _accept(self, name: str, following: Following | None, begin: Callable[[int], None]) -> int:
        """Queue a motion, which waits until the arm stands if it is being stopped."""
        if reason := self._admission.motion(following):
            return self.reject(name, TaskState.ILLEGAL, reason)
        motion = DeferredMotion(self.tasks.new(name), name, following, begin)
        self.last_motion = name
        if self._ending or self._deferred:  # those that wait begin in the next cycle
            self._deferred.add(motion)
        else:
            self._begin(motion)
        return motion.id

    def _begin(self, motion: DeferredMotion) -> None:
        if (skipped := self.force.admit()) is not None:
            self.tasks.set(motion.id, *skipped)
            return
        motion.begin(motion.id)
        self._collect_failures()

    def _begin_deferred(self) -> None:
        for motion in self._deferred.take():
            if reason := self._admission.motion(motion.following):
                self.tasks.set(motion.id, TaskState.ILLEGAL, reason)
                self.note_error(f"{motion.name}: {reason}")
            else:
                self._begin(motion)
        if self._deferred.paused:
            self._deferred.paused = False
            self.motion.pause()

    @property
    def _ending(self) -> bool:
        """Whether motions or force control are being ended, so that the next motion waits."""
        return self.motion.ending or self.force.closing

    def end_following(self, name: str, *kinds: str) -> int:
        """End the motions of some kinds that follow targets; this task ends at rest."""
        id_ = self.tasks.new(name)
        self._deferred.end(
            TaskState.STOPPED,
            "ended before it began",
            lambda motion: motion.following is not None and motion.following.kind in kinds,
        )
        self.motion.finish(kinds, id_)
        return id_

    def jog(self, name: str, plan: Plan, ended: TaskState = TaskState.STOPPED) -> int:
        """Queue a jog with a path, which begins only if nothing else runs.

        Args:
            name: the function.
            plan: makes the motion.
            ended: its final state if `end_jog` ends it.
        """
        if not self.idle and (self._deferred or not self._ending):
            return self.reject(name, TaskState.ILLEGAL, "other motions are running")
        self._jog, self._jog_ends = self.move(name, plan), ended
        return self._jog

    def end_jog(self, name: str) -> int:
        """End a jog, continuous or a step; this task ends at rest."""
        if self.tasks.state(self._jog).ended or self._jog == 0:
            return self.end_following(name, "move_jog")
        id_ = self.tasks.new(name)
        self._deferred.end(TaskState.STOPPED, "the jog was ended", lambda m: m.id == self._jog)
        self.motion.stop(self._jog_ends, "the jog was ended", id_)
        return id_

    def run_program(self, run: ProgramRun) -> int:
        """Run a program; it begins only if nothing else runs."""
        if reason := self._admission.program():
            return self.reject("run_program", TaskState.ILLEGAL, reason)
        id_ = self.tasks.new("run_program")
        self._execution.begin(id_, run)
        return id_

    def stop(self) -> int:
        """End every task; this task ends when the arm stands."""
        id_ = self.tasks.new("stop")
        self.power.drop_waiting(TaskState.STOPPED, "stopped")
        self._halt(TaskState.STOPPED, "stopped", id_)
        return id_

    def abort(self) -> int:
        """End the running motion and those behind it; this task ends when the arm stands."""
        id_ = self.tasks.new("abort")
        self._halt(TaskState.INTERRUPT, "aborted", id_)
        return id_

    def pause(self) -> int:
        """Pause the program and every motion; this task ends when the arm stands."""
        id_ = self.tasks.new("pause")
        self._execution.pause()
        self._deferred.paused = bool(self._deferred)
        self.motion.pause(id_)
        self._execution.at_standstill(self.motion.phase)
        return id_

    def resume(self) -> int:
        """Resume the paused program and motions."""
        paused = self.program in (ProgramState.PAUSED, ProgramState.PAUSING)
        if paused and (reason := self._admission.moving()):
            return self.reject("resume", TaskState.ILLEGAL, reason)
        self._deferred.paused = False
        self.motion.resume()
        self._execution.resume()
        return self.finish("resume")

    def switch_mode(self, mode: OperationMode) -> int:
        """Switch the mode; a running program and running motions are paused."""
        if mode is not self.mode:
            self.mode = mode
            self._execution.pause()
            self._deferred.paused = bool(self._deferred)
            if self.motion.phase is MotionPhase.RUNNING:
                self.motion.pause()
        return self.finish("switch_mode")

    def simulate(self, on: bool) -> int:
        """Let motions move a simulated arm from where the real one stands, or the real arm again.

        After the latter, the real arm is where its brakes have held it, and so are the set-points.
        """
        if on is (self._simulation is not None):
            return self.finish("simulation")
        if reason := self._under_way():
            return self.reject("simulation", TaskState.ILLEGAL, reason)
        if on:
            self._simulation = _Simulation(
                JointSetPoint.at_rest(self.sensed.q),
                self.force.control.sensor.bare,
                dict(self.external_axes.positions),
            )
            return self.finish("simulation")
        self._leave_simulation()
        id_ = self.tasks.new("simulation")
        self.tasks.set(id_, TaskState.RUNNING)
        self._leaving.append(id_)
        return id_

    def set_speed(self, percent: float) -> int:
        """Set the global speed [%]."""
        self._speed = percent
        self.motion.set_speed(percent / 100.0)
        return self.finish("speed")

    def finish(self, name: str) -> int:
        """Make a task that is finished at once."""
        return self.tasks.ended(name, TaskState.FINISHED)

    def reject(self, name: str, state: TaskState, message: str) -> int:
        """Make a task that ends at once without having been carried out."""
        id_ = self.tasks.ended(name, state, message)
        self.note_error(f"{name}: {message}")
        return id_

    # -- motions that are planned outside the cycle ------------------------------------------

    def plan_in_background(self) -> None:
        """Let motions wait for `next_plan` and `take_plan` from now on."""
        self.motion.in_background = True

    @property
    def unplanned(self) -> int | None:
        """Id of the last motion that is not planned yet; None if there is none."""
        unplanned = self.motion.unplanned
        return unplanned[-1][0] if unplanned else None

    def take_plan(self, planning: Planning, came: Drafted | PlanError) -> None:
        """Take the result of planning a motion, unless the plan was dropped meanwhile."""
        self.motion.take_plan(planning, came)
        self._collect_failures()

    # -- actions without a task --------------------------------------------------------------

    def note_error(self, message: str) -> None:
        """Add to the error list."""
        self._errors = (*self._errors, message)[-_ERRORS:]

    def clear_errors(self) -> None:
        """Empty the error list."""
        self._errors = ()

    def fault(self, category: SafetyState, message: str) -> None:
        """Begin a safety stop: STOP0 cuts power, STOP1 stops the arm first, STOP2 only stops it."""
        self.note_error(message)
        self._safety.trip(category)
        if category is SafetyState.STOP0:
            self._cut(message)
        else:
            self._halt(TaskState.ERROR, message)

    def press_emergency_stop(self) -> None:
        """Handle a pressed emergency stop of the pendant, or its open circuit."""
        if not self._safety.emergency_stop:
            self._safety.emergency_stop = True
            self.fault(SafetyState.STOP0, "emergency stop pressed")

    def release_emergency_stop(self) -> None:
        """Release the button; the safety stop remains until the power was off."""
        self._safety.emergency_stop = False

    def collide(self, joint: int, touched: str = "") -> None:
        """Handle a collision that a joint has detected: the arm stops where it is, and yields.

        Args:
            joint: the joint, 1 to 6.
            touched: text about the contacts, if known; a real controller has no such information.
        """
        if self.power.state is not RobotState.ENABLE:
            return
        self.collisions.axis = joint
        known = touched and f" (simulator: {touched})"
        self.fault(SafetyState.STOP2, f"Joint {joint} 检测到碰撞{known}")
        if not self.force.control.active:  # which has moved the set-points away from the motions'
            self.motion.yield_to(self.sensed.q)

    def reset_collision(self) -> None:
        """Clear the warning; the safety stop remains."""
        self.collisions.axis = 0

    # -- the cycle ---------------------------------------------------------------------------

    def tick(self, sensed: SensedState) -> DriveCommand:
        """Run one cycle."""
        self._real = sensed
        self.rules.tick(sensed.time, self.signals)
        if self._leaving:
            leaving, self._leaving = self._leaving, []
            for id_ in leaving:
                self.tasks.set(id_, TaskState.FINISHED)
        if self._deferred.motions and not self._ending:
            self._begin_deferred()
        simulation = self._simulation
        if simulation is None:
            return self._tick(sensed)
        arm = simulation.arm
        known = sensed._replace(q=arm.q, qd=arm.qd, wrench=_ZEROS, external=_ZEROS)
        weight = self.force.control.sensor.weight(self.force.control.turn(known))
        drive = self._tick(known._replace(wrench=np.add(simulation.bare, weight)))
        if self._simulation is simulation:
            self._simulation = simulation._replace(arm=drive.setpoint)
        return DriveCommand(JointSetPoint.at_rest(sensed.q), brake=True)

    def _tick(self, sensed: SensedState) -> DriveCommand:
        """Run one cycle of the real or simulated arm; idle parts are not called."""
        motion, force, power, time = self.motion, self.force, self.power, sensed.time
        control = force.control
        self.sensed = sensed
        force.sense(sensed)
        self._execution.watch(time, motion.phase, self.program_lag)
        if self.heartbeat.lost(sensed.now):
            self._lose_heartbeat()
        forced = control.active and control.moving
        still = self._standstill.tick(sensed, commanded=forced or motion.moving)
        self._at_rest = still and not forced
        if self.recorder.active and self.recorder.tick(time, sensed.q):
            self.note_error("the recorded track is full")
            self.pause()
        before = power.state
        fault = self._safety.fault
        if fault is _STOP1 and not self.moving and before in _POWERED:
            self._cut("power cut after the stop")
        if power.busy:
            self._change_power(time)
        if power.state is not before:
            self._power_went(before, power.state)
        if power.state is not _ENABLED:
            force.cut()
            self.external_axes.follow({}, motion.mover.cycle)
            self.collisions.reset()
            return DriveCommand(JointSetPoint(sensed.q, _ZEROS, _ZEROS), True)
        joint = self.collisions.update(time, sensed.external)
        if joint and self._safety.fault is None:
            self.collide(joint, sensed.touched())
        setpoint = motion.tick(time, sensed.q, sensed.qd, at_rest=self._at_rest)
        if motion.blending or self.external_axes.positions:
            self._accompany()
        alarm = ""
        if control.active:
            setpoint = force.tick(setpoint)
            alarm = force.take_alarm()
        if motion.failures or motion.faults:
            self._collect_failures()
        if self._execution.active and (reason := self._execution.tick(motion.phase)):
            self.note_error(reason)
            self._halt(TaskState.ERROR, reason)
        if alarm := alarm or _deviation(setpoint.q, sensed.q):
            self.fault(SafetyState.STOP0, alarm)
            return DriveCommand(JointSetPoint(sensed.q, _ZEROS, _ZEROS), True)
        return DriveCommand(setpoint, False)

    def _accompany(self) -> None:
        """What goes on beside the motions: calls that are answered ahead, and external axes."""
        if self.motion.blending:
            self.motion.read_ahead(*self.read_ahead)
        mover = self.motion.mover
        self.external_axes.follow(mover.axes, mover.cycle)

    def _change_power(self, time: float) -> None:
        safe, standing = self._safety.safe, not self.moving
        for event, name in self.power.tick(time, safe=safe, standing=standing):
            if event == "begun":
                self._power_begun(name)
            else:
                self._power_ended(name)

    def _under_way(self) -> str:
        """Why the arm is not completely at rest; empty if it is."""
        if self.in_motion:
            return "the robot moves"
        if not self.idle:
            return "motions are under way or wait"
        if self._execution.active:
            return "a program runs or waits"
        if self.force.control.active:
            return "force control is on"
        return ""

    def _leave_simulation(self) -> None:
        """Switch back to the real arm. The queue must be empty."""
        if self._simulation is None:
            return
        self.external_axes.positions.update(self._simulation.axes)
        self._simulation = None
        self.sensed = self.force.sensed = self._real
        self.motion.reset(self._real.q)
        self.collisions.reset()

    def _power_begun(self, name: str) -> None:
        if name in ("disable", "power_off", "shutdown", "restart"):
            self._halt(TaskState.STOPPED, f"stopped by {name}")

    def _power_ended(self, name: str) -> None:
        if name in ("power_off", "shutdown", "restart"):
            self.collisions.axis = 0
            self._safety.clear()
            self.halted = name == "shutdown"
            if name != "power_off":
                self.heartbeat.disarm()
                self.optimization = OptimizationSwitches()
                self.recorder.stop()
                self._leave_simulation()

    def _power_went(self, before: RobotState, now: RobotState) -> None:
        if now is RobotState.ENABLE and before is not RobotState.ENABLE:
            self.motion.reset(self.sensed.q)
        if (now is RobotState.ENABLE) is not (before is RobotState.ENABLE):
            self.force.powered()
        if now in _POWERED and before not in _POWERED:
            self.clear_errors()

    def _halt(self, state: TaskState, message: str, control: int | None = None) -> None:
        """End the program, every motion and the control task when the arm stands."""
        self._execution.end(state, message)
        self._deferred.end(state, message)
        self.motion.stop(state, message, control)
        self._execution.at_standstill(self.motion.phase)

    def _cut(self, message: str) -> None:
        self._deferred.end(TaskState.ERROR, message)
        self.motion.cut(message, self.sensed.q)
        self._execution.end(TaskState.ERROR, message)
        self._execution.at_standstill(_IDLE)
        self.power.cut(message)
        self.force.cut()

    def _lose_heartbeat(self) -> None:
        """Stop the arm without a safety stop: the next program may move it."""
        if not self.idle or self.power.busy or self._execution.active:
            self.note_error("heartbeat lost: all tasks were stopped")
            self.stop()

    def _collect_failures(self) -> None:
        for message in self.motion.failures:
            self.note_error(message)
        self.motion.failures.clear()
        faults, self.motion.faults = self.motion.faults, []
        for message in faults:
            self.fault(SafetyState.STOP2, message)


def _deviation(wanted: Array, q: Array) -> str:
    """Text about the joint that is too far from its set-point; empty if none is."""
    if math.dist(wanted.tolist(), q.tolist()) <= DEVIATION:
        return ""  # then each joint is near enough; for six, plain floats are faster than arrays
    deviation = np.abs(wanted - q)
    if deviation.max() <= DEVIATION:
        return ""
    return f"joint {int(deviation.argmax()) + 1}: position deviation"
