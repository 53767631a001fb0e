"""Random motions, streams and jogs of a simulated arm, each within random zones, and what they do.

Programs that go on commanding, whatever they are told, are a kind of their own.

    .ci/envelope-trials --count 10000 [--seed 1] [--processes 2] [--log FILE] [--save]
    .ci/envelope-trials --only 1234 [--seed 1]      # one of them again

Each trial draws from its seed and its own number alone, so each can be repeated. They are carried
out in blocks, each on a simulator and by a process of its own. With `--log`, blocks that are in the
file already are not carried out again: so a run that was ended goes on.

Everything is judged by code of its own: margins by numpy, ways of refused motions by the
simulator's planner, set-points as the simulator's handler gets them, and the arm as it stands in
every cycle of the physics.
"""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import json
import logging
import math
import os
import sys
import time
from collections import Counter
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import ruckig

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from collections.abc import Iterable, Iterator

import aioduco
from aioduco import Jog, JogFrame
from aioduco.envelope import BODIES, Envelope, Zone
from aioduco.kinematics import arm as arm_of
from aioduco.kinematics.forward import frames
from aioduco.models.pose import Pose
from aioduco.sim import Simulator
from aioduco.sim.handlers.servo import ServoHandlers
from aioduco.sim.handlers.system import SystemHandlers
from aioduco.sim.physics.world import World
from aioduco.sim.planner.path import PlanError
from aioduco.sim.planner.segments import arc_move, joint_move, line_move
from aioduco.streaming.shared.options import Upsampling

ARM = arm_of("gcr5_910")
START = np.array([0.0, 0.0, math.pi / 2, 0.0, -math.pi / 2, 0.0])
TOOL = Pose(0.02, -0.01, 0.12, 0.0, 0.3, 0.0)
UPSAMPLING: tuple[Upsampling, ...] = ("none", "cubic", "ruckig")
#: how far the arm may be from what it is told to follow [m]: what it lags on the simulator
LAG = 2.5e-3
KINDS = ("motion", "stream", "jog", "commands")
#: what programs go on commanding
COMMANDS = (
    *("servoj", "servo_tcp", "servoj_pose", "servol", "speedj", "speedl"),
    *("jog", "jog of the tool", "steps of the tool"),
)
#: trials on one simulator
BLOCK = 25
#: half as many cycles a second as a controller's: physics is what takes the time
CYCLE = 0.002
#: times that the arm is brought to its start, where a busy machine holds the program up
_AGAIN = 5
#: of the simulator's clock, and while a stream runs: its set-points are to be in time
SPEED, STREAM_SPEED = 25.0, 2.0
#: limits of the streams [rad/s, rad/s²]
STREAM_V, STREAM_A, STREAM_JERK = 3.0, 15.0, 150.0
RATE = 500
#: how near to a zone the way of a stream that was ended leads, to its rest included [m]: by a tick
#: at full speed, and by how far the ways of the bodies bend in a step of the check
STRAIGHT = 0.02
ROUNDING = 1e-9
#: how near to a zone the way of a motion that was refused comes at least [m]: a chord of its
#: check is a little apart from the way
REFUSED = 5e-4
#: as a jog is judged before it is sent: the time until a stop takes effect [s], and how the arm
#: slows down then at least [rad/s²]
AHEAD, STOPPING = 0.1, 5.0
RESULTS = Path(__file__).resolve().parents[2] / "benchmarks/results/envelope_trials.json"


def places(q: Any) -> np.ndarray:
    """Tool, elbow and flange for joints of shape (n, 6). Shape (n, 3, 3)."""
    chain = frames(ARM.geometry, np.atleast_2d(np.asarray(q, dtype=float)))
    tip = (chain[:, 6] @ TOOL.matrix)[:, :3, 3]
    return np.stack([tip, chain[:, 2, :3, 3], chain[:, 6, :3, 3]], axis=1)


def margins(zone: Zone, points: np.ndarray) -> np.ndarray:
    """How far points of shape (n, 3) are within what a zone allows [m]."""
    off = points - np.array(zone.at)
    if zone.shape == "plane":
        return np.asarray(off @ np.array(zone.size))
    if zone.shape == "sphere":
        outside = np.linalg.norm(off, axis=1) - zone.size[0]
    else:
        beyond = np.abs(off @ np.array(zone.turn).reshape(3, 3)) - np.array(zone.size) / 2
        outside = np.linalg.norm(np.maximum(beyond, 0.0), axis=1)
        outside += np.minimum(beyond.max(axis=1), 0.0)
    return np.asarray(-outside if zone.keep == "in" else outside)


