"""Streams through the controller's realtime queue (实时控制, manual 1.3.15)."""

from __future__ import annotations

import contextlib
import math
from typing import TYPE_CHECKING, Any, Unpack

from aioduco.api.streams import StreamMaker
from aioduco.api.streams.arguments import FeedingOptions, motion_limits, per_group
from aioduco.errors import ParameterError
from aioduco.models import ranges
from aioduco.models.realtime import RealtimeMode
from aioduco.models.rules import Choice, Integer, Real, VectorLike
from aioduco.models.words import one_of
from aioduco.streaming.shared.config import Meaning, StreamSpec
from aioduco.streaming.shared.options import Feeding, WorkerOptions
from aioduco.streaming.shared.turning import MotionFrame, into_wobj
from aioduco.streaming.stream import Stream

if TYPE_CHECKING:
    from collections.abc import Callable


#: time in which the controller takes one point from its queue [s] (manual 1.3.15, the example)
CYCLE = 0.001
#: time constants of the controller's filter in which the arm arrives: 5e-5 of its lag are left
_ARRIVES = 10
_LONGEST = 60.0  # s that it may take at the end
_DEPTH = Integer(2, 1000, "points", source="1.3.15")
_Limit = float | tuple[float, float]

#: by mode: field of the point, whether it is in joints, meaning, check
_MODES: dict[RealtimeMode, tuple[str, bool, Meaning, Callable[[str, VectorLike], list[float]]]] = {
    RealtimeMode.JOINT_POSITION: ("joint_pos_cmd", True, "place", ranges.JOINTS),
    RealtimeMode.JOINT_VELOCITY: ("joint_vel_cmd", True, "speed", ranges.JOINT_VELOCITIES),
    RealtimeMode.POSE: ("cart_pos_tool_wobj_cmd", False, "place", ranges.POSE),
    RealtimeMode.TWIST: ("cart_vel_tool_wobj_cmd", False, "speed", ranges.TWIST),
}


class RealtimeStreams(StreamMaker):
    """Streams through the queue, from which the controller takes one point per millisecond.

        async with robot.realtime.stream("joint_position", v=1.0, a=5.0) as stream:
            await stream.play(trajectory, times)

    The worker keeps the controller's queue at a depth. The depth is the time by which the network
    and this machine may be late without an effect on the arm, and it is the stream's latency.

    Args:
        endpoint: the controller.
    """

    def stream(
        self,
        mode: RealtimeMode | str,
        *,
        v: _Limit,
        a: _Limit,
        jerk: _Limit | None = None,
        frame: MotionFrame | None = None,
        depth: int = 40,
        period: float = 0.004,
        filter_bandwidth: Real = 100.0,
        com_lost_time: Real = 0.02,
        max_step: _Limit | None = None,
        reach: _Limit | None = None,
        options: WorkerOptions | None = None,
        **feeding: Unpack[FeedingOptions],
    ) -> Stream:
        """Follow positions or speeds (start_realtime_mode, realtime_data_enqueue).

        Args:
            mode: "joint_position", "joint_velocity", "pose" or "twist". Torques cannot be streamed:
                manual 3.8 calls their field reserved, and such a stream has no safe end.
            v: largest speed: of each joint [rad/s], or of the tool and its turning
                [m/s, rad/s].
            a: largest acceleration: of each joint [rad/s²], or of the tool [m/s², rad/s²].
            jerk: largest jerk, for upsample="ruckig"; None: 10 a.
            frame: only for "twist": the frame whose axes it refers to: "wobj", the work object in
                use, as the controller takes it; "base" (z is up if the arm stands on a floor); or
                "tool". None: "wobj". The worker rotates the twist when it fills the queue. The
                tool's orientation is then at most 10 ms old, and `depth` milliseconds older when
                the controller executes the twist.
            depth: points to keep in the controller's queue; each is one millisecond.
            period: time between two polls of the queue [s].
            filter_bandwidth: bandwidth of the controller's filter of the points, by which the arm
                lags behind them [Hz]. A stream that is left waits for it: 1.6 s at 1 Hz.
            com_lost_time: time with an empty queue after which the controller faults, up to 10 [s].
            max_step: only for positions: largest step between two set-points [rad], or [m, rad].
            reach: only for positions: largest distance of the arm from the first set-point [rad],
                or [m, rad].
            options: how the worker runs; None: in a separate process.
            feeding: how the program feeds it: `source_rate`, set-points per second [Hz], by default
                1000, or measured with `latest`; `latest`, `ahead`, and for positions `upsample`, as
                for `robot.servo`;
                `hold`, time without a set-point after which the stream ends [s], 0.5 for positions
                and 0.1 for speeds, which continue for that time.

        Returns:
            The stream; its set-points are those of the mode.

        Raises:
            ParameterError: an argument is out of range.

        Manual section 1.3.15.
        """
        chosen = _mode(mode)
        field, in_joints, meaning, check = _MODES[chosen]
        speeds = meaning == "speed"
        groups = 6 if in_joints else 2
        step, near = (0.2, 0.1) if in_joints else ((0.05, 0.2), (0.05, 0.1))
        if "rate" in feeding:
            expected = "left out: the controller takes a point each millisecond; give source_rate"
            raise ParameterError("rate", {**feeding}["rate"], expected)
        feeding.setdefault("hold", 0.1 if speeds else 0.5)
        fed = Feeding(
            **feeding,
            rate=1 / CYCLE,
            max_step=()
            if speeds
            else per_group("max_step", step if max_step is None else max_step, groups),
            reach=per_group("reach", near if reach is None else reach, groups),
        )
        for name, given in (("max_step", max_step), ("reach", reach)):
            if speeds and given is not None:
                raise ParameterError(name, given, "left out: it is for positions alone")
        depth = _DEPTH("depth", depth)
        if frame is not None and chosen is not RealtimeMode.TWIST:
            raise ParameterError("frame", frame, 'left out: it is for mode="twist" alone')
        period = ranges.TIMEOUT("period", period)
        if not CYCLE <= period <= depth * CYCLE / 2:
            raise ParameterError(
                "period", period, f"from {CYCLE:g} s to half of what {depth} points last"
            )
        bandwidth = ranges.REALTIME_BANDWIDTH("filter_bandwidth", filter_bandwidth)
        arguments = [
            int(chosen),
            bandwidth,
            ranges.REALTIME_LOST_TIME("com_lost_time", com_lost_time),
        ]
        sent = StreamSpec(
            name=f"realtime {chosen.name.lower()}",
            in_joints=in_joints,
            limits=motion_limits(v, a, jerk, groups),
            kind="queue",
            function="start_realtime_mode",
            arguments=arguments,
            field=field,
            settling=math.ceil(min(_ARRIVES / (2 * math.pi * bandwidth), _LONGEST) / CYCLE),
            high=depth,
            period=period,
            meaning=meaning,
            ending="end_realtime_mode",
            turning=None if frame is None else into_wobj(frame),
        )
        return Stream(self._endpoint, fed, options, sent, check)


_MODE = Choice({int(each): each.name for each in _MODES}, source="this package")


def _mode(mode: Any) -> RealtimeMode:
    names = {known.name.lower(): known for known in _MODES}
    with contextlib.suppress(ParameterError):
        return RealtimeMode(_MODE("mode", mode))
    # torques are refused, too: they would not hold the arm
    return names[one_of("mode", mode, names)]
