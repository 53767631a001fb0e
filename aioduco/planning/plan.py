"""A plan as a value: joints over time, with the clearance along the path."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from aioduco.models.pose import Joints, Pose
from aioduco.models.ranges import FINITE, JOINT_SPEED, WAIT
from aioduco.planning.clearance import TOUCHING, Clearance
from aioduco.planning.scene import Scene, require_scene

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from aioduco.kinematics import Arm
    from aioduco.planning.motion_limits import MotionLimits
    from aioduco.sim.view.camera import Camera
    from aioduco.streaming.joint_trajectory import JointTrajectory, TrajectoryResult
    from aioduco.streaming.sampling import Spline

    Points = NDArray[np.float64]


_TURN, _MOVE = np.deg2rad(0.2), 0.001  # between two samples of a check [rad, m]
_FINEST = 0.002  # between times at which the motion between two samples is measured [s]
_PARTS = 5  # times of that kind between two points of the plan, at most
_NEAR = 0.02  # within which distances are measured at each sample [m]
_GHOSTS = 6  # arms in a picture of a plan
_SEEN = 24  # difference of colours that counts as the arm


@dataclass(frozen=True, slots=True)
class PlanCheck:
    """Result of a check of a plan.

    Attributes:
        clearance: the least distance to anything, with the names of the two bodies; below zero
            where the arm touches something.
        time: time of the plan at which that occurs [s].
        joints: configuration of the arm at that time.
        looks: number of configurations that were checked.
    """

    clearance: Clearance
    time: float
    joints: Joints
    looks: int

    @property
    def ok(self) -> bool:
        """Whether the arm collides with nothing; bodies may touch where the plan begins or ends."""
        return self.clearance.distance > -2.0 * TOUCHING

    def __bool__(self) -> bool:
        return self.ok

    def __str__(self) -> str:
        verdict = "free" if self.ok else "obstructed"
        return f"{verdict}: at {self.time:.2f} s {self.clearance} ({self.looks} looks)"


@dataclass(frozen=True, slots=True, eq=False)
class Plan:
    """Joints over time that lead from a start to a goal; the plan itself moves nothing (规划结果).

    Attributes:
        arm: the arm that it is for.
        trajectory: joint positions, velocities and accelerations with their times.
        limits: limits that no joint exceeds.
        tip: the tool's tip in the flange's frame. Shape (4, 4).
        corners: configurations between which the path is about straight in joint space, the start
            and the goal included [rad]. Shape (n, 6).
        looked: times at which the clearance was measured [s].
        clearances: distances to the nearest thing then, at most 0.1 [m].
        radii: how far a turn of each joint can move a point of the arm [m/rad]. Shape (6,).
        padding: distance that is kept all the way, less than the scene's if the start or the goal
            is closer to something [m].
        fraction: share of a line or an arc that it covers, 0 to 1; 1 for other plans.
        upright: whether the tool turns about the vertical only.
        searching: processor time that the path took [s].
        timing: processor time that its times took [s].
    """

    arm: Arm
    trajectory: JointTrajectory
    limits: MotionLimits
    tip: Points = field(repr=False)
    corners: Points = field(repr=False)
    looked: Points = field(repr=False)
    clearances: Points = field(repr=False)
    radii: Points = field(repr=False)
    padding: float = 0.0
    fraction: float = 1.0
    upright: bool = False
    searching: float = 0.0
    timing: float = 0.0

    def __repr__(self) -> str:
        part = f", {self.fraction:.0%} of the way" if self.fraction < 1.0 else ""
        return (
            f"<Plan for {self.arm.name}: {self.duration:.2f} s, "
            f"{self.clearance * 1e3:.0f} mm clear{part}>"
        )

    @property
    def duration(self) -> float:
        """Duration of the plan [s]."""
        return self.trajectory.duration

    @property
    def clearance(self) -> float:
        """Least distance to anything at the times `looked`, at most 0.1 [m]."""
        return float(self.clearances.min())

    @property
    def start(self) -> Joints:
        """Joints at the start."""
        return Joints.of(self.trajectory.positions[0])

    @property
    def end(self) -> Joints:
        """Joints at the end."""
        return Joints.of(self.trajectory.positions[-1])

    @property
    def rates(self) -> Points:
        """Speed of the fastest joint between two points of the trajectory [rad/s]. Shape (n-1,)."""
        turned = np.abs(np.diff(self.trajectory.positions, axis=0)).max(axis=1)
        return np.asarray(turned / np.diff(self.trajectory.times))

    def at(self, time: float) -> Joints:
        """Joints at a time [s]; before and after the plan, those of its start and end."""
        return Joints.of(self._curve().at(np.array([FINITE("time", time)]))[0])

    def pose(self, time: float) -> Pose:
        """Pose of the tool's tip at a time [s], in the base frame."""
        return Pose.from_matrix(self.arm.fkine(self.at(time)) @ self.tip)

    def check(self, scene: Scene, *, after: float = 0.0) -> PlanCheck:
        """Check the whole path again, in small steps, in a scene as it is now.

        It takes samples at least every 0.2° of any joint and every 1 mm of the tool's tip and the
        flange. It uses the trajectory as it will be sent, and nothing of how it was made.

        Args:
            scene: the scene, of the same arm.
            after: time of the plan from which on it is checked [s].

        Returns:
            The result: true if the arm touches nothing.

        Raises:
            ParameterError: it is no scene of the plan's arm, or the time is below 0.
        """
        require_scene("scene", scene, self.arm)
        times, q = self._samples(WAIT("after", after))
        checker = scene.checker()
        checker.padding = _NEAR
        near = [row for row in range(len(q)) if not checker.free(q[row])]
        # Distances are measured only where something is near, or where it was nearest when planned.
        rows = near or [int(np.argmin(np.interp(times, self.looked, self.clearances)))]
        found = [checker.clearance(q[row]) for row in rows]
        least = int(np.argmin([each.distance for each in found]))
        row = rows[least]
        return PlanCheck(found[least], float(times[row]), Joints.of(q[row]), len(q))

    def picture(
        self,
        scene: Scene,
        *,
        width: int = 640,
        height: int = 480,
        camera: Camera | None = None,
    ) -> NDArray[np.uint8]:
        """Draw the arm at several times of the plan in one picture, without a display.

        It blocks for some seconds, since a process is started that draws. In an async program:
        `await anyio.to_thread.run_sync(plan.picture, scene)`.

        Args:
            scene: the scene to draw it in; a plan does not keep the one that it was made in.
            width: width of the picture, at most 1920 [pixels].
            height: height of the picture, at most 1080 [pixels].
            camera: the camera; None for one that sees the whole arm.

        Returns:
            Red, green, blue. Shape (height, width, 3).

        Raises:
            ParameterError: it is no scene of the plan's arm, or the picture is too large.
            RenderError: this computer has no OpenGL that draws off screen.
        """
        require_scene("scene", scene, self.arm)
        times = np.linspace(0.0, self.duration, _GHOSTS)
        shown = self._curve().at(times)
        pictures = np.array(
            [
                picture.astype(np.float64)
                for picture in scene.pictures(
                    [Joints.of(q) for q in shown], width=width, height=height, camera=camera
                )
            ]
        )
        around = np.median(pictures, axis=0)
        result = around
        for share, picture in zip(np.linspace(0.35, 1.0, _GHOSTS), pictures, strict=True):
            arm = (np.abs(picture - around).max(axis=2) > _SEEN)[..., None]
            result = np.where(arm, share * picture + (1.0 - share) * result, result)
        drawn: NDArray[np.uint8] = result.round().astype(np.uint8)
        return drawn

    def waypoints(self) -> list[tuple[Joints, float, float]]:
        """Joints for blended motions of the controller, with speed [rad/s] and blend radius [m].

        Between them the joints move straight. Straight parts and blends stay so close to the plan
        that no point of the arm leaves its path by more than the padding that the plan keeps. No
        part is faster than the plan is there: so a line keeps to the speed of its tool, about.
        """
        q = self.trajectory.positions
        rows = _simplified(q * self.radii, 0.45 * self.padding)
        tips = (self.arm.fkine(q[rows]) @ self.tip)[:, :3, 3]
        lengths = np.linalg.norm(np.diff(tips, axis=0), axis=1)
        most = min(self.limits.velocity)
        rates = self.rates
        speeds = [
            float(np.clip(rates[one:other].max(), JOINT_SPEED.low, most))
            for one, other in pairwise(rows)
        ]
        found = []
        for i, row in enumerate(rows[1:-1], start=1):
            # A blend over half of both parts cuts the corner by this; over less, by less.
            middle = 0.5 * (q[rows[i - 1]] + q[rows[i + 1]])
            cut = 0.5 * float(np.abs(q[row] - middle) @ self.radii)
            share = min(1.0, 0.5 * self.padding / max(cut, 1e-9))
            radius = 0.45 * share * float(min(lengths[i - 1], lengths[i]))
            found.append((Joints.of(q[row]), speeds[i - 1], radius))
        return [*found, (self.end, speeds[-1] if speeds else most, 0.0)]

    async def run_on(
        self, motion: Any, read_joints: Any, **options: Any
    ) -> TrajectoryResult | None:
        """Carry out the plan; `robot.motion.execute` calls this."""
        from aioduco.planning.execution import execute  # noqa: PLC0415 - it names this class

        return await execute(motion, read_joints, self, **options)

    def _curve(self) -> Spline:
        return self.trajectory.curve(self.trajectory.positions[0].tolist())

    def _samples(self, after: float) -> tuple[Points, Points]:
        """Times and joints, so close together that no joint and no tool moves far between them."""
        begin = min(after, self.duration)
        most = _PARTS * len(self.trajectory.positions)
        count = int(np.clip(np.ceil((self.duration - begin) / _FINEST), 1, most))
        curve = self._curve()
        times = np.linspace(begin, self.duration, count + 1)
        q = curve.at(times)
        flange = self.arm.fkine(q)
        tips = (flange @ self.tip)[:, :3, 3]
        turned = np.abs(np.diff(q, axis=0)).max(axis=1) / _TURN
        moved = [
            np.linalg.norm(np.diff(points, axis=0), axis=1) / _MOVE
            for points in (tips, flange[:, :3, 3])
        ]
        steps = np.concatenate([[0.0], np.cumsum(np.maximum.reduce([turned, *moved]))])
        wanted = np.linspace(0.0, steps[-1], int(np.ceil(1.05 * steps[-1])) + 2)
        chosen = np.interp(wanted, steps, times) if steps[-1] > 0.0 else times[[0, -1]]
        return chosen, curve.at(chosen)


def _simplified(points: Points, tolerance: float) -> list[int]:
    """Rows of points whose connecting lines stay within a tolerance of all (Douglas-Peucker)."""
    kept, todo = {0, len(points) - 1}, [(0, len(points) - 1)]
    while todo:
        first, last = todo.pop()
        if last - first < 2:
            continue
        inner, way = points[first + 1 : last] - points[first], points[last] - points[first]
        share = np.clip(inner @ way / max(float(way @ way), 1e-18), 0.0, 1.0)
        off = np.abs(inner - share[:, None] * way).sum(axis=1)
        worst = int(np.argmax(off))
        if off[worst] > tolerance:
            middle = first + 1 + worst
            kept.add(middle)
            todo += [(first, middle), (middle, last)]
    return sorted(kept)