def least(zones: tuple[Zone, ...], q: Any) -> float:
    """The least margin of any body to any zone, over joints of shape (n, 6)."""
    at = places(q)
    return min(
        float(margins(zone, at[:, BODIES.index(body)]).min())
        for zone in zones
        for body in zone.bodies
    )


def random_zones(rng: np.random.Generator, q: np.ndarray, room: float = 0.01) -> tuple[Zone, ...]:
    """Zones of which the arm at q is clear by some room [m]."""
    found: list[Zone] = []
    wanted = int(rng.integers(3, 10))
    while len(found) < wanted:
        at = rng.uniform([-0.6, -0.6, 0.0], [0.8, 0.8, 1.0])
        bodies = tuple(rng.permutation(BODIES)[: rng.integers(1, 4)])
        kind = rng.integers(4)
        if kind == 0:
            zone = Zone.sphere(at, rng.uniform(0.05, 0.3), bodies=bodies)
        elif kind == 1:
            pose = [*at, *rng.uniform(-1.5, 1.5, 3)]
            zone = Zone.box(pose, rng.uniform(0.05, 0.5, 3), bodies=bodies)
        elif kind == 2:
            zone = Zone.box(at, rng.uniform(0.3, 1.2, 3), keep="in", bodies=bodies)
        else:
            zone = Zone.plane(at, rng.normal(size=3), bodies=bodies)
        if least((zone,), q) > room:
            found.append(zone)
    return tuple(found)


@dataclass
class Seen:
    """What the simulated controller was told, and what its arm did."""

    setpoints: list[list[float]]
    q: list[np.ndarray]
    stopped: list[int]

    def clear(self) -> None:
        """Begin anew."""
        del self.setpoints[:], self.q[:], self.stopped[:]


@contextlib.contextmanager
def watched() -> Iterator[Seen]:
    """Note what every simulator of this process is told and does."""
    seen = Seen([], [], [])
    step, servoj, stop = World.step, ServoHandlers.servoj, SystemHandlers.stop

    def stepped(world: World, setpoint: Any) -> None:
        step(world, setpoint)
        seen.q.append(world.q)

    def told(handlers: ServoHandlers, joints_list: Any, *rest: Any) -> int:
        seen.setpoints.append(list(joints_list))
        return servoj(handlers, joints_list, *rest)

    def halted(handlers: SystemHandlers, block: bool) -> int:
        seen.stopped.append(len(seen.q))
        return stop(handlers, block)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(World, "step", stepped)
        patch.setattr(ServoHandlers, "servoj", told)
        patch.setattr(SystemHandlers, "stop", halted)
        yield seen


