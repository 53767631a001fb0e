"""`aioduco teleop`: a keyboard, a gamepad or a SpaceMouse leads the arm."""

from __future__ import annotations

import enum
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path  # noqa: TC003 - typer evaluates the annotations
from typing import TYPE_CHECKING, Annotated

import typer

from aioduco.cli import extras
from aioduco.cli.addresses import CellFile, HostOrSimulator, Port, robot_at
from aioduco.cli.exit_codes import ended_by_errors
from aioduco.cli.move import ready_arm
from aioduco.cli.options import Yes, refuse_unused, require_writable, wrong_option
from aioduco.cli.output import say
from aioduco.cli.questions import SAFE, ask
from aioduco.cli.sessions import control_session, require_same_state

if TYPE_CHECKING:
    from aioduco.devices.teleoperation import InputDevice, TeleopScale
    from aioduco.sync import Robot


class DeviceName(enum.StrEnum):
    """Device that leads the arm."""

    KEYBOARD = "keyboard"
    GAMEPAD = "gamepad"
    SPACEMOUSE = "spacemouse"


class TeleopFrame(enum.StrEnum):
    """The frame along whose axes the tool moves."""

    BASE = "base"
    TOOL = "tool"
    WOBJ = "wobj"


_HELP = {
    DeviceName.KEYBOARD: "hold w s a d r f to move along x, y, z, j l i k u o to turn; q ends",
    DeviceName.GAMEPAD: "hold a shoulder button; the left stick is x and y, the right one z; "
    "Start ends",
    DeviceName.SPACEMOUSE: "push the cap; Ctrl-C ends",
}


def teleop(
    context: typer.Context,
    host: HostOrSimulator = None,
    port: Port = None,
    cell: CellFile = None,
    device: DeviceName = DeviceName.KEYBOARD,
    path: str | None = None,
    frame: TeleopFrame = TeleopFrame.BASE,
    wobj: str = "",
    joints: bool = False,
    speed: Annotated[float, typer.Option(min=0.0001, max=1.0)] = 0.05,
    turn_speed: Annotated[float, typer.Option(min=0.001, max=3.0)] = 0.2,
    joint_speed: Annotated[float, typer.Option(min=0.001, max=3.0)] = 0.1,
    record: Path | None = None,
    yes: Yes = False,
) -> None:
    """Move an arm by keys, a gamepad or a SpaceMouse, as long as they are held. It asks first.

    The arm comes to rest when the key, button or cap is released, or the device is disconnected.

    aioduco teleop 192.168.1.10 --speed 0.02

    aioduco teleop left --device gamepad --frame tool --record run.mcap

    Exit codes: 0 it was ended; 1 something went wrong; 2 wrong options; 3 not confirmed; 4 it is
    not known that the arm stands; 130, 143 Ctrl-C or SIGTERM: the arm was stopped.

    Args:
        device: Input device that moves the arm.
        path: The device's file, such as /dev/input/js0.
        frame: Frame along whose axes the tool moves.
        wobj: Name of the work object. Default: the one in use.
        joints: Turn the joints instead.
        speed: Speed of the tool [m/s].
        turn_speed: Turning speed of the tool [rad/s].
        joint_speed: Speed of each joint, with --joints [rad/s].
        record: Record the arm to this file, for `aioduco play`.
    """
    if host is None:
        refuse_unused(context, "HOST: without it, a simulated arm is led", "port", "cell")
    if device is DeviceName.KEYBOARD:
        refuse_unused(context, "a gamepad or a SpaceMouse", "path")
    if joints:
        refuse_unused(context, "the tool", "frame", "wobj", "speed", "turn_speed")
    else:
        refuse_unused(context, "--joints", "joint_speed")
    if frame is not TeleopFrame.WOBJ:
        refuse_unused(context, "--frame wobj", "wobj")
    require_writable("--record", record)
    extras.need(*(() if record is None else ("record",)), *(("sim",) if host is None else ()))
    from aioduco.devices.teleoperation import TeleopScale, open_device  # noqa: PLC0415

    scale = TeleopScale(speed=speed, turn_speed=turn_speed, joint_speed=joint_speed)
    with wrong_option():
        opened = open_device(device.value, path)
        if device is not DeviceName.KEYBOARD:  # the terminal is needed for the question
            with opened:
                pass  # it is there, and may be read
    task = _Leading(opened, device, scale, frame, wobj, joints, record)
    if host is None:
        task.simulate()
        return
    address = robot_at(host, port, cell)
    found = ready_arm(address)
    how = f"joints turn at up to {joint_speed:g} rad/s" if joints else (
        f"the tool moves at up to {speed:g} m/s and turns at up to {turn_speed:g} rad/s, "
        f"by the axes of the {frame.value}"
    )  # fmt: skip
    ask(f"arm    {address}\nBy the {device.value}, {how}.\n{SAFE}", "Lead the arm?", yes=yes)
    with control_session(address) as robot:
        require_same_state(robot, found["robot"], found["safety"])
        task.lead(robot)


@dataclass(frozen=True, slots=True)
class _Leading:
    """One device that leads one robot."""

    device: InputDevice
    kind: DeviceName
    scale: TeleopScale
    frame: TeleopFrame
    wobj: str
    joints: bool
    record: Path | None

    def simulate(self) -> None:
        """Lead a simulated arm."""
        import aioduco.sync  # noqa: PLC0415
        from aioduco.sim import Simulator  # noqa: PLC0415 - it loads MuJoCo

        with (
            ended_by_errors("interrupted: the arm was stopped, and stands"),
            Simulator.spawn() as sim,
            aioduco.sync.connect(sim.host, sim.port) as robot,
        ):
            robot.bring_up()
            self.lead(robot)

    def lead(self, robot: Robot) -> None:
        """Lead an arm that is ready, and print a summary."""
        import aioduco.sync  # noqa: PLC0415

        recording = None if self.record is None else robot.record(self.record)
        with recording or nullcontext(), self.device as device:
            say(_HELP[self.kind])
            report = aioduco.sync.teleoperate(
                robot,
                device,
                self.scale,
                frame=self.frame.value,
                wobj=self.wobj,
                joints=self.joints,
            )
        kept = "" if recording is None else f"; recorded to {recording.path}"
        say(f"led {report.held} times, for {report.seconds:.1f} s in all{kept}")
