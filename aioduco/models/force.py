"""Choices of force control (力控, manual 1.3.10)."""

from __future__ import annotations

from aioduco.models.named_int import NamedInt


class ForceFrame(NamedInt):
    """Frame of the directions of forces (末端力控参考坐标系, manual 1.3.10)."""

    TOOL = 0
    WORK_OBJECT = 1


class GuardedForce(NamedInt):
    """Which force is watched (监控力属性, manual 1.3.10)."""

    WITH_LOAD = 0
    EXTERNAL = 1


class ForceLogic(NamedInt):
    """How a condition is combined with the others (条件判断间的逻辑关系, manual 1.3.10)."""

    OFF = 0
    AND = 1
    OR = 2