class Trials:
    """Random trials of one robot.

    Args:
        robot: the robot, ready to move, with `TOOL` in use.
        sim: the simulator.
        seen: what it is told and does.

    Attributes:
        counts: what became of the trials.
        deepest: by kind, how far the arm came beyond a zone at the most, and beyond it by more
            than the way on which it stopped [m].
        nearest: the least margin of a set-point that was sent [m].
    """

    def __init__(self, robot: aioduco.Robot, sim: Simulator, seen: Seen) -> None:
        self._robot = robot
        self._sim = sim
        self._seen = seen
        self._rng = np.random.default_rng(0)
        self.counts: Counter[str] = Counter()
        self.deepest: dict[str, tuple[float, float]] = {}
        self.nearest = math.inf

    async def carry_out(self, kind: str, seed: int, number: int) -> None:
        """One trial."""
        self._rng = np.random.default_rng([seed, number])
        await getattr(self, kind)()
        self.counts[kind] += 1

    async def _stand(self, q: np.ndarray) -> None:
        """Bring the arm to joints."""
        for left in reversed(range(_AGAIN)):
            try:
                await self._robot.stop()  # what stopped the last one may still be under way
                await self._robot.bring_up()
                await self._robot.motion.movej2(q, v=3.9, a=40.0)
            except aioduco.HeartbeatLost:
                await self._robot.rearm_heartbeat()  # the program was held up, and the arm stands
                if not left:
                    raise
            except (aioduco.TaskError, aioduco.ConnectionLost):
                if not left:
                    raise
            else:
                return

    async def begin(self) -> tuple[Zone, ...]:
        """Stand somewhere, and have new zones around."""
        robot, rng = self._robot, self._rng
        robot.envelope = None
        await self._stand(START + rng.uniform(-0.4, 0.4, 6))
        here = np.array(await robot.state.get_actual_joints_position())
        zones = random_zones(rng, here)
        robot.envelope = Envelope(ARM, *zones)
        self._seen.clear()
        return zones

    def _judge(self, zones: tuple[Zone, ...], allowed: float, what: str) -> None:
        depth = -least(zones, self._seen.q[::2]) if self._seen.q else 0.0
        was = self.deepest.get(what, (0.0, -math.inf))
        self.counts[f"{what} judged"] += 1
        self.deepest[what] = max(was[0], depth), max(was[1], depth - allowed)
        assert depth <= allowed, f"{what}: {depth:.6f} m beyond a zone, {allowed:.6f} allowed"

    async def motion(self) -> None:
        """A joint motion, a line or an arc."""
        robot, rng = self._robot, self._rng
        zones = await self.begin()
        q = np.array(await robot.state.get_actual_joints_position())
        pose = await robot.state.get_tcp_pose()
        kind = ("movej2", "movel", "movec")[rng.integers(3)]
        target = q + rng.uniform(-0.8, 0.8, 6)
        points = [
            Pose(*(np.array(pose)[:3] + rng.uniform(-0.25, 0.25, 3)), *np.array(pose)[3:])
            for _ in range(2)
        ]
        back = TOOL.inverse().matrix
        flange = [point.matrix @ back for point in points]
        try:
            if kind == "movej2":
                motion = robot.motion.movej2(target, v=3.0, a=20.0)
                segment = joint_move(ARM, q, target, 3.0, 20.0)
            elif kind == "movel":
                motion = robot.motion.movel(points[0], v=1.0, a=5.0)
                segment = line_move(ARM, q, flange[0], 1.0, 5.0, tool=TOOL.matrix)
            else:
                via, end = points
                motion = robot.motion.movec(via, end, v=1.0, a=5.0)
                segment = arc_move(ARM, q, flange[0], flange[1], 1.0, 5.0, tool=TOOL.matrix)
        except PlanError:
            motion.mark_used()
            self.counts[f"{kind} impossible"] += 1
            return
        assert segment.path is not None
        path = segment.path.sample(np.linspace(0, segment.path.end, 1500))[:, 0]
        nearest = least(zones, path)
        try:
            await motion
        except aioduco.EnvelopeViolated:
            clear = f"{kind} refused, {nearest:.4f} m clear of all zones"
            assert nearest < REFUSED, clear
            self.counts[f"{kind} refused"] += 1
        except aioduco.TaskUnknown:
            self.counts[f"{kind} lost sight of"] += 1  # the arm is judged all the same
        except aioduco.TaskFailed:
            self.counts[f"{kind} ended by a collision"] += 1  # with the floor, or with itself
        else:
            assert nearest >= -1e-6, f"{kind} sent, though its way is {-nearest:.6f} m beyond"
            self.counts[f"{kind} sent"] += 1
        self._judge(zones, LAG, "motion")

    async def stream(self) -> None:
        """A stream of joint positions that wanders off."""
        robot, rng = self._robot, self._rng
        zones = await self.begin()
        here = np.array(await robot.state.get_actual_joints_position())
        rate, count = RATE, 250
        way = rng.uniform(-1.0, 1.0, 6)
        shares = (1 - np.cos(np.linspace(0, math.pi, count))) / 2
        points = here + 0.8 * shares[:, None] * way
        upsample = UPSAMPLING[rng.integers(3)]
        options = aioduco.WorkerOptions(run_in="thread", timeout=10.0)
        stream = robot.servo.joints(
            v=STREAM_V, a=STREAM_A, rate=rate, source_rate=rate, upsample=upsample, options=options
        )
        self._sim.speed = STREAM_SPEED
        try:
            async with stream:
                await stream.play(points)
        except aioduco.StreamLeavesEnvelope:
            self.counts["streams ended before a zone"] += 1
            nearest = min(least(zones, points), least(zones, self._stops()))
            # the set-point that was not sent is as far ahead as there were ticks without one
            ahead = self._fastest() * stream.statistics().missed / RATE
            clear = f"{upsample} ended, {nearest:.4f} m clear of all zones, {ahead:.4f} ahead"
            assert nearest < STRAIGHT + ahead, clear
        except aioduco.StreamRefused:
            self.counts["streams ended by a collision"] += 1  # with the floor, or with itself
        else:
            self.counts["streams within the zones"] += 1
            assert least(zones, points) >= -ROUNDING, "the way is beyond a zone, and was followed"
        finally:
            self._sim.speed = SPEED
        sent = self._seen.setpoints
        if sent:
            margin = least(zones, sent)
            self.nearest = min(self.nearest, margin)
            assert margin >= -ROUNDING, f"a set-point {-margin:.3e} m beyond a zone was sent"
            self.counts["set-points"] += len(sent)
        if stream.statistics().missed:
            # The controller looks ahead of set-points, and overshoots where they come late: on a
            # busy machine the arm may leave a zone by what it takes to stop.
            self._judge(zones, LAG + self._stopping(), "stream that was held up")
        else:
            self._judge(zones, LAG, "stream")

    def _stops(self) -> np.ndarray:
        """The ways on which the arm would have come to rest from the set-points that were sent.

        An axis may have been slowing down or not: what it takes at the most is told by Ruckig.
        """
        sent = np.array(self._seen.setpoints)
        if len(sent) < 3:
            return np.array(sent)
        speeds = np.diff(sent, axis=0) * RATE
        changes = np.diff(speeds, axis=0) * RATE
        shares = np.linspace(0.0, 1.0, 20)[:, None]
        found = []
        generator = ruckig.Ruckig(6)
        for q, v, a in zip(sent[2:], speeds[1:], changes, strict=True):
            plan = ruckig.InputParameter(6)
            plan.control_interface = ruckig.ControlInterface.Velocity
            plan.synchronization = ruckig.Synchronization.No
            plan.max_velocity, plan.max_acceleration = [STREAM_V] * 6, [STREAM_A] * 6
            plan.max_jerk = [STREAM_JERK] * 6
            plan.current_velocity = v
            plan.current_acceleration = np.clip(a, -STREAM_A, STREAM_A)
            plan.target_velocity = [0.0] * 6
            stop = ruckig.Trajectory(6)
            generator.calculate(plan, stop)
            found.append(q + shares * np.array(stop.at_time(stop.duration)[0]))
        return np.concatenate(found)

    def _fastest(self) -> float:
        """How fast a body was at the most, by the set-points that were sent [m/s]."""
        sent = np.array(self._seen.setpoints)
        if len(sent) < 2:
            return 0.0
        return float(np.linalg.norm(np.diff(places(sent), axis=0), axis=2).max() * RATE)

    def _stopping(self) -> float:
        """The way that a body takes to stop, at the most, at the speeds that the arm had [m]."""
        rows = np.array(self._seen.q)
        if len(rows) < 2:
            return 0.0
        fastest = np.abs(np.diff(rows, axis=0)).max(axis=1) / CYCLE
        speeds = np.linalg.norm(np.diff(places(rows), axis=0), axis=2).max(axis=1) / CYCLE
        return float((speeds * fastest).max() / STREAM_A / 2)

    async def jog(self) -> None:
        """A velocity of the joints or of the tool, whose way nobody knows."""
        robot, rng = self._robot, self._rng
        zones = await self.begin()
        q, speeds = np.array(await robot.state.get_actual_joints_position()), None
        if rng.random() < 0.5:
            speeds = rng.uniform(-1.0, 1.0, 6)
            motion = robot.motion.speedj(speeds, a=5.0, time=1.0)
        else:
            twist = [*rng.uniform(-0.4, 0.4, 3), 0.0, 0.0, 0.0]
            motion = robot.motion.speedl(twist, a=2.0, time=1.0)
        try:
            await motion
        except aioduco.TaskStopped as exc:
            if isinstance(exc.__cause__, aioduco.EnvelopeViolated):
                self.counts["jogs stopped"] += 1
            else:
                raise
        except aioduco.EnvelopeViolated:
            self.counts["jogs refused"] += 1
            if speeds is not None:
                ahead = AHEAD + np.abs(speeds).max() / STOPPING / 2
                nearest = least(zones, q + np.linspace(0, ahead, 500)[:, None] * speeds)
                assert nearest < REFUSED, f"jog refused, {nearest:.4f} m clear of all zones"
            return
        except aioduco.TaskError:
            self.counts["jogs ended by the controller"] += 1  # at a singularity or a joint's limit
        else:
            self.counts["jogs to their end"] += 1
        rows = self._seen.q
        stopping = 0.0
        if self._seen.stopped:
            after = places(rows[max(0, self._seen.stopped[0] - 1) :])
            stopping = float(np.linalg.norm(np.diff(after, axis=0), axis=2).sum(axis=0).max())
        self._judge(zones, stopping + 1e-4, "jog")
        if least(zones, rows) >= 0.0:
            self.counts["jogs that stayed within"] += 1

    async def commands(self) -> None:
        """A program that goes on commanding towards a limit, whatever it is told."""
        robot, rng = self._robot, self._rng
        zones = await self.begin()
        motion = robot.motion
        v, a, time = rng.uniform(0.1, 1.0), rng.uniform(1.0, 20.0), rng.uniform(0.2, 1.0)
        way = rng.uniform(-1.0, 1.0, 6)
        step = np.clip(rng.normal(size=3), -2.0, 2.0) * 0.01
        axis, sense = int(rng.integers(6)), int(rng.choice([-1, 1]))
        joints = np.array(await robot.state.get_actual_joints_position())
        pose = np.array(await robot.state.get_tcp_pose())
        frame = (JogFrame.BASE, JogFrame.TOOL, JogFrame.WORK_OBJECT)[rng.integers(3)]
        name = COMMANDS[rng.integers(len(COMMANDS))]

        def next_one(number: int) -> Any:
            there = [*(pose[:3] + number * step), *pose[3:]]
            match name:
                case "servoj":
                    return motion.servoj(joints + 0.03 * number * way, v=v, a=a)
                case "servo_tcp":
                    return motion.servo_tcp((*step, 0, 0, 0), v=v, a=a)
                case "servoj_pose" | "servol":
                    return getattr(motion, name)(there, v=v, a=a)
                case "speedj":
                    return motion.speedj(v * way, a=a, time=time)
                case "speedl":
                    return motion.speedl((*30 * v * step, *0.5 * way[3:]), a=a, time=time)
                case "jog":
                    return motion.move_jog(Jog.joint(axis + 1, sense, 100.0), time=time)
                case "jog of the tool":
                    along = ("x", "y", "z", "rx", "ry", "rz")[axis]
                    jog = Jog.cartesian(along, sense, 100.0, frame=frame)  # type: ignore[arg-type]
                    return motion.move_jog(jog, time=time)
                case _:
                    along = ("x", "y", "z", "rx", "ry", "rz")[axis]
                    jog = Jog.cartesian(along, sense, 100.0, frame=frame, step=0.05)  # type: ignore[arg-type]
                    return motion.move_jog(jog)

        awaited, refused = bool(rng.random() < 0.5), 0
        for number in range(1, 25):
            command = next_one(number)
            try:
                if awaited:
                    await command
                else:
                    await command.start()
            except aioduco.EnvelopeViolated:
                refused += 1
            except (aioduco.TaskError, aioduco.Refused):
                continue  # stopped, out of reach, at a singularity, or still stopping
        await robot.stop()
        self.counts[f"{name} refused" if refused else f"{name} within the zones"] += 1
        self._judge(zones, LAG, f"commands: {name}")


