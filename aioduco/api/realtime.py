"""Realtime control (实时控制, manual 1.3.15), call by call."""

from __future__ import annotations

import contextlib
from typing import TYPE_CHECKING

from aioduco._wire.rpc import calls
from aioduco.api.section import Section, check_finished
from aioduco.api.streams.realtime import RealtimeStreams
from aioduco.errors import ParameterError, Refused, UnknownFunction
from aioduco.models import ranges
from aioduco.models.realtime import RealtimeMode, RealtimePoint
from aioduco.models.rules import listed
from aioduco.supervision.permits import asked_at_call

if TYPE_CHECKING:
    from collections.abc import Iterable

    from aioduco.models.rules import Real
    from aioduco.streaming.endpoint import StreamEndpoint
    from aioduco.supervision.supervisor import Supervisor


_ENDING, _EMPTYING = "end_realtime_mode", "clear_realtime_data_queue"


class Realtime(Section, RealtimeStreams):
    """Realtime control (实时控制, manual 1.3.15): the arm follows a queue, point by point.

    Programs normally use `stream`: it keeps the queue filled, at its rate, from a process of its
    own. The functions of the wire are available as well.

    The manual requires this order: empty the queue, put in the first points, the very first at the
    arm's position, start the mode, and put in more points before the queue is empty. The controller
    takes a point each cycle, so a program that calls function by function cannot keep up for long.

    While the mode is on, leaving the robot's block stops the arm, ends the mode and empties the
    queue; so does a stop.
    """

    def __init__(self, supervisor: Supervisor, endpoint: StreamEndpoint) -> None:
        Section.__init__(self, supervisor)
        RealtimeStreams.__init__(self, endpoint)

    @asked_at_call
    async def start_realtime_mode(
        self,
        mode: RealtimeMode | int,
        *,
        filter_bandwidth: Real = 100.0,
        com_lost_time: Real = 0.02,
    ) -> None:
        """Make the arm follow the queue (开启实时控制模式).

        Cancelling this stops the arm, and ends the mode.

        Args:
            mode: kind of the queue's points, a `RealtimeMode`: 0 joint positions, 1 joint
                velocities, 2 joint torques, 3 poses, 4 velocities of the tool.
            filter_bandwidth: bandwidth of the filter over the points, above 0 [Hz]. The wire
                spells it fileter_bandwidth.
            com_lost_time: time for which the queue may be empty before the controller stops the
                arm, above 0, up to 10 [s]. The arm follows the last point until then.

        Raises:
            ParameterError: an argument is out of range; nothing was sent.
            TaskError, Refused: the mode was not started.
            OutcomeUnknown: it was sent, but not answered; the arm was stopped.
            StopUnconfirmed: it is not known that the arm stands.

        Manual section 1.3.15.
        """
        mode_ = ranges.REALTIME_MODE("mode", mode)
        bandwidth = ranges.REALTIME_BANDWIDTH("filter_bandwidth", filter_bandwidth)
        lost = ranges.REALTIME_LOST_TIME("com_lost_time", com_lost_time)
        await self._enter(calls.start_realtime_mode(mode_, bandwidth, lost), _ENDING, ())

    async def end_realtime_mode(self) -> None:
        """End realtime control (结束实时控制模式), and wait until the arm stands.

        If this program has started it, the queue is emptied, too; if it cannot be ended in this
        way, or if this is cancelled, the arm is stopped as by `Robot.stop`.

        Raises:
            TaskError: the controller did not end it or empty the queue, or it was paused: the arm
                was stopped.
            StopUnconfirmed: it is not known that the arm stands.

        Manual section 1.3.15.
        """
        await self._end(_ENDING, self._end_mode)

    async def _end_mode(self) -> None:
        """Call what ends the mode, at once: the error list is not read first.

        Who starts the mode next would begin with what is left; another program's is left to it.
        """
        own = _ENDING in self._supervisor.stop_coordinator.modes
        check_finished(_ENDING, await self._rpc.end_realtime_mode())
        if own:
            with contextlib.suppress(UnknownFunction):  # older controllers have no such queue
                check_finished(_EMPTYING, await self._rpc.clear_realtime_data_queue())

    @asked_at_call
    async def realtime_data_enqueue(self, points: Iterable[RealtimePoint]) -> None:
        """Put points into the queue (实时数据入队).

        Cancelling this stops the arm, and ends the mode.

        Args:
            points: points made by the class methods of `RealtimePoint`, all for one mode; points
                for another mode than the one that is on have no effect.

        Raises:
            ParameterError: `points` is empty, or an element is not such a point, or is of another
                mode than the first; nothing was sent.
            Refused: the queue has no room for the points; `get_realtime_data_queue_size` returns
                how many wait.
            TaskError: the points were not put in.
            OutcomeUnknown: the answer was lost; the arm was stopped, and the mode ended.
            StopUnconfirmed: it is not known that the arm stands.
            EnvelopeViolated: joint positions are beyond a limit of `robot.envelope`, or the arm is
                that follows them; nothing was sent.

        Manual section 1.3.15.
        """
        expected = "a RealtimePoint, of the mode of the first one"
        given = listed("points", points, f"a list, each {expected}")
        if not given:
            raise ParameterError("points", given, "at least one point")
        for number, point in enumerate(given):
            if not isinstance(point, RealtimePoint) or point.mode is not given[0].mode:
                raise ParameterError(f"points[{number}]", point, expected)
        joints = [p.values for p in given if p.mode is RealtimeMode.JOINT_POSITION]
        moves = _ENDING in self._supervisor.stop_coordinator.modes
        call = calls.realtime_data_enqueue([point.wire() for point in given], True)
        self._supervisor.check_permitted(call.name)
        await self._supervisor.envelope.admit(call.name, joints, moves=moves)
        answer = await self._feed(call, _ENDING)
        if answer == -1:
            raise Refused(call.name, answer, "the realtime queue has no room for the points")
        check_finished(call.name, answer)

    async def clear_realtime_data_queue(self) -> None:
        """Empty the queue (清空实时数据队列).

        Raises:
            TaskError, Refused: it was not emptied.

        Manual section 1.3.15.
        """
        await self._finish(calls.clear_realtime_data_queue())

    async def get_realtime_data_queue_size(self) -> int:
        """Read how many points wait in the queue (实时队列数据数量). Manual section 1.3.15."""
        return await self._rpc.get_realtime_data_queue_size()
