"""The arguments of a function that moves the arm, by name."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from aioduco._wire.rpc import Op
    from aioduco.models.rotation import Array


#: names that functions with external axes have for the same arguments
_SAME: Final = {"rad": "r", "qnear": "q_near"}


class MotionCall:
    """The arguments of one call, by their names on the wire; each function has some of them.

    Attributes:
        points: positions on the path with the action at each, in order; what plans the motion
            fills it.
    """

    joints_list: Sequence[float]
    p: Sequence[float]
    p1: Sequence[float]
    p2: Sequence[float]
    pose_offset: Sequence[float]
    pose_list: Sequence[Any]
    q_near: Sequence[float]
    tool: str
    wobj: str
    v: float
    a: float
    r: float
    mode: int
    rev: float
    len: float
    kp: float
    kd: float
    smooth_vel: float
    smooth_acc: float
    scheme_name: Any
    epose: Any
    eaxis_v: Any
    block: bool
    op: Op
    def_acc: bool

    def __init__(self, names: Sequence[str], values: Sequence[Any]) -> None:
        self.points: list[tuple[Array, Callable[[], None]]] = []
        for name, value in zip(names, values, strict=True):
            setattr(self, _SAME.get(name, name), value)
