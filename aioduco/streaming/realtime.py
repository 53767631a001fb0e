"""Streams through the controller's realtime queue (实时控制, manual 1.3.15)."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from aioduco.api import ranges
from aioduco.errors import ParameterError
from aioduco.models.realtime import RealtimeMode
from aioduco.streaming.settings import Endpoint, Feeding, LaneOptions, Upsampling, per_group
from aioduco.streaming.space import JOINT_SPACE, POSE_SPACE
from aioduco.streaming.stream import Stream

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from aioduco.models.rules import VectorLike
    from aioduco.streaming.space import Space

__all__ = ["CYCLE", "RealtimeStreams"]

#: time in which the controller takes one point from its queue [s] (manual 1.3.15, the example)
CYCLE = 0.001
_JERK = 10.0  # of the acceleration, per second
_Limit = float | tuple[float, float]

#: by mode: field of the point, space, whether set-points are speeds, where the arm is read, check
_MODES: dict[
    RealtimeMode, tuple[str, Space, bool, list[str], Callable[[str, VectorLike], list[float]]]
] = {
    RealtimeMode.JOINT_POSITION: (
        "joint_pos_cmd",
        JOINT_SPACE,
        False,
        ["get_actual_joints_position"],
        ranges.JOINTS,
    ),
    RealtimeMode.JOINT_VELOCITY: (
        "joint_vel_cmd",
        JOINT_SPACE,
        True,
        [],
        ranges.JOINT_VELOCITIES,
    ),
    RealtimeMode.POSE: (
        "cart_pos_tool_wobj_cmd",
        POSE_SPACE,
        False,
        ["get_tcp_pose_coord", "", ""],
        ranges.POSE,
    ),
    RealtimeMode.TWIST: ("cart_vel_tool_wobj_cmd", POSE_SPACE, True, [], ranges.TWIST),
}


class RealtimeStreams:
    """Streams through the queue from which the controller takes a point every millisecond.

        async with robot.realtime.stream("joint_position", v=1.0, a=5.0) as stream:
            await stream.play(trajectory, times)

    The lane keeps the controller's queue at a depth: it is what the network and this machine
    may be late without the arm noticing, and it is the latency of the stream.

    Args:
        endpoint: the controller.
    """

    def __init__(self, endpoint: Endpoint) -> None:
        self._endpoint = endpoint

    def stream(
        self,
        mode: RealtimeMode | str,
        *,
        v: _Limit,
        a: _Limit,
        jerk: _Limit | None = None,
        depth: int = 40,
        period: float = 0.004,
        filter_bandwidth: float = 100.0,
        com_lost_time: float = 0.02,
        source_rate: float | None = None,
        latest: bool = False,
        upsample: Upsampling = "none",
        hold: float | None = None,
        ahead: int | None = None,
        max_step: _Limit | None = None,
        reach: _Limit | None = None,
        options: LaneOptions | None = None,
    ) -> Stream:
        """Follow positions or speeds (start_realtime_mode, realtime_data_enqueue).

        Args:
            mode: "joint_position", "joint_velocity", "pose" or "twist". Torques are not
                streamed: manual 3.8 calls their field reserved, and no end of such a stream
                could be called safe.
            v: largest speed: of each joint [rad/s], or of the tool and its turning
                [m/s, rad/s].
            a: largest acceleration: of each joint [rad/s²], or of the tool [m/s², rad/s²].
            jerk: largest jerk, for upsample="ruckig"; None: 10 a.
            depth: points to keep in the controller's queue; each is one millisecond.
            period: time between two looks at the queue [s].
            filter_bandwidth: of the controller's filter of the points [Hz].
            com_lost_time: time with an empty queue after which the controller faults [s].
            source_rate: set-points per second from the program [Hz]; None: 1000, one for each
                millisecond.
            latest: only the newest set-point counts, and `send` never waits.
            upsample: "none", "linear", "cubic" or "ruckig".
            hold: time without a set-point after which the stream ends [s]; None: 0.5 for
                positions, 0.1 for speeds, which go on that long.
            ahead: set-points queued before `send` waits.
            max_step: largest step between two set-points [rad], or [m, rad].
            reach: how far the arm may be from the first set-point [rad], or [m, rad].
            options: how the lane runs; None: in a process of its own.

        Returns:
            The stream; its set-points are what the mode says.

        Raises:
            ParameterError: an argument is out of range.

        Manual section 1.3.15.
        """
        chosen = _mode(mode)
        field, space, rates, read, check = _MODES[chosen]
        groups = len(space.groups)
        hold_ = hold if hold is not None else 0.1 if rates else 0.5
        step, near = (0.2, 0.1) if groups == 6 else ((0.05, 0.2), (0.05, 0.1))
        feeding = Feeding(
            rate=1 / CYCLE,
            source_rate=source_rate,
            latest=latest,
            upsample=upsample,
            hold=hold_,
            ahead=ahead,
            max_step=() if rates else per_group("max_step", max_step or step, groups),
            reach=per_group("reach", reach or near, groups),
        )
        if not 2 <= depth <= 1000:
            raise ParameterError("depth", depth, "from 2 to 1000 points")
        if not CYCLE <= period <= depth * CYCLE / 2:
            raise ParameterError(
                "period", period, f"from {CYCLE:g} s to half of what {depth} points last"
            )
        return Stream(
            self._endpoint,
            feeding,
            options,
            space=space,
            check=check,
            config={
                "driver": "queue",
                "space": "joints" if space is JOINT_SPACE else "pose",
                "rates": rates,
                "offsets": False,
                "read": read,
                "leave": [],
                "ending": "end_realtime_mode",
                "limits": _limits(v, a, jerk, groups),
                "period": period,
                "point_period": CYCLE,
                "depth": depth,
                "field": field,
                "mode": [
                    int(chosen),
                    ranges.REALTIME_BANDWIDTH("filter_bandwidth", filter_bandwidth),
                    ranges.REALTIME_LOST_TIME("com_lost_time", com_lost_time),
                ],
            },
            name=f"realtime {chosen.name.lower()}",
        )


def _mode(mode: RealtimeMode | str | Any) -> RealtimeMode:
    names = {known.name.lower(): known for known in _MODES}
    chosen = names.get(mode) if isinstance(mode, str) else mode
    if chosen not in _MODES:
        raise ParameterError("mode", mode, f"one of {', '.join(names)}")
    return RealtimeMode(chosen)


def _limits(v: _Limit, a: _Limit, jerk: _Limit | None, groups: int) -> list[Sequence[float]]:
    top, change = per_group("v", v, groups), per_group("a", a, groups)
    jerks = tuple(_JERK * c for c in change) if jerk is None else per_group("jerk", jerk, groups)
    return [top, change, jerks]
