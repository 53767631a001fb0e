"""What `aioduco calibrate` finds of simulated arms whose parameters are hidden from it.

    python benchmarks/calibration.py                       20 hidden arms, one after the other
    python benchmarks/calibration.py --beside 2 --save     two at a time, and keep the result
    python benchmarks/calibration.py --kept FOLDER         only estimate, from kept recordings

Each arm is a simulator in a process of its own with a random profile: geometry, lag and gain of the
drives, noise, updates of readings, times of power, load, friction, precision. `aioduco check
--motions` moves and records it in real time, with fewer poses than by default; then the recording
alone gives a profile, which is compared with the hidden one. Random numbers depend on the seed.
"""

from __future__ import annotations

import argparse
import math
import statistics
import subprocess
import sys
import tempfile
from collections import defaultdict
from pathlib import Path
from typing import Any

import anyio
import numpy as np
from _common import machine, scheduling, write_results

import aioduco.sync
from aioduco.cli.measuring import Extent, measure
from aioduco.kinematics import arm
from aioduco.sim import ArmProfile, Estimate, Simulator
from aioduco.sim.calibration import Calibration, calibrate
from aioduco.sim.profile import GEOMETRY

MODEL = "gcr5_910"
EXTENT = Extent(poses=28, rounds=1, changes=3)


def hidden(seed: int) -> ArmProfile:
    """A random profile."""
    random = np.random.default_rng(seed)

    def exact(value: float) -> Estimate:
        return Estimate.around(float(value), 0.0)

    def six(name: str, low: float, high: float) -> dict[str, Estimate]:
        return {f"{name}{i}": exact(random.uniform(low, high)) for i in range(1, 7)}

    nominal = arm(MODEL).geometry
    geometry = {}
    for name in GEOMETRY:
        column, joint = name[:-1], int(name[-1]) - 1
        span = 1e-3 if column in ("a", "d") else math.radians(0.25)
        geometry[name] = exact(getattr(nominal, column)[joint] + random.uniform(-span, span))
    lag = random.uniform(0.004, 0.03, 6)
    gain = random.uniform(0.4, 0.95, 6) / lag
    drives = {f"lag{i + 1}": exact(each) for i, each in enumerate(lag)}
    drives |= {f"gain{i + 1}": exact(each) for i, each in enumerate(gain)}
    times = {"power_on": (0.3, 1.5), "enable": (0.2, 1.0), "disable": (0.1, 0.4)}
    times["power_off"] = (0.1, 0.5)
    centre = {"x": (-0.05, 0.05), "y": (-0.05, 0.05), "z": (0.02, 0.1)}
    return ArmProfile(
        MODEL,
        {
            "geometry": geometry,
            "drives": drives,
            "noise": six("joint", 1e-5, 5e-5),
            "readings": {"period": exact(random.choice([0.0, 0.01, 0.016, 0.02]))},
            "times": {name: exact(random.uniform(*span)) for name, span in times.items()},
            "load": {
                "mass": exact(random.uniform(0.5, 3.0)),
                **{name: exact(random.uniform(*span)) for name, span in centre.items()},
            },
            "friction": six("coulomb", 0.5, 6.0) | six("viscous", 1.0, 8.0),
        },
        bool(random.integers(2)),
    )


def record(seed: int, folder: Path) -> None:
    """Record a simulated arm with the profile of a seed."""
    profile = folder / f"hidden{seed}.toml"
    hidden(seed).save(profile)
    with Simulator.spawn(profile=str(profile), seed=seed) as sim:
        with aioduco.sync.connect(sim.host, sim.port) as robot:
            robot.bring_up()
        anyio.run(
            measure,
            *(sim.host, sim.port, folder / f"run{seed}.mcap", EXTENT),
            lambda text: print(f"{seed}: {text}", flush=True),
        )


def unit(section: str, name: str) -> str:
    """Name of a kind of values, which are judged together."""
    if section == "geometry":
        return "lengths [m]" if name[:-1] in ("a", "d") else "angles [rad]"
    return f"{section} {name.rstrip('123456')}"


def compare(pairs: list[tuple[ArmProfile, Calibration]]) -> dict[str, Any]:
    """Errors and intervals by kind of value."""
    kinds: dict[str, dict[str, list[float]]] = defaultdict(lambda: defaultdict(list))
    for truth, found in pairs:
        for section, names in truth.values.items():
            for name, (value, _, _) in names.items():
                kind = kinds[unit(section, name)]
                estimate = found.profile.values.get(section, {}).get(name)
                if estimate is None:
                    kind["left out"].append(1.0)
                    continue
                kind["error"].append(abs(estimate.value - value))
                kind["share"].append(abs(estimate.value - value) / max(abs(value), 1e-12))
                kind["half"].append(0.5 * (estimate.high - estimate.low))
                # The last digit of the file that the simulator reads is 10 digits behind.
                kind["inside"].append(float(estimate.low - 1e-9 <= value <= estimate.high + 1e-9))
    result = {}
    for name, kind in kinds.items():
        result[name] = {"estimated": len(kind["error"]), "left_out": len(kind["left out"])}
        if kind["error"]:
            result[name] |= {
                "error_p50": statistics.median(kind["error"]),
                "error_max": max(kind["error"]),
                "relative_error_max": max(kind["share"]),
                "half_width_p50": statistics.median(kind["half"]),
                "inside_interval": statistics.mean(kind["inside"]),
            }
    inside = [each for kind in kinds.values() for each in kind["inside"]]
    result["all"] = {"estimated": len(inside), "inside_interval": statistics.mean(inside)}
    known = [truth.single_precision == found.profile.single_precision for truth, found in pairs]
    result["single precision"] = {"right": sum(known), "of": len(known)}
    return result


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--arms", type=int, default=20)
    parser.add_argument("--first", type=int, default=100, help="first seed")
    parser.add_argument("--beside", type=int, default=1, help="arms at a time")
    parser.add_argument("--kept", type=Path, help="folder of recordings, kept or to be kept")
    parser.add_argument("--one", type=int, help=argparse.SUPPRESS)
    parser.add_argument("--save", action="store_true")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = given.kept or Path(temporary)
        folder.mkdir(exist_ok=True)
        if given.one is not None:
            record(given.one, folder)
            return
        seeds = range(given.first, given.first + given.arms)
        missing = [seed for seed in seeds if not (folder / f"run{seed}.mcap").exists()]
        for i in range(0, len(missing), given.beside):
            running = [
                subprocess.Popen(
                    [sys.executable, __file__, "--one", str(seed), "--kept", str(folder)]
                )
                for seed in missing[i : i + given.beside]
            ]
            for process in running:
                process.wait()
        pairs = [
            (hidden(seed), calibrate(folder / f"run{seed}.mcap"))
            for seed in seeds
            if (folder / f"run{seed}.mcap").exists()
        ]
    result = {"arms": len(pairs), "kinds": compare(pairs)}
    for name, kind in result["kinds"].items():
        print(name, {key: round(value, 7) for key, value in kind.items()})
    if given.save:
        write_results("calibration", machine() | {"scheduling": scheduling()} | result)


if __name__ == "__main__":
    main()
