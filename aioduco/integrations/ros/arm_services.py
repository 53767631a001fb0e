"""Services of an arm, for any middleware: none of them raises. All but one are coroutines."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, NoReturn

from aioduco import Joints, Pose, ProgramState
from aioduco.errors import DucoError
from aioduco.integrations.ros.trajectory_goals import said

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Sequence

    from anyio.from_thread import BlockingPortal

    from aioduco import Robot
    from aioduco.integrations.ros.trajectory_server import TrajectoryServer


_DIGITAL, _ANALOG = 1, 3  # functions of the UR driver's set_io
_TOOL_PIN = 16  # number of the tool's first output there
_DAMPING = (1500.0,) * 3 + (57.0,) * 3  # usual by the manual's section 1.3.10
_FORCE_SPEED = (0.05,) * 3 + (0.2,) * 3


class ServiceReply(NamedTuple):
    """Reply of a service.

    Attributes:
        success: whether the request succeeded.
        message: the result, or the reason for the failure.
    """

    success: bool
    message: str


class ArmServices:
    """Services of one arm. The called functions check the numbers.

    Args:
        robot: the robot, open.
        goals: trajectory goals of the arm.
        recovered: called when the arm was brought up or recovered, and not stopped meanwhile.
        halted: called before the arm is stopped or paused.
        twisting: returns whether speeds of the tool are followed, along axes of the tool in use.
        streaming: returns whether these or joint commands are followed.
    """

    def __init__(
        self,
        robot: Robot,
        goals: TrajectoryServer,
        *,
        recovered: Callable[[], None],
        halted: Callable[[], None],
        twisting: Callable[[], bool],
        streaming: Callable[[], bool],
    ) -> None:
        self._robot = robot
        self._goals = goals
        self._recovered = recovered
        self._tell_halted = halted
        self._twisting = twisting
        self._streaming = streaming
        self._halts = 0  # stops and pauses so far
        self._program = ""  # the program that `play` runs
        self._force_mode = False

    async def bring_up(self) -> ServiceReply:
        """Power on, enable and clear, so that the arm can move."""
        return await self._recovering(self._robot.bring_up())

    async def power_on(self) -> ServiceReply:
        """Power the arm on; its brakes stay closed until it is enabled."""
        return await _answered(self._robot.system.power_on(), "powered on")

    async def power_off(self) -> ServiceReply:
        """Power the arm off. It must not be carrying out a goal."""
        return await self._unless_busy(self._robot.system.power_off, "powered off")

    async def enable(self) -> ServiceReply:
        """Enable the arm, which releases its brakes."""
        return await _answered(self._robot.system.enable(), "enabled")

    async def disable(self) -> ServiceReply:
        """Disable the arm, which closes its brakes. It must not be carrying out a goal."""
        return await self._unless_busy(self._robot.system.disable, "disabled")

    async def recover(self) -> ServiceReply:
        """Recover the arm from a stop; a goal that waits or is paused ends."""
        self._goals.stopped()
        return await self._recovering(self._robot.recover())

    async def stop(self) -> ServiceReply:
        """Stop the arm, and wait until it stands. A running goal is aborted."""
        self._goals.stopped()
        self._halted()
        return await _answered(self._robot.stop(), "the arm stands")

    def stop_now(self, portal: BlockingPortal) -> ServiceReply:
        """Stop the arm from a thread: the stop needs no event loop, and nothing delays it.

        Args:
            portal: portal to the event loop, on which this waits until the arm stands.
        """
        try:
            self._robot.stop_now()
        except DucoError as error:
            return ServiceReply(False, said(error))
        try:
            return portal.call(self.stop)
        except RuntimeError:
            return ServiceReply(True, "the stop was accepted; the driver ends")

    async def pause(self) -> ServiceReply:
        """Pause a trajectory goal, or a movej or movel."""
        self._halted()
        if not self._goals.following:  # a goal that waits for its stamp leaves the arm to others
            try:
                if await self._robot.pause():
                    return ServiceReply(True, "paused")
            except DucoError as error:
                return ServiceReply(False, said(error))
            if not self._goals.busy:
                return ServiceReply(True, "the arm stands; there was no motion to pause")
        paused = await self._goals.pause()
        text = "the goal is paused" if paused else "the goal has ended, or goes on again"
        return ServiceReply(paused, text)

    async def resume(self) -> ServiceReply:
        """Go on with what was paused."""
        if self._goals.resume():
            return ServiceReply(True, "the goal goes on")
        return await _answered(self._resumed())

    async def _resumed(self) -> str:
        if not await self._robot.resume():
            raise DucoError("nothing was paused")
        return "resumed"

    async def set_digital_output(self, num: int, value: bool) -> ServiceReply:
        """Set an output of the cabinet, 1 to 16."""
        return await _answered(self._robot.io.set_standard_digital_out(num, value), "set")

    async def set_tool_output(self, num: int, value: bool) -> ServiceReply:
        """Set an output at the tool, 1 or 2."""
        return await _answered(self._robot.io.set_tool_digital_out(num, value), "set")

    async def set_analog_output(self, num: int, value: float, current: bool) -> ServiceReply:
        """Set an analog output of the cabinet, 1 to 4: 0 to 10 V, or 4 to 20 mA."""
        io = self._robot.io
        change = (
            io.set_standard_analog_current_out if current else io.set_standard_analog_voltage_out
        )
        return await _answered(change(num, value), "set")

    async def set_io(self, fun: int, pin: int, state: float) -> ServiceReply:
        """Set an output by the numbers of the UR driver.

        Args:
            fun: 1 for a digital output, 3 for a voltage.
            pin: from 0; digital outputs 16 and 17 are the tool's.
            state: 0 or 1, or the voltage [V].
        """
        if fun == _ANALOG:
            return await self.set_analog_output(pin + 1, state, current=False)
        if fun != _DIGITAL or state not in (0.0, 1.0):
            return ServiceReply(
                False, f"fun {fun} with state {state:g}: 1 with 0 or 1, or 3; nothing was sent"
            )
        if pin >= _TOOL_PIN:
            return await self.set_tool_output(pin - _TOOL_PIN + 1, bool(state))
        return await self.set_digital_output(pin + 1, bool(state))

    async def zero_sensor(self) -> ServiceReply:
        """Set the present reading of the force sensor to zero."""
        tare = self._robot.force.fc_force_set_value((True,) * 6, (0.0,) * 6)
        return await _answered(tare, "the sensor reads zero here")

    async def start_force_mode(
        self,
        selection: Sequence[bool],
        wrench: Sequence[float],
        damping: Sequence[float],
        speed_limits: Sequence[float],
        frame: int,
    ) -> ServiceReply:
        """Let the arm give way to the force at the tool, until `stop_force_mode`.

        No goal, joint command or twist must be followed.

        Args:
            selection: whether the arm gives way in each direction. Shape (6,).
            wrench: force that the arm applies to what is around it, as of UR's service; the sensor
                reads the opposite [N, N·m]. Shape (6,).
            damping: damping; all 0: 1500 and 57 [N/(m/s), N·m/(rad/s)]. Shape (6,).
            speed_limits: largest speeds; all 0: 0.05 and 0.2 [m/s, rad/s]. Shape (6,).
            frame: 0: the tool's, 1: the work object's.
        """

        async def run() -> None:
            force, halts = self._robot.force, self._halts
            with self._robot.permit("start_force_mode"):
                await force.fc_config(
                    selection,
                    [-each for each in wrench],
                    damping if any(damping) else _DAMPING,
                    speed_limits if any(speed_limits) else _FORCE_SPEED,
                    frame=frame,
                )
                self._force_mode = True  # also if it is not known whether it begins
                try:
                    await force.fc_start()
                    self._require_no_halt(halts, "fc_move")
                    await force.fc_move().start()
                except DucoError as error:
                    await self._end_force_control(error)

        return _STREAM if self._streaming() else await self._unless_busy(run, "the arm gives way")

    async def _end_force_control(self, error: DucoError) -> NoReturn:
        """End force control in which the arm was not moved: it would yield in its next motion."""
        try:
            await self._robot.force.fc_stop()
        except DucoError:
            raise DucoError(f"{error}. Force control may be on: call stop_force_mode") from error
        self._force_mode = False
        raise DucoError(f"{error}. Force control was ended") from error

    async def stop_force_mode(self) -> ServiceReply:
        """End force mode, also that of a driver before this one, once the arm stands."""

        async def run() -> None:
            if not (self._force_mode or await self._robot.force.fc_mode_is_active()):
                raise DucoError("force mode is off; nothing was sent")
            await self._robot.stop()
            await self._robot.force.fc_stop()
            self._force_mode = False

        return await _answered(run(), "force mode has ended")

    async def load_program(self, name: str) -> ServiceReply:
        """Choose the stored program that `play` runs; the controller is not asked for it."""
        if not name:
            return ServiceReply(False, "the name is empty; nothing was changed")
        self._program = name
        return ServiceReply(True, f"loaded: {name}")

    async def loaded_program(self) -> ServiceReply:
        """The name of the program that `play` runs."""
        return ServiceReply(bool(self._program), self._program or "no program is loaded")

    async def play(self) -> ServiceReply:
        """Run the loaded program, or go on with what was paused."""
        if self._goals.busy:
            return await self.resume()

        async def run() -> str:
            halts = self._halts
            with self._robot.permit("play"):
                states = await self._robot.state.get_robot_state()
                self._require_no_halt(halts, "play")
                if states.program is ProgramState.PAUSED:
                    return await self._resumed()
                if not self._program:
                    raise DucoError(
                        "no program is loaded: call load_program first; nothing was sent"
                    )
                await self._robot.program.run_program(self._program).start(on_cancel="stop")
                return f"running: {self._program}"

        return await _answered(run())

    async def popup(self, text: str) -> ServiceReply:
        """Show a message on the pendant; the controller pauses all tasks then."""
        return await self._unless_busy(lambda: self._robot.log.log_error(text), "shown")

    async def add_to_log(self, text: str) -> ServiceReply:
        """Write a message into the controller's log."""
        return await _answered(self._robot.log.log_info(text), "written")

    async def robot_mode(self) -> ServiceReply:
        """The robot's state, by its name."""
        return await self._named("robot")

    async def safety_mode(self) -> ServiceReply:
        """The safety controller's state, by its name."""
        return await self._named("safety")

    async def program_state(self) -> ServiceReply:
        """The program's state, by its name."""
        return await self._named("program")

    def _require_no_halt(self, before: int, name: str) -> None:
        """Check that the arm was not halted since: a pause of a standing arm pauses nothing."""
        if self._halts != before:
            raise DucoError(f"{name} was not sent, since the arm was stopped or paused")

    def _halted(self) -> None:
        self._halts += 1
        self._tell_halted()

    async def _recovering(self, step: Awaitable[object]) -> ServiceReply:
        before = self._halts
        reply = await _answered(step)
        if reply.success and self._halts == before:
            self._recovered()
        return reply

    async def _named(self, state: str) -> ServiceReply:
        async def run() -> str:
            return str(getattr(await self._robot.state.get_robot_state(), state).name)

        return await _answered(run())

    async def _unless_busy(self, step: Callable[[], Awaitable[object]], text: str) -> ServiceReply:
        return _BUSY if self._goals.busy else await _answered(step(), text)

    async def set_speed(self, percent: float) -> ServiceReply:
        """Set the global speed, which scales motions and goals: 1 to 100 percent."""
        reply = await _answered(self._robot.settings.speed(percent), "set")
        if reply.success:
            self._goals.scale(percent / 100.0)
        return reply

    async def set_speed_fraction(self, fraction: float) -> ServiceReply:
        """Set the global speed as a share: 0.01 to 1."""
        return await self.set_speed(100.0 * fraction)

    async def set_tool(
        self, name: str, offset: Sequence[float], mass: float, centre: Sequence[float]
    ) -> ServiceReply:
        """Define a tool and use it. No goal or twist must be followed.

        Args:
            name: name of the tool.
            offset: pose of its tip in the flange's frame (x, y, z [m], rx, ry, rz [rad]).
            mass: mass of the tool [kg].
            centre: centre of mass of the tool in the flange's frame [m], three.
        """

        async def run() -> None:
            tip = Pose.of(list(offset))
            await self._robot.frames.set_tool_data(name, tip, (mass, *centre))

        return _TWISTS if self._twisting() else await self._unless_busy(run, "set")

    async def set_load(self, mass: float, centre: Sequence[float]) -> ServiceReply:
        """Set the load that the tool holds.

        Args:
            mass: its mass, without the tool's [kg].
            centre: its centre of mass in the tool's frame [m], three.
        """
        return await _answered(self._robot.frames.set_load_data((mass, *centre)), "set")

    async def movej(self, joints: Sequence[float], v: float, a: float) -> ServiceReply:
        """Move to joint angles, and wait for the end.

        Args:
            joints: target [rad]. Shape (6,).
            v: highest joint speed [rad/s].
            a: highest joint acceleration [rad/s²].
        """

        async def run() -> None:
            await self._robot.motion.movej2(Joints.of(list(joints)), v, a)

        return await self._unless_busy(run, "the arm is there")

    async def movel(
        self, pose: Sequence[float], v: float, a: float, tool: str = "", wobj: str = ""
    ) -> ServiceReply:
        """Move the tool along a line, and wait for the end.

        Args:
            pose: target (x, y, z [m], rx, ry, rz [rad]).
            v: highest speed [m/s].
            a: highest acceleration [m/s²].
            tool: name of the tool; empty: the one in use.
            wobj: name of the work object; empty: the one in use.
        """

        async def run() -> None:
            await self._robot.motion.movel(Pose.of(list(pose)), v, a, tool=tool, wobj=wobj)

        return await self._unless_busy(run, "the arm is there")


_BUSY = ServiceReply(False, "a trajectory goal is carried out; nothing was sent: cancel it first")
_STREAM = ServiceReply(False, "joint commands or twists are followed; nothing was sent")
_TWISTS = ServiceReply(False, "twists are followed along the tool's axes; nothing was sent")


async def _answered(step: Awaitable[object], text: str = "") -> ServiceReply:
    """Await a step, and return its result as a reply."""
    try:
        outcome = await step
    except (DucoError, TypeError, ValueError, TimeoutError) as error:
        return ServiceReply(False, said(error))
    return ServiceReply(True, text or said(outcome))
