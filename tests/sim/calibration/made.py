"""Made-up recordings of an arm with known parameters."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import numpy as np

from aioduco.kinematics import arm
from aioduco.models.enums import RobotState
from aioduco.models.pose import Pose
from aioduco.models.rotation import Array
from aioduco.sim.calibration.evidence import Evidence, Motions, Poses, Reads, StateRead, TimedCall
from aioduco.sim.calibration.torques import link_torques
from aioduco.sim.physics.drives import TrailingDrives
from aioduco.sim.planner.path import JointSetPoint
from aioduco.sim.profile import GEOMETRY, ArmProfile, Estimate

MODEL = "gcr5_910"
READY = np.array([0.3, -0.2, 1.6, 0.1, -1.5, 0.4])
STEP, SPEED_STEP = 2.0**-17, 2.0**-10
NOTHING = np.zeros((0, 6))


def exact(value: float) -> Estimate:
    return Estimate.around(float(value), 0.0)


def hidden_geometry(random: np.random.Generator, model: str = MODEL) -> ArmProfile:
    """A random arm: each length off by up to 1 mm, each angle by up to 0.25°."""
    nominal = arm(model).geometry
    values = {}
    for name in GEOMETRY:
        column, joint = name[:-1], int(name[-1]) - 1
        span = 1e-3 if column in ("a", "d") else math.radians(0.25)
        values[name] = exact(getattr(nominal, column)[joint] + random.uniform(-span, span))
    return ArmProfile(model, {"geometry": values})


def configurations(random: np.random.Generator, count: int, reach: float = 0.5) -> Array:
    joints: Array = READY + random.uniform(-reach, reach, (count, 6))
    return joints


def poses_of(profile: ArmProfile, joints: Array) -> Poses:
    """Joints and poses as a controller gives them: in single precision."""
    flange = profile.arm.fkine(joints)
    told = [np.array(Pose.from_matrix(each), np.float32).tolist() for each in flange]
    single = joints.astype(np.float32).astype(float)
    return Poses(single, np.array([Pose(*each).matrix for each in told]))


def empty(name: str = "made.mcap") -> Evidence:
    none = np.zeros(0)
    reads = Reads(none, none, NOTHING)
    return Evidence(
        name,
        "GCR5 910",
        Poses(NOTHING, np.zeros((0, 4, 4))),
        Motions(none, NOTHING, NOTHING, NOTHING, NOTHING),
        *(reads, reads, (), ()),
    )


def turns(
    random: np.random.Generator,
    lag: Array,
    gain: Array,
    noise: Array,
    *,
    speeds: tuple[float, ...] = (0.15, 0.45, 0.8),
    rounds: int = 1,
    rate: int = 8,
) -> Motions:
    """Each joint turns there and back; samples every `rate` cycles of 1 ms, with their rounding.

    The drives do not depend on each other: all joints are turned at once, and what each of them did
    stands one after the other, with the others at rest.
    """
    together = _together(tuple(lag.tolist()), tuple(gain.tolist()), speeds, rounds)
    rest = np.array([READY, np.zeros(6), READY, np.zeros(6)])
    rows = np.concatenate([_one(together, rest, joint) for joint in range(6)])[rate - 1 :: rate]
    rows[:, 2] += noise * random.standard_normal((len(rows), 6))
    columns = zip(np.swapaxes(rows, 0, 1), (STEP, SPEED_STEP, STEP, SPEED_STEP), strict=True)
    times = 1e-3 * rate * np.arange(1.0, len(rows) + 1.0, dtype=np.float64)
    return Motions(times, *(np.round(column / step) * step for column, step in columns))


@cache
def _together(
    lag: tuple[float, ...], gain: tuple[float, ...], speeds: tuple[float, ...], rounds: int
) -> Array:
    """What is asked of all joints and what they do, cycle by cycle: several tests turn the same."""
    drives = TrailingDrives(list(lag), list(gain), 1e-3)
    q = 0.0
    turned = []
    for speed in speeds:
        for side in (0.3, -0.3) * rounds:
            for place, fast, hard in _trapezoid(side, speed, 5.0):
                wanted = READY + q + place
                there = drives.follow(JointSetPoint(wanted, np.full(6, fast), np.full(6, hard)))
                turned.append((wanted, np.full(6, fast), there.q, there.qd))
            q += side
    together: Array = np.array(turned)
    return together


def _one(together: Array, rest: Array, joint: int) -> Array:
    """What one joint did, with the others at rest."""
    alone = np.repeat(rest[None], len(together), axis=0)
    alone[:, :, joint] = together[:, :, joint]
    return alone


def _trapezoid(way: float, speed: float, hard: float) -> list[tuple[float, float, float]]:
    """Places, speeds and accelerations of a motion and the rest after it, cycle by cycle."""
    ramp, cruise = speed / hard, abs(way) / speed - speed / hard
    found = []
    place = 0.0
    for i in range(1, int((2 * ramp + cruise + 0.3) * 1000)):
        t = i * 1e-3
        fast = max(0.0, min(hard * t, speed, hard * (2 * ramp + cruise - t)))
        hardness = hard if t < ramp else -hard if ramp + cruise < t < 2 * ramp + cruise else 0.0
        place += fast * 1e-3
        sign = math.copysign(1.0, way)
        found.append((sign * min(place, abs(way)), sign * fast, sign * hardness))
    return found


def changes(
    random: np.random.Generator, times: dict[str, float]
) -> tuple[tuple[TimedCall, ...], tuple[StateRead, ...]]:
    """Calls that change the power, and reads of the state beside them, some of them late."""
    ends = {
        "disable": RobotState.DISABLE,
        "power_off": RobotState.POWER_OFF,
        "power_on": RobotState.DISABLE,
        "enable": RobotState.ENABLE,
    }
    now, state = 10.0, RobotState.ENABLE
    calls, states = [], []
    for _ in range(5):
        for name, end in ends.items():
            taken = random.uniform(0.0, 0.001)
            delay = random.uniform(0.0, 0.002)
            calls.append(TimedCall(name, now, now + taken + delay))
            change = now + taken + times[name]
            at = now
            while at < change + 0.03:
                began = at + random.uniform(0.0, 0.001)
                answered = began + random.exponential(0.001)
                seen = end if answered >= change else state
                ended = answered + random.exponential(0.002)
                states.append(StateRead(began, ended, seen))
                at = ended + random.uniform(0.0, 0.002)
            state, now = end, change + 1.0
    return tuple(calls), tuple(states)


def torqued(
    random: np.random.Generator,
    friction: tuple[Array, Array],
    load: tuple[float, Array],
) -> Evidence:
    """Turns of the joints with torques read beside them, and torques at rest."""
    motions = turns(random, np.zeros(6), np.full(6, 200.0), np.zeros(6))
    rest = np.repeat(configurations(random, 30), 60, axis=0)  # half a second at each
    still = np.zeros_like(rest)
    begin = float(motions.time[-1])
    time = np.concatenate([motions.time, begin + 0.008 * np.arange(1, len(rest) + 1)])
    joints = np.concatenate([motions.joints, rest])
    speed = np.concatenate([motions.speed, still])
    model, (mass, centre) = arm(MODEL), load
    flange = model.fkine(joints)
    lever = np.einsum("nij,j->ni", flange[:, :3, :3], centre)
    jacobian = model.jacobian(joints)
    lifting = jacobian[:, :3] + np.cross(jacobian[:, 3:], lever[:, :, None], axis=1)
    torque = link_torques(model, joints) + mass * 9.81 * lifting[:, 2]
    torque = torque + friction[0] * np.clip(speed / 5e-3, -1.0, 1.0) + friction[1] * speed
    torque = torque.astype(np.float32).astype(float)
    chosen = slice(0, None, 2)
    return replace(
        empty(),
        motions=Motions(time, joints, speed, joints, speed),
        torques=Reads(time[chosen] - 1e-3, time[chosen] + 1e-3, torque[chosen]),
    )
