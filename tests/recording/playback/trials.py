"""Plays recordings that were made beside two burning processes, and compares the motion.

    .ci/play-trials [--count 20] [--seed 1] [--burning 2] [--bridge 0.005] [--keep FOLDER]

Each trial moves an arm at random, twice: a simulator in a process of its own, which is recorded
while others burn; and one that nothing disturbs, which tells where the arm was. A recording is
right if it can be played, and if the path and the arm that plays it stay near that way.
"""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import math
import multiprocessing
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

import aioduco
from aioduco import Tolerances
from aioduco.kinematics import arm
from aioduco.recording import read
from aioduco.recording.playback import RecordedPath, check_path, play
from aioduco.sim import Simulator

Array = NDArray[np.float64]

MODEL = "gcr5_910"
START = np.array([0.0, 0.0, math.pi / 2, 0.0, -math.pi / 2, 0.0])
MOTIONS = 3
#: largest distance of the path, and of the arm that plays it, from where the arm was [rad]
NEAR = 2e-3


def say(line: str) -> None:
    """Write a line at once."""
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


def burn() -> None:
    """Do nothing, as fast as possible."""
    while True:
        pass


@contextlib.contextmanager
def burning(count: int) -> Iterator[None]:
    """Processes that burn, in a block."""
    context = multiprocessing.get_context("spawn")
    processes = [context.Process(target=burn, daemon=True) for _ in range(count)]
    for process in processes:
        process.start()
    try:
        yield
    finally:
        for process in processes:
            process.kill()
            process.join()


async def move(robot: aioduco.Robot, seed: int, number: int) -> None:
    """The motions of a trial."""
    chance = np.random.default_rng([seed, number])
    for _ in range(MOTIONS):
        v, a = chance.uniform(0.3, 1.5), chance.uniform(1.0, 4.0)
        # shoulder and elbow less, so that the hand stays above the floor
        target = START + chance.uniform(-0.6, 0.6, 6) * (1.0, 0.5, 0.5, 1.0, 1.0, 1.0)
        await robot.motion.movej2(target, v=float(v), a=float(a))


async def recorded(file: Path, seed: int, number: int) -> None:
    """Move an arm, and record it."""
    with Simulator.spawn(model=MODEL, joints=list(START)) as sim:
        robot = aioduco.connect(sim.host, sim.port, state_rate=125, record=file, heartbeat=10.0)
        async with robot:
            await robot.bring_up()
            await move(robot, seed, number)


def observed(sim: Simulator) -> list[tuple[float, ...]]:
    """Where an arm is after each cycle from now on."""
    rows: list[tuple[float, ...]] = []

    def see(snapshot: Any, _: object) -> None:
        rows.append(tuple(snapshot.q))

    sim.observe(see)
    return rows


async def undisturbed(seed: int, number: int) -> Array:
    """Where the arm is in each cycle [rad]. Shape (n, 6)."""
    with Simulator(model=MODEL, joints=START, speed=20.0) as sim:
        rows = observed(sim)
        async with aioduco.connect(sim.host, sim.port, clock=sim.clock) as robot:
            await robot.bring_up()
            await move(robot, seed, number)
    return np.array(rows)


async def played(path: RecordedPath) -> Array:
    """Where an arm is that plays a path [rad]. Shape (n, 6)."""
    patient = Tolerances(path=0.0, goal=5e-3, goal_time=30.0)
    with Simulator(model=MODEL, joints=path.start.array) as sim:
        rows = observed(sim)
        async with aioduco.connect(sim.host, sim.port, clock=sim.clock, heartbeat=10.0) as robot:
            await robot.bring_up()
            await play(robot, path, tolerances=patient)
    return np.array(rows)


def farthest(points: Array, way: Array) -> float:
    """Largest distance of a joint from a way, for any of the points [rad]."""
    index = np.arange(0.0, len(way) - 1, 0.1)  # steps of some 0.1 mrad
    dense = np.column_stack([np.interp(index, np.arange(len(way)), q) for q in way.T])
    tree = scipy.spatial.cKDTree(dense)
    return float(np.max(tree.query(points, p=np.inf)[0]))


def trial(file: Path, seed: int, number: int, burners: int, bridge: float) -> str:
    """One trial. Returns what is wrong with it; empty if nothing is."""
    with burning(burners):
        asyncio.run(recorded(file, seed, number))
    path = RecordedPath.of(read(file), bridge=bridge)
    found = check_path(path, arm(MODEL))
    if found:
        return f"it cannot be played: {found[0]}"
    way = asyncio.run(undisturbed(seed, number))
    off = farthest(path.at(np.arange(0.0, path.duration, 0.004)), way)
    arms = farthest(asyncio.run(played(path))[::4], way)
    longest = float(np.diff(path.recorded).max())
    say(
        f"{number:3}: path {off * 1e3:.2f} mrad off, played {arms * 1e3:.2f}; {longest:.3f} s "
        f"between two samples at most, {len(path.gaps)} gaps bridged"
    )
    return "" if max(off, arms) <= NEAR else "it is played too far off"


def main() -> int:
    """Make the trials; returns how many failed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--burning", type=int, default=2)
    parser.add_argument("--bridge", type=float, default=0.005)
    parser.add_argument("--keep", type=Path)
    asked = parser.parse_args()
    failed = 0
    with contextlib.ExitStack() as stack:
        folder = asked.keep or Path(stack.enter_context(tempfile.TemporaryDirectory()))
        folder.mkdir(exist_ok=True)
        for number in range(asked.count):
            file = folder / f"{number}.mcap"
            file.unlink(missing_ok=True)
            try:
                wrong = trial(file, asked.seed, number, asked.burning, asked.bridge)
            except aioduco.DucoError as exc:
                wrong = str(exc)
            if wrong:
                failed += 1
                say(f"{number:3}: {wrong}")
    good = asked.count - failed
    say(f"{good} of {asked.count} recordings are played within {NEAR * 1e3:g} mrad")
    return failed


if __name__ == "__main__":
    sys.exit(main())
