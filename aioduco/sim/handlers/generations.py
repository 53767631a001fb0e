"""Handlers of controllers of other generations: where their meanings differ from the present one's.

What a controller of manual 4.3 does is that manual's, as far as it says it. The rest is an
assumption of the fidelity ledger. How the older ones differ in meaning is not known.

Of each generation there is a kind that returns readings in single precision, as a controller does.
"""

from __future__ import annotations

import dataclasses
import functools
import math
from dataclasses import fields, replace
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

from aioduco._wire import newer
from aioduco._wire.rpc import EAxissInfo, MoveJogTaskParam, RobotStatus
from aioduco.sim.handlers import Handlers
from aioduco.sim.handlers.base import arguments_of
from aioduco.sim.handlers.paths import JOINT_ACCELERATION, JOINT_SPEED, MotionCall, Range
from aioduco.sim.refusal import Refusal, illegal, mismatch

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from aioduco.models.rotation import Array
    from aioduco.sim.planner.servo_follower import ServoTuning


_TOOL_SPEED = (1e-5, 5.0, "m/s")
_TOOL_ACCELERATION = (1e-5, math.inf, "m/s²")
#: functions whose v and a are the tool's in manual 4.3
_BY_TOOL = ("servo_tcp", "servol")
#: the direction of a jog in manual 4.3, and its sign
_JOG_SIGNS = {0: 1, 1: -1}
_CARTESIAN = 1
_OUT_OF_SPACE = 4
#: the least way of the tool by which its speed says that of the joints [m]
_LEAST_WAY = 1e-9


class OlderHandlers(Handlers):
    """A controller of one of the three older generations.

    Which versions of the software they have is not known, so it reports a text without one.
    """

    def get_robot_version(self) -> str:
        """A text without a version."""
        return "older, aioduco.simulator"

    def set_hand_teach_parameter(
        self,
        space: int,
        joint_scale: Any,
        cart_scale: Any,
        coord_type: int,
        direction: Sequence[bool],
    ) -> int:
        """牵引参数, with one scale for all joints, and one for all directions."""
        joints, cart = (
            [one] * 6 if isinstance(one, int) else one for one in (joint_scale, cart_scale)
        )
        return super().set_hand_teach_parameter(space, joints, cart, coord_type, direction)