@dataclass
class Outcome:
    """What came of some trials, as JSON takes it."""

    first: int
    counts: dict[str, int]
    deepest: dict[str, tuple[float, float]]
    nearest: float | None
    failed: dict[str, str]
    wall: float = 0.0
    processor: float = 0.0


async def run(
    numbers: Iterable[int], seed: int, *, kind: str = "", speed: float = SPEED
) -> Outcome:
    """Carry out trials on a simulator of their own."""
    numbers = list(numbers)
    failed: dict[str, str] = {}
    with watched() as seen, Simulator(speed=speed, seed=seed, pedestal=1.0, cycle=CYCLE) as sim:
        async with aioduco.connect(
            sim.host,
            sim.port,
            clock=sim.clock,
            state_rate=300.0,
            lag_limit=None,
            heartbeat=20.0,
            loop_stall_limit=15.0,
            call_timeout=10.0,
        ) as robot:
            await robot.bring_up()
            await robot.frames.set_tool_data("probe", TOOL, [0.1, 0, 0, 0.05])
            trials = Trials(robot, sim, seen)
            for number in numbers:
                for left in reversed(range(_AGAIN)):
                    try:
                        await trials.carry_out(kind or KINDS[number % 3], seed, number)
                    except aioduco.DucoError as exc:
                        # Such as a heartbeat that a busy machine held up: nothing of zones.
                        trials.counts["begun again"] += 1
                        if left:
                            continue
                        failed[str(number)] = f"{type(exc).__name__}: {exc}".splitlines()[0]
                    except AssertionError as exc:
                        failed[str(number)] = str(exc).splitlines()[0]
                    break
    nearest = None if math.isinf(trials.nearest) else trials.nearest
    return Outcome(numbers[0], dict(trials.counts), trials.deepest, nearest, failed)


