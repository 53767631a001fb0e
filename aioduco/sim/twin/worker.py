"""The twin in a process of its own: reads samples and commands, and sends what has parted."""

from __future__ import annotations

import contextlib
import time
from typing import TYPE_CHECKING, Any, NamedTuple

from aioduco._process.linked_process import ValueChannel
from aioduco.kinematics import arm
from aioduco.sim.twin.data import Divergence, TwinCommand, TwinSample
from aioduco.sim.twin.monitor import TwinFigures, TwinMonitor
from aioduco.sim.twin.predictor import Timeline

if TYPE_CHECKING:
    from aioduco.models.pose import Pose
    from aioduco.sim.twin.limits import TwinLimits


#: interval at which figures are sent when nothing has parted [s of the samples]
_FIGURES_EVERY = 0.1


class Begin(NamedTuple):
    """What a twin begins with: the arguments of `TwinMonitor`, and settings of the controller.

    Attributes:
        model: the arm.
        limits: the limits.
        tool: tip of the tool in the flange's frame.
        mounting: pose of the base in the world.
        commands: whether the program's commands are known.
        settings: calls that set the tool, the work object, the load and the speed as the controller
            has them.
    """

    model: str
    limits: TwinLimits
    tool: Pose | None
    mounting: Pose | None
    commands: bool
    settings: tuple[tuple[str, tuple[Any, ...]], ...]


class TwinUpdate(NamedTuple):
    """What a twin sends.

    Attributes:
        at: time of the sample [s].
        figures: the present differences.
        joints: where the arm should be [rad].
        divergences: what has parted.
        busy: processor time of this process [s].
    """

    at: float
    figures: TwinFigures
    joints: tuple[float, ...]
    divergences: tuple[Divergence, ...]
    busy: float


def main(arguments: list[str]) -> int:
    """Watch for the program that started this process, until its channel closes."""
    channel = ValueChannel.of(arguments)
    with contextlib.suppress(EOFError, ConnectionError):  # the program has ended meanwhile
        _serve(channel)
    return 0


def _serve(channel: ValueChannel) -> None:
    begin: Begin = channel.receive()
    monitor = TwinMonitor(
        arm(begin.model),
        begin.limits,
        tool=begin.tool,
        mounting=begin.mounting,
        commands=begin.commands,
    )
    for function, values in begin.settings:
        monitor.command(TwinCommand(0.0, function, values, True))
    channel.send(None)  # it is ready
    line, told = Timeline(), 0.0
    while True:
        for item in channel.receive():
            line.put(item)
        for item in line.due():
            if not isinstance(item, TwinSample):
                monitor.command(item)
                continue
            found = monitor.sample(item)
            if found or not told <= item.time < told + _FIGURES_EVERY:
                told = item.time
                busy = time.process_time()
                channel.send(TwinUpdate(told, monitor.figures, monitor.joints, tuple(found), busy))