class NewerHandlers(Handlers):
    """A controller of manual 4.3."""

    _version = "4.3.0"

    # -- answers with more fields, or others -----------------------------------------------------

    def getRobotStatus(self) -> RobotStatus:  # noqa: N802 - the name on the wire
        """The same as in 3.8, and torques; those of gravity alone are not computed: none."""
        status = super().getRobotStatus()
        snapshot = self._runtime.snapshot
        return newer.RobotStatus(
            **{each.name: getattr(status, each.name) for each in fields(status)},
            jointAuxiliaryPosition=snapshot.q.tolist(),
            jointDynamicTorque=snapshot.target_torque.tolist(),
            jointGravityTorque=[],
            jointActualTorque=snapshot.torque.tolist(),
            jointExtraTorque=snapshot.external_torque.tolist(),
        )

    def get_eaxis_info(self) -> list[EAxissInfo]:
        """The same as in 3.8, with the commanded speed and acceleration of the first axis."""
        return [
            newer.EAxissInfo(
                each.name, int(each.active), each.position, each.speed, each.acceleration
            )
            for each in self._controller.external_axes.states()
        ]

    def reach_check(
        self,
        base: Sequence[float],
        wobj: Sequence[float],
        tool: Sequence[float],
        ref_pos: Sequence[float],
        check_points: Sequence[Sequence[float]],
    ) -> newer.ReachabilityParam:
        """Tell whether every pose can be reached, else the first that cannot: out of space."""
        found = self._joints_of(base, wobj, tool, ref_pos, check_points)
        reached = 0 if found is None else len(found)
        if found is not None and reached == len(check_points):
            return newer.ReachabilityParam(True, [], 0, 0)
        return newer.ReachabilityParam(False, [], reached, _OUT_OF_SPACE)

    # -- motions ---------------------------------------------------------------------------------

    def movec(self, *values: Any) -> int:
        """Move along an arc through p1 to p2; a fixed radius, after the rest, is not simulated."""
        names = arguments_of("movec")
        given, added = values[: len(names)], values[len(names) :]
        if added and added[0] != 0.0:
            block = given[names.index("block")]
            return self._task("movec", block, lambda _: _refuse_radius(added[0]))
        return super().movec(*given)

    def _as_in_3_8(self, param: MoveJogTaskParam) -> MoveJogTaskParam:
        sign = _JOG_SIGNS.get(param.jog_direction)
        if sign is None:
            raise mismatch(f"jog_direction is {param.jog_direction}, but must be 0 or 1")
        turns = param.jog_type == _CARTESIAN and param.axis_num >= 3
        step = param.step_jointValue if turns else param.step_cartvalue
        return replace(param, jog_direction=sign, step_cartvalue=step)

    def _scheme(self, call: MotionCall) -> tuple[str, Sequence[float], float]:
        """The one scheme of a call, which comes in lists; two at once are not simulated."""
        names, eposes, speeds = call.scheme_name, call.epose, call.eaxis_v
        if isinstance(names, str):  # in a program, whose calls are those of 3.8
            return super()._scheme(call)
        if not len(names) == len(eposes) == len(speeds) > 0:
            raise mismatch("scheme_name, epose and eaxis_v must be lists of the same length")
        if len(names) > 1:
            raise illegal("moves of several schemes are not simulated")
        return names[0], eposes[0], speeds[0]

    def _paces(self, name: str) -> tuple[Range, Range]:
        return (_TOOL_SPEED, _TOOL_ACCELERATION) if name in _BY_TOOL else super()._paces(name)

    def _by_joints(self, name: str, tuning: ServoTuning, at: Array, to: Array) -> ServoTuning:
        if name not in _BY_TOOL:
            return tuning
        tool = self._frames.tool().matrix
        start, end = ((self._arm.fkine(q) @ tool)[:3, 3] for q in (at, to))
        ratio = float(np.abs(to - at).max()) / max(float(np.linalg.norm(end - start)), _LEAST_WAY)
        return replace(
            tuning,
            v=float(np.clip(tuning.v * ratio, *JOINT_SPEED[:2])),
            a=float(np.clip(tuning.a * ratio, *JOINT_ACCELERATION[:2])),
        )

    # -- functions that 3.8 does not have --------------------------------------------------------

    def get_base(self) -> list[float]:
        """Pose of the base in the world [m, rad]."""
        return list(self._context.mounting)

    def get_home_pose(self) -> list[float]:
        """Joints at which the simulator started [rad]."""
        return list(self._context.home)

    def get_installation(self) -> list[float]:
        """Tilt of the base's z axis, and the direction to which it leans [rad]."""
        x, y, z = self._context.mounting.matrix[:3, 2]
        return [math.acos(max(-1.0, min(1.0, z))), math.atan2(y, x) if math.hypot(x, y) else 0.0]

    def get_tcp_pose_command(self) -> list[float]:
        """Commanded pose of the tool in the base frame [m, rad]."""
        return self._tips(self._runtime.snapshot)[1].pose

    def get_tcp_speed_command(self) -> list[float]:
        """Commanded speed of the tool in the base frame [m/s, rad/s]."""
        return self._tips(self._runtime.snapshot)[1].speed

    def get_simulation_state(self) -> bool:
        """Whether motions run on a simulated arm within the controller."""
        return self._runtime.snapshot.view.simulation

    def clear_error_message(self) -> None:
        """Empty the error list."""
        with self._runtime.command() as controller:
            controller.clear_errors()

    def enable_laser_track(self) -> int:
        """Refused: no seam is seen."""
        _refuse_laser("enable_laser_track")

    def disable_laser_track(self) -> int:
        """Refused, as above."""
        _refuse_laser("disable_laser_track")

    def reset_laser_track(self) -> int:
        """Refused, as above."""
        _refuse_laser("reset_laser_track")


def _refuse_radius(arc_rad: float) -> NoReturn:
    raise mismatch(f"arc_rad is {arc_rad}: only 0, no fixed radius, is simulated")


def _refuse_laser(name: str) -> NoReturn:
    raise Refusal(f"{name} is not simulated: there is no laser sensor")


#: functions that return readings of the arm: measured, commanded, or computed from these
READINGS = (
    "getRobotStatus",
    *(
        f"get_{which}_joints_{quantity}"
        for which in ("actual", "target")
        for quantity in ("position", "speed", "acceleration", "torque")
    ),
    *(
        f"get_{what}_{quantity}"
        for what in ("tcp", "flange")
        for quantity in ("pose", "speed", "acceleration")
    ),
    *("get_tcp_pose_coord", "get_tcp_force", "get_tcp_force_tool"),
    *("get_ext_torque", "fc_get_ft"),
    # of controllers of manual 4.3
    *("get_tcp_pose_command", "get_tcp_speed_command"),
)


@functools.cache
def in_single_precision(kind: type[Handlers]) -> type[Handlers]:
    """Return the same handlers with each number of a reading rounded to a 32-bit float."""
    readings = {name: _rounded(getattr(kind, name)) for name in READINGS if hasattr(kind, name)}
    return type(f"SinglePrecision{kind.__name__}", (kind,), readings)


def _rounded(exact: Callable[..., Any]) -> Callable[..., Any]:
    @functools.wraps(exact)
    def reading(self: Handlers, *args: Any) -> Any:
        return _single(exact(self, *args))

    return reading


def _single(answer: Any) -> Any:
    if isinstance(answer, RobotStatus):
        names = [field.name for field in dataclasses.fields(answer)]
        lists = {name: _single(getattr(answer, name)) for name in names}
        return dataclasses.replace(answer, **lists)
    if isinstance(answer, list) and answer and isinstance(answer[0], float):
        return np.array(answer, np.float32).tolist()
    return answer
