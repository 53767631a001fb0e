"""The weave that combined motion adds to a path (复合运动, manual 1.3.13)."""

from __future__ import annotations

from aioduco.models.named_int import NamedInt


class WeaveShape(NamedInt):
    """Shape of a weave (复合运动轨迹几何类型, manual 1.3.13).

    Manual 4.3 calls the first a sawtooth, and the third an arc.
    """

    TRIANGLE = 1
    SINE = 2
    CIRCLE = 3
    TRAPEZOID = 4
    FIGURE_EIGHT = 5


class WeavePlane(NamedInt):
    """Plane in which a weave lies (参考平面, manual 1.3.13)."""

    TOOL_XY = 0
    TOOL_XZ = 1
    TOOL_YZ = 2
    WORK_OBJECT_XY = 3
    WORK_OBJECT_XZ = 4
    WORK_OBJECT_YZ = 5
