"""Realtime control (manual 1.3.15)."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from aioduco.models.enums import SafetyState
from aioduco.models.realtime import RealtimeMode
from aioduco.sim.controller.motion_queue import Following
from aioduco.sim.handlers import arguments
from aioduco.sim.handlers.base import HandlerSection, task
from aioduco.sim.planner.realtime_follower import Follow, RealtimeCommand, RealtimeFollower
from aioduco.sim.planner.realtime_follower import mismatch as differs
from aioduco.sim.refusal import mismatch

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco._wire.rpc import RealTimeControlData
    from aioduco.models.rotation import Array
    from aioduco.sim.controller.state_machine import Controller


_KIND = "realtime control"
#: the manual's defaults, for a client that leaves the arguments out
_BANDWIDTH, _PATIENCE = 100.0, 0.02


class RealtimeHandlers(HandlerSection):
    """start_realtime_mode to get_realtime_data_queue_size."""

    @task()
    def start_realtime_mode(
        self, controller: Controller, mode: int, fileter_bandwidth: float, com_lost_time: float
    ) -> int | None:
        """Follow the queue, one point per cycle; the task is done as soon as that has begun."""
        if mode == RealtimeMode.JOINT_TORQUE:
            raise mismatch("mode is 2, joint torques, which the manual calls reserved")
        arguments.choice("mode", mode, tuple(Follow), "0, 1, 3 or 4")
        what = Follow(mode)
        bandwidth = arguments.positive(
            "fileter_bandwidth", fileter_bandwidth or _BANDWIDTH, 1e6, "Hz"
        )
        patience = arguments.positive("com_lost_time", com_lost_time or _PATIENCE, math.inf, "s")
        return self._start(controller, what, bandwidth, patience)

    def _start(
        self, controller: Controller, what: Follow, bandwidth: float, patience: float
    ) -> int | None:
        tool, wobj = self._frames.tool().matrix, self._frames.wobj().matrix

        def make(q: Array) -> RealtimeFollower:
            return RealtimeFollower(
                self._arm,
                q,
                self._cycle,
                controller.commands,
                what,
                bandwidth=bandwidth,
                patience=patience,
                tool=tool,
                wobj=wobj,
            )

        following = Following.once(_KIND, make)
        id_ = controller.follow("start_realtime_mode", following)
        if controller.tasks.state(id_).ended:
            return id_
        first = controller.commands.first()
        if first is not None:
            wrong = differs(self._arm, controller.motion.setpoint.q, first, what, tool, wobj)
            if wrong:
                controller.fault(SafetyState.STOP2, f"{_KIND}: {wrong}")
                return id_
        return None

    def end_realtime_mode(self) -> int:
        """Bring the arm to rest and leave the mode."""
        return self._task(
            "end_realtime_mode", True, lambda c: c.end_following("end_realtime_mode", _KIND)
        )

    def realtime_data_enqueue(
        self, realtime_data: Sequence[RealTimeControlData], block: bool
    ) -> int:
        """Put points into the queue: all of them, or none if they do not fit; then return -1."""

        def put(controller: Controller) -> bool:
            return controller.commands.put(_command(data) for data in realtime_data if data.status)

        return self._enqueue("realtime_data_enqueue", block, put)

    def clear_realtime_data_queue(self) -> int:
        """Empty the queue."""

        return self._task("clear_realtime_data_queue", True, lambda c: c.commands.clear())

    def get_realtime_data_queue_size(self) -> int:
        """Number of points in the queue."""
        with self._runtime.command() as controller:
            return len(controller.commands)


def _command(data: RealTimeControlData) -> RealtimeCommand:
    """Check a point: every value that it has must be valid, whatever the mode."""
    joints = data.joint_pos_cmd
    return RealtimeCommand(
        arguments.joints("joint_pos_cmd", joints) if joints else (),
        _six("joint_vel_cmd", data.joint_vel_cmd),
        arguments.pose("cart_pos_tool_wobj_cmd", data.cart_pos_tool_wobj_cmd).matrix
        if data.cart_pos_tool_wobj_cmd
        else None,
        _six("cart_vel_tool_wobj_cmd", data.cart_vel_tool_wobj_cmd),
    )


def _six(name: str, values: Sequence[float]) -> tuple[float, ...]:
    return arguments.numbers(name, values, 6) if values else ()
