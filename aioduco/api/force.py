"""Force control (力控函数, manual 1.3.10)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from aioduco._wire.rpc import calls
from aioduco.api.section import Section
from aioduco.errors import Refused, RobotStateError, TaskError, TaskUnknown, UnknownFunction
from aioduco.models import ranges
from aioduco.models.state import Vector, vector

if TYPE_CHECKING:
    from aioduco.models.force import ForceFrame, ForceLogic, GuardedForce
    from aioduco.models.rules import FlagsLike, Real, VectorLike, WholesLike
    from aioduco.supervision.command import MotionCommand


class Force(Section):
    """Force control (力控函数, manual 1.3.10): motions give way to the force at the tool.

        z = (False, False, True, False, False, False)
        await robot.force.fc_config(z, ref_ft=(0, 0, -10, 0, 0, 0), damp=damping, max_vel=slow)
        await robot.force.fc_start()
        await robot.force.fc_wait_ft(target, tolerance, absolute=True, duration=0.2, timeout=30)
        await robot.force.fc_wait_logic((0, 0, 1))
        await robot.force.fc_move()                # presses until the condition holds
        await robot.force.fc_stop()

    It needs a force sensor that is mounted, connected and set up: with a wrong setup the arm
    moves in an unforeseen way. Force control acts only while a motion runs, such as `fc_move`; a
    stop ends the motion, and the arm stands. Force control itself stays on until `fc_stop`: the
    next motion gives way, too. Leaving the robot's block ends it once the arm stands; if the
    program is killed, it stays on.

    Vectors have the components along x, y, z, then those about x, y, z. Shape (6,).
    """

    __slots__ = ()

    async def fc_start(self) -> None:
        """Start force control (开启机器人末端力控): motions give way from now on.

        Raises:
            TaskError: it was not started.

        Manual section 1.3.10.
        """
        modes = self._supervisor.stop_coordinator.modes
        # before the call is sent, since its answer may be lost
        was_on, modes.force_control = modes.force_control, True
        try:
            await self._carry_out(calls.fc_start())
        except (TaskError, Refused, UnknownFunction, RobotStateError) as exc:
            # an answer that is neither an end nor a refusal leaves it open
            code = exc.code if isinstance(exc, Refused) else -1
            unsure = isinstance(exc, TaskUnknown) or (isinstance(code, int) and code >= 0)
            if not unsure:
                modes.force_control = was_on
            raise

    async def fc_stop(self) -> None:
        """End force control (退出机器人末端力控).

        All motions must have ended, or the arm moves in an unforeseen way and stops with an
        alarm. So this is refused while the arm moves. Make sure that no other program moves it.

        Raises:
            RobotStateError: the arm moves; nothing was sent.
            TaskError: it was not ended.

        Manual section 1.3.10.
        """
        await self._carry_out_standing(calls.fc_stop())
        self._supervisor.stop_coordinator.modes.force_control = False

    async def fc_config(
        self,
        direction: FlagsLike,
        ref_ft: VectorLike,
        damp: VectorLike,
        max_vel: VectorLike,
        *,
        dead_band: VectorLike = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        tool: str = "",
        wobj: str = "",
        frame: ForceFrame | int = 0,
    ) -> None:
        """Set how motions give way (配置机器人末端力控参数).

        The speed at which the arm gives way is the difference between the force and `ref_ft`,
        divided by `damp`, and at most `max_vel`.

        Args:
            direction: whether the arm gives way in each direction. Shape (6,).
            ref_ft: force that the arm maintains, -1000 to 1000 [N, N·m]. Shape (6,).
            damp: damping, above 0 in directions that give way [N/(m/s), N·m/(rad/s)]; 1000 to
                2000 and 57 are usual. Shape (6,).
            max_vel: largest speed, -5 to 5 [m/s, rad/s]; 0.03 to 0.15 m/s are usual. Shape (6,).
            dead_band: force difference below which the arm does not give way, -1000 to 1000
                [N, N·m]. The manual calls it number_list. Shape (6,).
            tool: name of the tool about whose tip the arm gives way; empty for the one in use.
            wobj: name of the work object; empty for the one in use.
            frame: frame of the directions, a `ForceFrame`: 0 the tool's, 1 the work object's.
                The manual calls it type.

        Raises:
            ParameterError: an argument is out of range, or a direction that gives way has no
                damping; nothing was sent.
            TaskError: it was not set.

        Manual section 1.3.10.
        """
        on, by = ranges.damping(direction, damp)
        ft = ranges.WRENCH("ref_ft", ref_ft)
        fastest = ranges.FORCE_SPEED("max_vel", max_vel)
        band = ranges.FORCE_DEAD_BAND("dead_band", dead_band)
        tool_, wobj_ = ranges.FRAME("tool", tool), ranges.FRAME("wobj", wobj)
        frame_ = ranges.FORCE_FRAME("frame", frame)
        await self._carry_out(calls.fc_config(on, ft, by, fastest, band, tool_, wobj_, frame_))

    def fc_move(self) -> MotionCommand:
        """Move by force control alone (仅基于末端力控产生的补偿运动).

        It ends by itself only if a condition (`fc_wait_logic`) comes to hold.
        Cancelling its await stops the arm. On older controllers, whose fc_move always blocks, it
        is stopped as one that is not answered: there, call `robot.blocking.fc_move`.

        Returns:
            The motion, not sent yet.

        Manual section 1.3.10.
        """
        return self._motion(calls.fc_move(False))

    async def fc_guard_act(
        self,
        direction: FlagsLike,
        ref_ft: VectorLike,
        *,
        tool: str = "",
        wobj: str = "",
        frame: ForceFrame | int = 0,
        force_property: GuardedForce | int = 0,
    ) -> None:
        """Monitor the force in force control (力安全监控): too large a force is an emergency stop.

        Args:
            direction: whether the force is monitored in each direction. Shape (6,).
            ref_ft: largest allowed force in both senses, from 0 [N, N·m]. Shape (6,).
            tool: name of the tool; empty for the one in use.
            wobj: name of the work object; empty for the one in use.
            frame: frame of the directions, a `ForceFrame`: 0 the tool's, 1 the work object's.
                The manual calls it type.
            force_property: a `GuardedForce`: 0 load and external force, 1 external force alone.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError: the force is not monitored.

        Manual section 1.3.10.
        """
        on, ft = ranges.DIRECTIONS("direction", direction), ranges.GUARD_WRENCH("ref_ft", ref_ft)
        tool_, wobj_ = ranges.FRAME("tool", tool), ranges.FRAME("wobj", wobj)
        frame_ = ranges.FORCE_FRAME("frame", frame)
        property_ = ranges.FORCE_PROPERTY("force_property", force_property)
        await self._carry_out(calls.fc_guard_act(on, ft, tool_, wobj_, frame_, property_))

    async def fc_guard_deact(self) -> None:
        """End the monitoring of the force (禁用力安全监控).

        Raises:
            TaskError: the force is still monitored.

        Manual section 1.3.10.
        """
        await self._carry_out(calls.fc_guard_deact())

    async def fc_force_set_value(self, direction: FlagsLike, ref_ft: VectorLike) -> None:
        """Set the force sensor's present reading (力传感器读数设置为指定值), to tare it.

        Args:
            direction: whether the reading is set in each direction of the sensor. Shape (6,).
            ref_ft: the new reading [N, N·m]. Shape (6,).

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError: it was not set.

        Manual section 1.3.10.
        """
        on, ft = ranges.DIRECTIONS("direction", direction), ranges.SENSOR_WRENCH("ref_ft", ref_ft)
        await self._carry_out(calls.fc_force_set_value(on, ft))

    async def fc_wait_pos(
        self,
        middle: VectorLike,
        range: VectorLike,  # noqa: A002  # the manual's name
        *,
        absolute: bool,
        duration: Real,
        timeout: Real,
    ) -> None:
        """Set the condition on position (位置判断条件) under which motions end in force control.

        It returns at once. When the conditions, combined as `fc_wait_logic` says, hold, the
        running motion ends. Later motions are skipped until `fc_stop` or the next `fc_wait_logic`.

        Args:
            middle: middle of the range [m, rad]. Shape (6,).
            range: width of the range [m, rad], larger than the noise; 0 takes the axis out of the
                condition, so at least one is above 0. The manual does not say whether it is the
                half width, to each side of `middle`, or the full width. Shape (6,).
            absolute: true for the value itself, false for its change since the last
                `fc_wait_logic`.
            duration: time for which the condition must hold, from 0 [s].
            timeout: time after the last `fc_wait_logic` when the controller gives up, from 0 [s].

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError: it was not set.

        Manual section 1.3.10.
        """
        middle_ = ranges.WAIT_POSITION("middle", middle)
        range_ = ranges.wait_range(ranges.WAIT_POSITION_RANGE, range)
        when = _when(absolute=absolute, duration=duration, timeout=timeout)
        await self._carry_out(calls.fc_wait_pos(middle_, range_, *when))

    async def fc_wait_vel(
        self,
        middle: VectorLike,
        range: VectorLike,  # noqa: A002  # the manual's name
        *,
        absolute: bool,
        duration: Real,
        timeout: Real,
    ) -> None:
        """Set the condition on speed (速度判断条件) under which motions end in force control.

        It returns at once. When the conditions, combined as `fc_wait_logic` says, hold, the
        running motion ends. Later motions are skipped until `fc_stop` or the next `fc_wait_logic`.

        Args:
            middle: middle of the range, -5 to 5 and -2π to 2π [m/s, rad/s]. Shape (6,).
            range: width of the range [m/s, rad/s], larger than the noise; 0 takes the axis out of
                the condition, so at least one is above 0. The manual does not say whether it is
                the half width, to each side of `middle`, or the full width. Shape (6,).
            absolute: true for the value itself, false for its change since the last
                `fc_wait_logic`.
            duration: time for which the condition must hold, from 0 [s].
            timeout: time after the last `fc_wait_logic` when the controller gives up, from 0 [s].

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError: it was not set.

        Manual section 1.3.10.
        """
        middle_ = ranges.WAIT_VELOCITY("middle", middle)
        range_ = ranges.wait_range(ranges.WAIT_VELOCITY_RANGE, range)
        when = _when(absolute=absolute, duration=duration, timeout=timeout)
        await self._carry_out(calls.fc_wait_vel(middle_, range_, *when))

    async def fc_wait_ft(
        self,
        middle: VectorLike,
        range: VectorLike,  # noqa: A002  # the manual's name
        *,
        absolute: bool,
        duration: Real,
        timeout: Real,
    ) -> None:
        """Set the condition on force (力判断条件) under which motions end in force control.

        It returns at once. When the conditions, combined as `fc_wait_logic` says, hold, the
        running motion ends. Later motions are skipped until `fc_stop` or the next `fc_wait_logic`.

        Args:
            middle: middle of the range, -1000 to 1000 [N, N·m]. Shape (6,).
            range: width of the range [N, N·m], larger than the noise; 0 takes the axis out of the
                condition, so at least one is above 0. The manual does not say whether it is the
                half width, to each side of `middle`, or the full width. Shape (6,).
            absolute: true for the value itself, false for its change since the last
                `fc_wait_logic`.
            duration: time for which the condition must hold, from 0 [s].
            timeout: time after the last `fc_wait_logic` when the controller gives up, from 0 [s].

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError: it was not set.

        Manual section 1.3.10.
        """
        middle_ = ranges.WAIT_WRENCH("middle", middle)
        range_ = ranges.wait_range(ranges.WAIT_WRENCH_RANGE, range)
        when = _when(absolute=absolute, duration=duration, timeout=timeout)
        await self._carry_out(calls.fc_wait_ft(middle_, range_, *when))

    async def fc_wait_logic(self, logic: WholesLike | tuple[ForceLogic, ...]) -> None:
        """Combine the conditions, and restart them (条件判断间的逻辑关系).

        Args:
            logic: a `ForceLogic` each for position, speed and force: 0 off, 1 and, 2 or.
                Shape (3,).

        Raises:
            ParameterError: `logic` is something else; nothing was sent.
            TaskError: it was not set.

        Manual section 1.3.10.
        """
        logic_ = ranges.WAIT_LOGIC("logic", logic)
        await self._carry_out(calls.fc_wait_logic(logic_))

    async def fc_get_ft(self) -> Vector:
        """Read the force sensor (末端传感器的原始反馈读数), tared, in its own frame [N, N·m].

        A read-only array of shape (6,). The sensor is tared when the arm is enabled or disabled,
        and by `fc_force_set_value`. Manual section 1.3.10.
        """
        return vector(await self._rpc.fc_get_ft())

    async def fc_mode_is_active(self) -> bool:
        """Tell whether force control is on (末端力控功能启用状态). Manual section 1.3.10."""
        return await self._rpc.fc_mode_is_active()


def _when(*, absolute: bool, duration: Real, timeout: Real) -> tuple[bool, int, int]:
    """Check what the conditions have in common, and return it in the wire's order."""
    return (
        ranges.FLAG("absolute", absolute),
        ranges.WAIT_DURATION("duration", duration),
        ranges.WAIT_TIMEOUT("timeout", timeout),
    )
