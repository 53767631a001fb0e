"""System control (系统控制, manual 1.3.2, and switch_mode of 1.3.7)."""

from __future__ import annotations

from typing import Final

from aioduco._wire.rpc import calls
from aioduco.api.section import Section, check_finished, checked_task_id
from aioduco.errors import ConnectError, ConnectionLost, RobotStateError, StaleState
from aioduco.models import ranges
from aioduco.models.enums import OperationMode, RobotState, TaskState
from aioduco.supervision.concurrency import every

#: how often a controller that starts anew is asked [s]
_LOOK_EVERY: Final = 0.1


class System(Section):
    """Power, brakes and the operation mode (系统控制, manual 1.3.2).

    Each function returns when the controller has finished. Cancelling its await cancels the
    waiting, not the controller's action. `Robot.bring_up` calls the functions that are needed
    before a motion, in the right order.
    """

    __slots__ = ()

    async def power_on(self, *, timeout: float = 30.0) -> None:
        """Power the arm up (机器人上电).

        Args:
            timeout: seconds within which the controller must have finished.

        Raises:
            TaskError: it was not done; TaskUnknown if it took too long.

        Manual section 1.3.2.
        """
        await self._perform(calls.power_on(False), timeout)

    async def power_off(self, *, timeout: float = 30.0) -> None:
        """Power the arm down (机器人下电); the brakes close.

        Args:
            timeout: seconds within which the controller must have finished.

        Raises:
            TaskError: it was not done; TaskUnknown if it took too long.

        Manual section 1.3.2.
        """
        await self._perform(calls.power_off(False), timeout)

    async def enable(self, *, timeout: float = 30.0) -> None:
        """Enable the joints (机器人上使能); the brakes open.

        Args:
            timeout: seconds within which the controller must have finished.

        Raises:
            TaskError: it was not done; TaskUnknown if it took too long.

        Manual section 1.3.2.
        """
        await self._perform(calls.enable(False), timeout)

    async def disable(self, *, timeout: float = 30.0) -> None:
        """Disable the joints (机器人下使能); the brakes close.

        Args:
            timeout: seconds within which the controller must have finished.

        Raises:
            TaskError: it was not done; TaskUnknown if it took too long.

        Manual section 1.3.2.
        """
        await self._perform(calls.disable(False), timeout)

    async def shutdown(self) -> None:
        """Switch the controller off (机器人关机). Every connection ends soon after.

        Raises:
            Refused: the controller refuses in its present state.
            OutcomeUnknown: the connection ended before the answer came.

        Manual section 1.3.2.
        """
        checked_task_id("shutdown", await self._rpc.shutdown(False))

    async def restart(self, *, timeout: float = 120.0) -> None:
        """Start the controller anew (机器人重启), and wait until it has started.

        Every connection ends meanwhile; this robot connects again. The arm has no power then.

        Args:
            timeout: seconds within which the controller must have started.

        Raises:
            ParameterError: the time is out of range; nothing was sent.
            Refused: the controller refuses in its present state.
            TaskError: it was not restarted.
            OutcomeUnknown: the connection ended before the answer came.
            RobotStateError: it has not started within `timeout`, or the robot was closed meanwhile.

        Manual section 1.3.2.
        """
        ticker = every(_LOOK_EVERY)
        until = ticker.due + ranges.TIMEOUT("timeout", timeout)
        id_ = checked_task_id("restart", await self._rpc.restart(False))
        rpc = self._supervisor.calls.rpc  # not retried: a lost connection says that it has begun
        begun = False
        async for due in ticker:
            if due >= until:
                break
            try:
                # an end state in place of an id is one of a controller that waited
                state = id_ if TaskState(id_).ended else await rpc.get_noneblock_taskstate(id_)
                robot = self._supervisor.samples.states(await rpc.get_robot_state()).robot
            except (ConnectError, ConnectionLost, StaleState):
                self._supervisor.check_open("get_robot_state")
                begun = True
                continue
            if not begun and TaskState(state).ended:
                check_finished("restart", state)
                begun = True
            if begun and robot not in (RobotState.START, RobotState.INITIALIZE):
                return
        raise RobotStateError(
            f"the controller was told to start anew, and has not started after {timeout:g} s; look "
            "at the pendant"
        )

    async def switch_mode(self, mode: OperationMode | int) -> None:
        """Switch between manual and automatic mode (手自动模式切换).

        This works only if the safety settings do not assign the mode to an input. A switch may
        leave the program paused; `Robot.stop` ends the pause.

        Args:
            mode: OperationMode.MANUAL (0) or OperationMode.AUTO (1).

        Raises:
            ParameterError: the mode is another one.
            TaskError, Refused: the controller did not switch.

        Manual section 1.3.7.
        """
        mode_ = ranges.SWITCH_MODE("mode", mode)
        await self._finish(calls.switch_mode(mode_))
