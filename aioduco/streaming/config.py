"""All that a lane is told: plain values, which stand as JSON in the shared block.

A stream's factory fills in `Sent`; where to, how it is fed and how it runs come from its caller.
"""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any, Literal

from aioduco.streaming.limits import Limits
from aioduco.streaming.settings import Feeding, LaneOptions
from aioduco.streaming.space import JOINT_SPACE, POSE_SPACE, Space

if TYPE_CHECKING:
    from collections.abc import Sequence

__all__ = ["Calls", "Drive", "LaneConfig", "Meaning", "Pool", "Queue", "Sent"]

#: what a set-point is: a place, a speed that is kept, or a step from where the last one led
Meaning = Literal["place", "speed", "step"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Calls:
    """One call per tick: servo and speeds.

    Attributes:
        function: the function of the wire.
        arguments: its arguments behind the set-point, which is the first.
    """

    function: str
    arguments: Sequence[Any]


@dataclass(frozen=True, slots=True, kw_only=True)
class Queue:
    """The realtime queue.

    Attributes:
        field: field of a point of the queue that carries the set-point.
        mode: arguments of start_realtime_mode.
        depth: points to keep in the queue.
        period: time between two looks at the queue [s].
    """

    field: str
    mode: Sequence[float]
    depth: int
    period: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Pool:
    """The track pool.

    Attributes:
        function: the function of the wire that follows the pool.
        arguments: its arguments.
        low: the pool is filled up when it has fewer points.
        high: it is filled up to so many.
        period: time between two looks at the pool [s].
        extra: bytes for what goes with a point; 0: points go alone.
    """

    function: str
    arguments: Sequence[Any]
    low: int
    high: int
    period: float
    extra: int = 0


Drive = Calls | Queue | Pool | None
_DRIVES: dict[str, type[Calls | Queue | Pool]] = {
    kind.__name__: kind for kind in (Calls, Queue, Pool)
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Sent:
    """What a stream sends, and how.

    Attributes:
        name: what the stream is called, mostly by its function of the wire.
        in_joints: whether set-points are joints [rad]; else poses, twists or offsets [m, rad].
        limits: of each group, see `Limits`.
        drive: how set-points are brought to the controller; None: not at all, it is only asked
            for its state.
        meaning: what a set-point is.
        read: function of the wire that reads where the arm is, and its arguments.
        leave: calls at the end of the stream: a function and its arguments each.
        ending: function of the wire that ends the mode in which the controller is meanwhile.
    """

    name: str
    in_joints: bool
    limits: Limits
    drive: Drive
    meaning: Meaning = "place"
    read: Sequence[str] = ()
    leave: Sequence[Sequence[Any]] = ()
    ending: str = ""

    @property
    def space(self) -> Space:
        """The space of the set-points."""
        return JOINT_SPACE if self.in_joints else POSE_SPACE

    @property
    def extra(self) -> int:
        """Bytes for what goes with a set-point."""
        return self.drive.extra if isinstance(self.drive, Pool) else 0


@dataclass(frozen=True, slots=True, kw_only=True)
class LaneConfig:
    """All that a lane is told.

    Attributes:
        host: name or address of the controller.
        port: its TCP port.
        guarded: whether the robot is stopped by others when the program dies.
        stall_limit: time after which a program whose event loop does not run counts as hung [s].
        options: how the lane runs.
        feeding: how it is fed.
        sent: what it sends.
    """

    host: str
    port: int
    guarded: bool
    stall_limit: float
    options: LaneOptions
    feeding: Feeding
    sent: Sent

    @property
    def period(self) -> float:
        """Time between two ticks of the lane [s]."""
        drive = self.sent.drive
        return drive.period if isinstance(drive, Queue | Pool) else 1 / self.feeding.rate

    def pack(self) -> bytes:
        """As it stands in the shared block."""
        drive = self.sent.drive
        return json.dumps([asdict(self), type(drive).__name__ if drive else ""]).encode()

    @classmethod
    def unpack(cls, text: bytes) -> LaneConfig:
        """What `pack` made."""
        values, kind = json.loads(text)
        sent = values.pop("sent")
        sent["limits"] = Limits(*map(tuple, sent["limits"]))
        sent["drive"] = _DRIVES[kind](**sent["drive"]) if kind else None
        options, feeding = LaneOptions(**values.pop("options")), Feeding(**values.pop("feeding"))
        return cls(**values, options=options, feeding=feeding, sent=Sent(**sent))
