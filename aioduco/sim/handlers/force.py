"""Force control (力控, manual 1.3.10)."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from aioduco.models.enums import RobotState, TaskState
from aioduco.models.force import ForceFrame, ForceLogic, GuardedForce
from aioduco.sim.controller.force_tasks import FC_MOVE
from aioduco.sim.controller.motion_queue import Following
from aioduco.sim.force.conditions import Condition, Quantity
from aioduco.sim.force.control import AdmittanceLaw, ForceGuard
from aioduco.sim.force.sensor import ForceAxes
from aioduco.sim.handlers.arguments import choice, number, numbers, six
from aioduco.sim.handlers.base import HandlerSection, task
from aioduco.sim.planner.follower import StandingFollower
from aioduco.sim.refusal import Rejected, illegal, mismatch

if TYPE_CHECKING:
    from collections.abc import Sequence
    from enum import IntEnum

    from aioduco.sim.controller.state_machine import Controller

_FORCE = 1000.0  # N, N m
_SPEED = 5.0  # m/s, rad/s
_TURNING = 2 * math.pi  # rad/s
_NO_SENSOR = "no force sensor is set up"


class ForceHandlers(HandlerSection):
    """fc_start to fc_mode_is_active; those that make a task return its id."""

    @task(block=False)
    def fc_start(self, controller: Controller) -> int:
        """开启机器人末端力控."""
        view = controller.view()
        if view.robot is not RobotState.ENABLE or view.error:
            raise illegal("not enabled, or a safety stop holds")
        if not self._cabinet.force_sensor:
            raise Rejected(TaskState.ERROR, _NO_SENSOR)
        return controller.force.start()

    def fc_stop(self) -> int:
        """退出机器人末端力控."""
        return self._task("fc_stop", False, lambda controller: controller.force.stop())

    @task(block=False)
    def fc_config(
        self,
        controller: Controller,
        direction: Sequence[bool],
        ref_ft: Sequence[float],
        damp: Sequence[float],
        max_vel: Sequence[float],
        number_list: Sequence[float],
        tool: str,
        wobj: str,
        value: int,
    ) -> None:
        """配置机器人末端力控参数; `value` is the manual's `type`."""
        on = _directions(direction)
        damping = numbers("damp", damp, 6)
        for i in range(6):
            if on[i] and not damping[i] > 0.0:
                raise mismatch(f"damp[{i}] is {damping[i]}, but must be above 0 where it is on")
        controller.force.control.law = AdmittanceLaw(
            on,
            six("ref_ft", ref_ft, _FORCE, "N, N m"),
            damping,
            tuple(map(abs, six("max_vel", max_vel, _SPEED, "m/s, rad/s"))),
            tuple(map(abs, six("number_list", number_list, _FORCE, "N, N m"))),
            self._axes_of(tool, wobj, value),
        )

    @task()
    def fc_move(self, controller: Controller) -> int:
        """仅基于末端力控产生的补偿运动."""
        if not controller.force.control.active:
            raise illegal("force control is off: call fc_start first")
        following = Following.behind(FC_MOVE, lambda q: StandingFollower(self._arm, q, self._cycle))
        return controller.follow(FC_MOVE, following)

    @task(block=False)
    def fc_guard_act(
        self,
        controller: Controller,
        direction: Sequence[bool],
        ref_ft: Sequence[float],
        tool: str,
        wobj: str,
        type: int,  # noqa: A002  # the wire's name
        force_property: int,
    ) -> None:
        """力安全监控."""
        on, limit = _directions(direction), _amounts("ref_ft", ref_ft)
        _choice("force_property", force_property, GuardedForce)
        axes = self._axes_of(tool, wobj, type)
        controller.force.control.guard = ForceGuard(
            on, limit, axes, force_property == GuardedForce.WITH_LOAD
        )

    @task(block=False)
    def fc_guard_deact(self, controller: Controller) -> None:
        """禁用力安全监控."""
        controller.force.control.guard = None

    @task(block=False)
    def fc_force_set_value(
        self, controller: Controller, direction: Sequence[bool], ref_ft: Sequence[float]
    ) -> int:
        """机械臂末端力传感器读数设置为指定值."""
        on, value = _directions(direction), numbers("ref_ft", ref_ft, 6)
        if not self._cabinet.force_sensor:
            raise Rejected(TaskState.ERROR, _NO_SENSOR)
        return controller.force.tare(on, value)

    @task(block=False)
    def fc_wait_pos(
        self, controller: Controller, middle: Sequence[float], **condition: Any
    ) -> None:
        """位置判断条件."""
        self._wait_for(controller, "pos", numbers("middle", middle, 6), **condition)

    @task(block=False)
    def fc_wait_vel(
        self, controller: Controller, middle: Sequence[float], **condition: Any
    ) -> None:
        """速度判断条件."""
        speeds = six("middle", middle, _SPEED, "m/s, rad/s", _TURNING)
        self._wait_for(controller, "vel", speeds, **condition)

    @task(block=False)
    def fc_wait_ft(self, controller: Controller, middle: Sequence[float], **condition: Any) -> None:
        """力判断条件."""
        self._wait_for(controller, "ft", six("middle", middle, _FORCE, "N, N m"), **condition)

    @task(block=False)
    def fc_wait_logic(self, controller: Controller, value: Sequence[int]) -> int:
        """条件判断间的逻辑关系."""
        if len(value) != 3:
            raise mismatch(f"logic has {len(value)} numbers, but must have 3")
        for how in value:
            _choice("logic", how, ForceLogic)
        return controller.force.combine(value)

    def fc_get_ft(self) -> list[float]:
        """当前机器人末端传感器的原始反馈读数, after taring; along the flange's axes."""
        if not self._cabinet.force_sensor:
            return []
        snapshot = self._runtime.snapshot
        return snapshot.view.sensor.reading(snapshot.wrench)

    def fc_mode_is_active(self) -> bool:
        """当前机器人末端力控功能启用状态."""
        return self._runtime.snapshot.view.force_control

    # -- shared parts --------------------------------------------------------------------------

    def _axes_of(self, tool: str, wobj: str, kind: int) -> ForceAxes:
        _choice("type", kind, ForceFrame)
        tip = self._frames.tool(tool).matrix
        return ForceAxes(tip, self._frames.wobj(wobj).matrix, kind == ForceFrame.TOOL)

    def _wait_for(
        self,
        controller: Controller,
        quantity: Quantity,
        middle: tuple[float, ...],
        *,
        range: Sequence[float],  # noqa: A002  # the wire's name
        absolute: bool,
        duration: int,
        timeout: int,
    ) -> None:
        widths = numbers("range", range, 6)
        if min(widths) < 0.0:
            text = f"range is {list(widths)}, but must be from 0"
            self._forgiving.forgive("negative range of a condition", text)
        condition = Condition(
            middle,
            tuple(map(abs, widths)),
            absolute,
            number("duration", duration, 0, math.inf, "ms") / 1000.0,
            number("timeout", timeout, 0, math.inf, "ms") / 1000.0,
        )
        controller.force.control.conditions.set(quantity, condition)


def _directions(values: Sequence[bool]) -> tuple[bool, ...]:
    if len(values) != 6:
        raise mismatch(f"direction has {len(values)} flags, but must have 6")
    return tuple(values)


def _amounts(name: str, values: Sequence[float]) -> tuple[float, ...]:
    for value in numbers(name, values, 6):
        number(name, value, 0.0, math.inf, "")
    return tuple(values)


def _choice(name: str, value: int, choices: type[IntEnum]) -> None:
    choice(name, value, tuple(choices), f"one of {', '.join(map(str, choices))}")