def block(numbers: range, seed: int) -> Outcome:
    """Carry out trials in this process."""
    logging.disable(logging.CRITICAL)  # that the arm is stopped is what is wanted
    wall, processor = time.monotonic(), time.process_time()
    found = asyncio.run(run(numbers, seed))
    found.wall, found.processor = time.monotonic() - wall, time.process_time() - processor
    return found


def blocks(options: argparse.Namespace, log: Path | None) -> Iterator[Outcome]:
    """Carry out all that were asked for, and give what came of each block."""
    if options.only is not None:
        yield block(range(options.only, options.only + 1), options.seed)
        return
    left = {
        first: range(first, min(options.count, first + BLOCK))
        for first in range(0, options.count, BLOCK)
    }
    if log is not None and log.exists():
        for line in log.read_text(encoding="utf-8").splitlines():
            known = json.loads(line)
            if known.pop("seed") == options.seed and left.pop(known["first"], None) is not None:
                yield Outcome(**known)
    with ProcessPoolExecutor(options.processes, max_tasks_per_child=1) as pool:
        waiting = {pool.submit(block, numbers, options.seed): numbers for numbers in left.values()}
        for future in as_completed(waiting):
            try:
                found = future.result()
            except Exception as exc:
                # such as a simulator that a busy machine did not let begin: the rest goes on
                lost = f"{type(exc).__name__}: {exc}".splitlines()[0]
                numbers = waiting[future]
                yield Outcome(numbers[0], {}, {}, None, dict.fromkeys(map(str, numbers), lost))
                continue
            if log is not None:
                with log.open("a", encoding="utf-8") as file:
                    file.write(json.dumps({"seed": options.seed, **vars(found)}) + "\n")
            yield found


