"""The configuration of a worker: plain values, stored as JSON in the shared block.

A stream's factory fills in `StreamSpec`; its caller gives the address, the feeding and the options.
"""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

from aioduco.streaming.shared.options import Feeding, WorkerOptions, without_checks
from aioduco.streaming.shared.space import JOINT_SPACE, POSE_SPACE, Limits, Space
from aioduco.streaming.shared.words import ActionTag

if TYPE_CHECKING:
    from collections.abc import Sequence


#: an envelope against which the worker checks set-points: the result of `Envelope.packed`, the pose
#: of their work object in the base frame [m, rad], and the time within which the program stops a
#: stream of speeds that comes to a limit [s]
CheckedEnvelope: TypeAlias = "tuple[dict[str, Any], Sequence[float], float]"
#: what a set-point is: a position, a speed that is kept, or a step from the last position
Meaning = Literal["place", "speed", "step"]


@dataclass(frozen=True, slots=True, kw_only=True)
class FrameRotation:
    """How directions are rotated from the program's frame into the frame of the wire.

    Attributes:
        reads: functions of the wire that read a pose, each with its arguments. The product of these
            poses is the pose of one frame in the other.
        back: whether to apply the inverse rotation: the product leads from the wire's frame to the
            program's.
    """

    reads: Sequence[Sequence[str]]
    back: bool = True


@dataclass(frozen=True, slots=True, kw_only=True)
class StreamSpec:
    """What a stream sends, and how.

    Attributes:
        name: name of the stream; of the kind "call" the function of the wire.
        in_joints: whether set-points are joints [rad]; else poses, twists or offsets [m, rad].
        limits: limits of each group, see `Limits`.
        kind: "call" for one call per tick, of servo and speed streams; "queue" for the realtime
            queue, which is kept full; "pool" for the track pool, kept between two marks; "probe"
            to send no set-point, and only read the controller's state.
        function: the function of the wire that starts the motion through the queue or the pool.
        arguments: its arguments; of the kind "call" those after the set-point.
        period: time between two polls of the queue or the pool [s]; 0: one call per tick.
        low: the worker fills the pool when it has fewer points than this.
        high: number of points to which the worker fills the queue or the pool.
        field: field of a queue point that carries the set-point.
        settling: points at the end of the queue that bring the arm to rest through the
            controller's filter.
        extra: bytes for the operation of a pool's point; 0: points have no operations.
        meaning: what a set-point is.
        tool: name of the tool whose poses, twists or offsets are sent; empty: the one in use.
        wobj: name of the work object of poses; empty: the one in use.
        leave: calls at the end of the stream, each a function and its arguments.
        ending: function of the wire that ends the controller's mode during the stream, or empties
            the track pool; it has no arguments.
        turning: how directions are rotated into the frame of the wire; None: they are in it.
    """

    name: str
    in_joints: bool
    limits: Limits
    kind: Literal["call", "queue", "pool", "probe"] = "call"
    function: str = ""
    arguments: Sequence[Any] = ()
    period: float = 0.0
    low: int = 0
    high: int = 0
    field: str = ""
    settling: int = 0
    extra: int = 0
    meaning: Meaning = "place"
    tool: str = ""
    wobj: str = ""
    leave: Sequence[Sequence[Any]] = ()
    ending: str = ""
    turning: FrameRotation | None = None

    @property
    def space(self) -> Space:
        """The space of the set-points."""
        return JOINT_SPACE if self.in_joints else POSE_SPACE

    @property
    def read(self) -> tuple[str, ...]:
        """The function of the wire that reads the arm's position, and its arguments."""
        if self.in_joints:
            return ("get_actual_joints_position",)
        return ("get_tcp_pose_coord", self.tool, self.wobj)


@dataclass(frozen=True, slots=True, kw_only=True)
class WorkerConfig:
    """The configuration of a worker.

    Attributes:
        host: name or address of the controller.
        port: its TCP port.
        guarded: whether a guard stops the robot when the program dies.
        stall_limit: time after which a program whose event loop does not run counts as hung [s].
        unanswered_timeout: longest wait for an unanswered set-point [s].
        options: how the worker runs.
        feeding: how the program feeds it.
        sent: what it sends.
        envelope: the envelope against which set-points are checked; None: no check.
    """

    host: str
    port: int
    guarded: bool
    stall_limit: float
    unanswered_timeout: float
    options: WorkerOptions
    feeding: Feeding
    sent: StreamSpec
    envelope: CheckedEnvelope | None = None

    @property
    def period(self) -> float:
        """Time between two ticks of the worker [s]."""
        return self.sent.period or 1 / self.feeding.rate

    @property
    def extra(self) -> int:
        """Bytes for the tag or the operation of a set-point."""
        return ActionTag.size() if self.feeding.chunks else self.sent.extra

    def pack(self) -> bytes:
        """Encode it for the shared block."""
        return json.dumps(asdict(self)).encode()

    @classmethod
    def unpack(cls, text: bytes) -> WorkerConfig:
        """Decode the result of `pack`."""
        values = json.loads(text)
        sent = values.pop("sent")
        sent["limits"] = Limits(*map(tuple, sent["limits"]))
        sent["turning"] = FrameRotation(**sent["turning"]) if sent["turning"] else None
        options = without_checks(WorkerOptions, values.pop("options"))
        feeding = without_checks(Feeding, values.pop("feeding"))
        return cls(**values, options=options, feeding=feeding, sent=StreamSpec(**sent))
