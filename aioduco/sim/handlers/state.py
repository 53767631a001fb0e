"""Where the arm is and how it moves (manual 1.3.7).

The motion of the tip is computed with plain floats instead of arrays: for one configuration they
are several times as fast, and clients request the robot's status a thousand times a second.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from aioduco._wire.rpc import RobotStatus
from aioduco.kinematics.forward import frames
from aioduco.models.enums import RobotState
from aioduco.models.pose import Pose
from aioduco.models.rotation import Array, rpy_from_matrix
from aioduco.sim.handlers.base import HandlerContext, HandlerSection
from aioduco.sim.refusal import Rejected

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from aioduco.kinematics import Geometry
    from aioduco.sim.snapshot import SimulationSnapshot

    Triple = tuple[float, float, float]


class TipMotion(NamedTuple):
    """A tool's tip in the base frame, six numbers each, linear before angular.

    Attributes:
        pose: [m, rad].
        speed: [m/s, rad/s].
        acceleration: [m/s², rad/s²].
    """

    pose: list[float]
    speed: list[float]
    acceleration: list[float]


def tip_motion(geometry: Geometry, q: Array, qd: Array, qdd: Array, offset: Array) -> TipMotion:
    """Compute the motion of a point along the chain of joints.

    Args:
        geometry: the arm's lengths [m].
        q: joints [rad]. Shape (6,).
        qd: joint speeds [rad/s]. Shape (6,).
        qdd: joint accelerations [rad/s²]. Shape (6,).
        offset: the tip in the flange's frame. Shape (4, 4).
    """
    chain = frames(geometry, q)
    end = chain[6] @ offset
    points = [*chain[:6, :3, 3].tolist(), end[:3, 3].tolist()]
    axes = chain[:6, :3, 2].tolist()
    rates, drives = qd.tolist(), qdd.tolist()
    omega = alpha = linear = acceleration = (0.0, 0.0, 0.0)
    for i in range(6):
        z, rate = axes[i], rates[i]
        turn = (z[0] * rate, z[1] * rate, z[2] * rate)
        drive, swing = drives[i], _cross(omega, turn)
        alpha = (
            alpha[0] + z[0] * drive + swing[0],
            alpha[1] + z[1] * drive + swing[1],
            alpha[2] + z[2] * drive + swing[2],
        )
        omega = _add(omega, turn)
        here, there = points[i], points[i + 1]
        arm = (there[0] - here[0], there[1] - here[1], there[2] - here[2])
        across = _cross(omega, arm)
        linear = _add(linear, across)
        acceleration = _add(_add(acceleration, _cross(alpha, arm)), _cross(omega, across))
    pose = [*points[6], *rpy_from_matrix(end[:3, :3]).tolist()]
    return TipMotion(pose, [*linear, *omega], [*acceleration, *alpha])


def _cross(a: Triple, b: Triple) -> Triple:
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def _add(a: Triple, b: Triple) -> Triple:
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


class StateHandlers(HandlerSection):
    """Joints, tool and flange, actual and commanded; the robot's states."""

    def __init__(self, context: HandlerContext) -> None:
        super().__init__(context)
        self._last: tuple[SimulationSnapshot, TipMotion, TipMotion] | None = None
        self._effort = np.array(self._arm.effort)
        mounting = context.mounting
        self._mounting = mounting.matrix if any(mounting) else None
        self._period = context.period
        self._held: SimulationSnapshot | None = None

    @property
    def _snapshot(self) -> SimulationSnapshot:
        """The latest readings; those of the latest update if they are not updated in each cycle."""
        now, period = self._runtime.snapshot, self._period
        if not period:
            return now
        held = self._held
        # a tolerance of far less than a cycle, since times are sums
        if held is None or int(now.time / period + 1e-6) != int(held.time / period + 1e-6):
            self._held = held = now
        return held

    # -- joints --------------------------------------------------------------------------------

    def get_actual_joints_position(self) -> list[float]:
        """各关节的角度 [rad]."""
        return _list(self._snapshot.q)

    def get_actual_joints_speed(self) -> list[float]:
        """各关节角速度 [rad/s]."""
        return _list(self._snapshot.qd)

    def get_actual_joints_acceleration(self) -> list[float]:
        """各关节角加速度 [rad/s²]."""
        return _list(self._snapshot.qdd)

    def get_actual_joints_torque(self) -> list[float]:
        """各关节力矩 [N m]."""
        return _list(self._snapshot.torque)

    def get_target_joints_torque(self) -> list[float]:
        """各关节目标力矩: what the commanded motion needs by the controller's model [N m]."""
        return _list(self._snapshot.target_torque)

    def get_ext_torque(self) -> list[float]:
        """关节观测外力矩: external torques on the joints [N m]."""
        return _list(self._snapshot.external_torque)

    def get_target_joints_position(self) -> list[float]:
        """各关节的规划角度 [rad]."""
        return _list(self._snapshot.setpoint.q)

    def get_target_joints_speed(self) -> list[float]:
        """各关节规划角速度 [rad/s]."""
        return _list(self._snapshot.setpoint.qd)

    def get_target_joints_acceleration(self) -> list[float]:
        """各关节角规划加速度 [rad/s²]."""
        return _list(self._snapshot.setpoint.qdd)

    # -- tool and flange -----------------------------------------------------------------------

    def get_tcp_pose(self) -> list[float]:
        """工具末端点在基坐标系下的位姿 [m, rad]."""
        return self._tips(self._snapshot)[0].pose

    def get_tcp_speed(self) -> list[float]:
        """工具末端原点的空间速度 [m/s, rad/s]."""
        return self._tips(self._snapshot)[0].speed

    def get_tcp_acceleration(self) -> list[float]:
        """工具末端原点的空间加速度 [m/s², rad/s²]."""
        return self._tips(self._snapshot)[0].acceleration

    def get_tcp_pose_coord(self, tool: str, wobj: str) -> list[float]:
        """Pose of a tool's tip in the frame of a work object, both given by name [m, rad]."""
        try:
            offset, base = self._frames.tool(tool), self._frames.wobj(wobj)
        except Rejected as exc:
            return self._invalid_arguments("get_tcp_pose_coord", exc, [])
        flange = self._arm.fkine(self._snapshot.q)
        return list(Pose.from_matrix(base.inverse @ flange @ offset.matrix))

    def get_flange_pose(self) -> list[float]:
        """末端法兰在基坐标系下的位姿 [m, rad]."""
        return self._flange().pose

    def get_flange_speed(self) -> list[float]:
        """末端法兰在基坐标系下的速度 [m/s, rad/s]."""
        return self._flange().speed

    def get_flange_acceleration(self) -> list[float]:
        """末端法兰在基坐标系下的加速度 [m/s², rad/s²]."""
        return self._flange().acceleration

    # -- the robot -----------------------------------------------------------------------------

    def get_robot_state(self) -> list[int]:
        """Robot, program, safety controller, operation mode."""
        view = self._runtime.snapshot.view
        return [int(view.robot), int(view.program), int(view.safety), int(view.mode)]

    def getRobotStatus(self) -> RobotStatus:  # noqa: N802 - the name on the wire
        """Everything about the arm at one instant."""
        snapshot = self._snapshot
        view, setpoint = snapshot.view, snapshot.setpoint
        actual, expected = map(self._in_world, self._tips(snapshot))
        if self._cabinet.empty_statuses > 0:
            self._cabinet.empty_statuses -= 1
            return RobotStatus(robotState=int(view.robot), robotError=view.error)
        return RobotStatus(
            jointExpectPosition=_list(setpoint.q),
            jointExpectVelocity=_list(setpoint.qd),
            jointExpectAccelera=_list(setpoint.qdd),
            jointActualPosition=_list(snapshot.q),
            jointActualVelocity=_list(snapshot.qd),
            jointActualAccelera=_list(snapshot.qdd),
            # The motors' data are not public: the joint's largest torque stands for the rated one.
            jointActualCurrent=_list(1000.0 * snapshot.torque / self._effort),
            jointTemperature=_list(snapshot.joint_temperature),
            driverTemperature=_list(snapshot.board_temperature),
            cartExpectPosition=expected.pose,
            cartExpectVelocity=expected.speed,
            cartExpectAccelera=expected.acceleration,
            cartActualPosition=actual.pose,
            cartActualVelocity=actual.speed,
            cartActualAccelera=actual.acceleration,
            slaveReady=[view.robot is RobotState.ENABLE] * 6,
            collision=view.collision_axis != 0,
            collisionAxis=view.collision_axis,
            emcStopSignal=view.emergency_stop,
            robotState=int(view.robot),
            robotError=view.error,
        )

    def _tips(self, snapshot: SimulationSnapshot) -> tuple[TipMotion, TipMotion]:
        """The tool's tip, actual and commanded; computed once per snapshot."""
        last = self._last
        if last is not None and last[0] is snapshot:
            return last[1], last[2]
        tool, geometry = snapshot.view.tool, self._arm.geometry
        point = snapshot.setpoint
        actual = tip_motion(geometry, snapshot.q, snapshot.qd, snapshot.qdd, tool.matrix)
        expected = tip_motion(geometry, point.q, point.qd, point.qdd, tool.matrix)
        self._last = (snapshot, actual, expected)
        return actual, expected

    def _in_world(self, tip: TipMotion) -> TipMotion:
        """Convert a tip's motion to the world's frame, which the status uses."""
        mounting = self._mounting
        if mounting is None:
            return tip

        def turned(vector: list[float]) -> list[float]:
            both = np.reshape(vector, (2, 3)) @ mounting[:3, :3].T
            return [*both[0].tolist(), *both[1].tolist()]

        pose = list(Pose.from_matrix(mounting @ Pose(*tip.pose).matrix))
        return TipMotion(pose, turned(tip.speed), turned(tip.acceleration))

    def _flange(self) -> TipMotion:
        now = self._snapshot
        return tip_motion(self._arm.geometry, now.q, now.qd, now.qdd, np.eye(4))


def _list(vector: NDArray[np.float64]) -> list[float]:
    numbers: list[float] = vector.tolist()
    return numbers