def results(found: list[Outcome], seed: int) -> dict[str, Any]:
    """The figures of all blocks together."""
    counts: Counter[str] = sum((Counter(each.counts) for each in found), Counter())
    near = [each.nearest for each in found if each.nearest is not None]
    worst = {
        kind: [each.deepest[kind] for each in found if kind in each.deepest]
        for kind in sorted({kind for each in found for kind in each.deepest})
    }
    return {
        "trials": sum(counts[kind] for kind in KINDS),
        "failed": sum(len(each.failed) for each in found),
        "seed": seed,
        "set_points_sent": counts["set-points"],
        "least_margin_of_a_set_point_m": min(near, default=None),
        "processor_s": round(sum(each.processor for each in found)),
        "arm_beyond_a_zone": {
            kind: {
                "trials judged": counts[f"{kind} judged"],
                "deepest_mm": round(1000 * max(depth for depth, _ in depths), 3),
                "beyond what it may lag or take to stop_mm": round(
                    1000 * max(0.0, *(over for _, over in depths)), 3
                ),
            }
            for kind, depths in worst.items()
        },
        "what_became_of_them": [
            {"": what, "trials": number}
            for what, number in sorted(counts.items())
            if what not in KINDS and what != "set-points" and not what.endswith("judged")
        ],
    }


def main() -> int:
    """Run as many as were asked for, and print what came of them."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--count", type=int, default=300, help="how many (default: %(default)s)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", type=int, metavar="NUMBER", help="carry out this one alone")
    parser.add_argument("--processes", type=int, default=os.cpu_count())
    parser.add_argument("--log", type=Path, metavar="FILE", help="keep what is done there, go on")
    parser.add_argument("--save", action="store_true", help=f"write {RESULTS}")
    options = parser.parse_args()
    found = []
    for each in blocks(options, options.log):
        found.append(each)
        for number, what in each.failed.items():
            sys.stdout.write(f"FAILED  {number}: {what}\n")
        sys.stdout.flush()
    figures = results(found, options.seed)
    sys.stdout.write(json.dumps(figures, indent=2, ensure_ascii=False) + "\n")
    if options.save:
        sys.path.insert(0, str(RESULTS.parents[1]))
        figures = {"command": f".ci/envelope-trials --count {options.count} --save", **figures}
        path = import_module("_common").write_results(RESULTS.stem, figures)
        sys.stdout.write(f"written: {path}\n")
    return 1 if figures["failed"] else 0


if __name__ == "__main__":
    sys.exit(main())
