"""Brings the robot from any state into one in which it can move.

`BringUp` decides on the steps, without a clock or a connection; `bring_up` carries them out.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from enum import Enum, auto
from typing import TYPE_CHECKING

from aioduco.errors import (
    DucoError,
    PersonNeeded,
    RobotStateError,
    StaleState,
    TaskError,
    TaskStopped,
)
from aioduco.models.enums import ProgramState, RobotState, SafetyState
from aioduco.models.ranges import TIMEOUT as SECONDS
from aioduco.supervision.concurrency import every

if TYPE_CHECKING:
    from aioduco.models.state import RobotStates
    from aioduco.supervision.supervisor import Supervisor

#: seconds between two reads of the states
LOOK_EVERY = 0.02

_STOPS = {SafetyState.STOP0, SafetyState.STOP1, SafetyState.STOP2}
_PAUSED = {ProgramState.PAUSED, ProgramState.PAUSING}
_BUSY = {ProgramState.RUNNING, ProgramState.TASK_RUNNING}
_BOOTING = {RobotState.START, RobotState.INITIALIZE}
_STARTING = {SafetyState.INIT, SafetyState.WAIT, SafetyState.BOOT}

_MANUAL_ACTIONS: dict[SafetyState, str] = {
    SafetyState.FAIL: (
        "the safety controller reports a fatal error: switch the cabinet off and on again; if it "
        "comes back, call the vendor"
    ),
    SafetyState.RECOVERY: (
        "the safety controller is in recovery mode: bring the arm back inside its safety limits "
        "at the pendant, then leave that mode"
    ),
    SafetyState.CONFIG: "the safety controller is being configured: finish that at the pendant",
    SafetyState.MODEL: "the arm's model is being configured: finish that at the pendant",
    SafetyState.UPDATE: "the safety controller is being updated: wait until that has ended",
}


class BringUpStep(Enum):
    """The next step."""

    DONE = auto()
    WAIT = auto()
    RESET_COLLISION = auto()
    STOP = auto()
    POWER_OFF = auto()
    POWER_ON = auto()
    ENABLE = auto()


@dataclass(frozen=True, slots=True)
class RecoverReport:
    """How the robot was brought into a state in which it can move.

    Attributes:
        states: the states afterwards: enabled, with no program running.
        collision: whether a collision was reset.
        stopped: whether the arm was powered off to clear a safety stop.
        sensor_tared: whether the arm was powered off or enabled: a controller with a force sensor
            then tares it (manual 1.3.10).
    """

    states: RobotStates
    collision: bool = False
    stopped: bool = False
    sensor_tared: bool = False

    @property
    def advice(self) -> str:
        """What to do before forces are measured again; empty if there was no stop to clear."""
        if not self.sensor_tared or not (self.collision or self.stopped):
            return ""
        touching = (
            "After the collision it may still touch something"
            if self.collision
            else "If it touches something"
        )
        return (
            "the force sensor, if there is one, was tared with the arm where it stands. "
            f"{touching}: then forces are measured without that one. Lead the arm away, and tare "
            "again with nothing touched, by robot.force.fc_force_set_value"
        )

    def __str__(self) -> str:
        return "; ".join(filter(None, (str(self.states), self.advice)))


class BringUp:
    """Decides the next step from the states that were read.

    After a safety stop the arm is powered off and on, once. Each step is returned once; after that
    the step is `WAIT`, until the states show its effect.

    Args:
        end_programs: whether to end a running program; if not, a person has to end it.
        call: name of the method that a person calls again afterwards, for messages.

    Attributes:
        call: the same name.
    """

    def __init__(self, *, end_programs: bool = False, call: str = "bring_up") -> None:
        self._asked: set[BringUpStep] = set()
        self._end_programs = end_programs
        self.call = call

    def has_taken(self, *steps: BringUpStep) -> bool:
        """Whether one of these steps was returned."""
        return not self._asked.isdisjoint(steps)

    def next(self, states: RobotStates, *, emergency_stop: bool, collision: bool) -> BringUpStep:
        """Return the next step.

        Args:
            states: the controller's states.
            emergency_stop: whether an emergency stop is reported as pressed.
            collision: whether a collision is reported.

        Raises:
            PersonNeeded: a person has to do something first; the message says what.
            RobotStateError: a program runs that this must not end.
        """
        self._raise_if_person_needed(states, emergency_stop)
        stopped = states.safety in _STOPS
        step = BringUpStep.WAIT
        if states.safety in _STARTING or states.robot in _BOOTING:
            step = BringUpStep.WAIT
        elif collision and BringUpStep.RESET_COLLISION not in self._asked:
            step = BringUpStep.RESET_COLLISION
        elif stopped and BringUpStep.POWER_OFF not in self._asked:
            step = BringUpStep.POWER_OFF
        elif states.robot is RobotState.POWER_OFF:
            step = BringUpStep.POWER_ON
        elif stopped:
            step = BringUpStep.WAIT
        elif states.robot is RobotState.DISABLE:
            step = BringUpStep.ENABLE
        elif states.program in _PAUSED or states.program in _BUSY:
            # A stop that had to be cleared paused it. Otherwise a program or a person did.
            if not self._end_programs and self._asked <= {BringUpStep.WAIT}:
                raise RobotStateError(
                    "a motion or a program is paused, perhaps by another program: continue it by "
                    "robot.resume(), or end it by robot.stop() or robot.recover(), then call "
                    f"{self.call}() again. Nothing was done to it"
                )
            step = BringUpStep.STOP
        elif states.robot is RobotState.ENABLE and states.program is ProgramState.STOPPED:
            step = BringUpStep.DONE
        return self._once(step)

    def _once(self, step: BringUpStep) -> BringUpStep:
        if step in self._asked and step is not BringUpStep.DONE:
            return BringUpStep.WAIT
        self._asked.add(step)
        return step

    def _raise_if_person_needed(self, states: RobotStates, emergency_stop: bool) -> None:
        again = f"then call {self.call}() again"
        if emergency_stop:
            raise PersonNeeded(
                "an emergency stop is pressed: see that nobody is near the arm, release the "
                f"button, {again}"
            )
        if (reason := _MANUAL_ACTIONS.get(states.safety)) is not None:
            raise PersonNeeded(f"{reason}; {again}")
        if states.robot is RobotState.UPDATE:
            raise PersonNeeded(f"the robot is being updated: wait until that has ended, {again}")
        busy = states.robot is RobotState.ENABLE and states.program in _BUSY
        if busy and not self._end_programs:
            raise RobotStateError(
                f"the controller is busy (program {states.program.name}): end the program at the "
                f"pendant, or call robot.stop() or robot.recover(), {again}"
            )


async def bring_up(supervisor: Supervisor, timeout: float) -> RecoverReport:
    """Bring the robot into a state in which it can move; `Robot.bring_up` describes it."""
    supervisor.check_open("bring_up")
    return await _go(supervisor, BringUp(), timeout)


async def recover(supervisor: Supervisor, timeout: float) -> RecoverReport:
    """Bring the robot out of a stop; `Robot.recover` describes it."""
    supervisor.check_open("recover")
    return await _go(supervisor, BringUp(end_programs=True, call="recover"), timeout)


async def _go(supervisor: Supervisor, decide: BringUp, timeout: float) -> RecoverReport:
    limit = SECONDS("timeout", timeout)
    gate = supervisor.gate
    permit = gate.present(decide.call)
    ticker = every(LOOK_EVERY)
    until = ticker.due + limit
    seen = "nothing was heard of it"
    async for due in ticker:
        if due >= until:
            break
        try:
            states = supervisor.samples.states(await supervisor.calls.rpc.get_robot_state())
            status = await supervisor.calls.rpc.getRobotStatus()
        except StaleState as exc:
            seen = str(exc)
        else:
            # who stops or pauses the robot does not expect that it is switched on after that
            if (ending := gate.ending(permit)) is not None and ending.stops:
                raise TaskStopped(
                    decide.call, None, f"was ended, since {ending.value}; no further step was sent"
                )
            seen = str(states)
            step = decide.next(
                states, emergency_stop=status.emcStopSignal, collision=status.collision
            )
            if step is BringUpStep.DONE:
                return RecoverReport(
                    states,
                    collision=decide.has_taken(BringUpStep.RESET_COLLISION),
                    stopped=decide.has_taken(BringUpStep.POWER_OFF),
                    sensor_tared=decide.has_taken(BringUpStep.POWER_OFF, BringUpStep.ENABLE),
                )
            if step is not BringUpStep.WAIT:
                stops = gate.stops
                await _carry_out(supervisor, step, states, until - time.monotonic(), decide.call)
                if step is BringUpStep.STOP and gate.stops == stops + 1:  # its own
                    permit = gate.present(decide.call)
                ticker.restart()
    raise RobotStateError(
        f"the robot is not ready after {timeout:g} s: {seen}; {await _errors(supervisor)}. Look at "
        "the pendant for what it waits for"
    )


async def _carry_out(
    supervisor: Supervisor, step: BringUpStep, states: RobotStates, left: float, call: str
) -> None:
    dispatcher, rpc = supervisor.dispatcher, supervisor.calls.rpc
    try:
        match step:
            case BringUpStep.RESET_COLLISION:
                await rpc.collision_detection_reset()
            case BringUpStep.STOP:
                await supervisor.stop_coordinator.stop()
            case BringUpStep.POWER_OFF | BringUpStep.POWER_ON | BringUpStep.ENABLE:
                await dispatcher.perform(step.name.lower(), (False,), max(left, 0.1))
    except TaskError as exc:
        # The whole error list: an entry from before this step may be the reason of the failure.
        raise RobotStateError(
            f"the controller did not {step.name.lower()} ({states}): {exc}; "
            f"{await _errors(supervisor)}. Is an emergency stop or a protective stop active? "
            f"Clear it, then call {call}() again"
        ) from exc


async def _errors(supervisor: Supervisor) -> str:
    try:
        errors = await supervisor.calls.rpc.get_last_error()
    except DucoError:
        return "its errors could not be read"
    return f"its errors: {'; '.join(errors)}" if errors else "it reports no errors"
