"""What `aioduco calibrate` finds of simulated arms whose parameters are hidden from it.

    python benchmarks/calibration.py [--quick] [--save]    20 hidden arms, two at a time

Each arm is a simulator in a process of its own with a random profile: geometry, lag and gain of the
drives, noise, updates of readings, times of power, corners that blend, the heartbeat's slack, load,
friction, precision. `aioduco check --motions` moves and records it in real time, with fewer poses
than by default; then the recording alone gives a profile, which is compared with the hidden one. A
busy machine slows simulated time down, so that recorded times are not those of the profile: times
are tried in made-up time, too.
"""

from __future__ import annotations

import math
import multiprocessing
import statistics
import tempfile
from collections import defaultdict
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from itertools import repeat
from pathlib import Path
from typing import TYPE_CHECKING, Any

import anyio
import numpy as np
from _common import of_tests, parser, save, show

import aioduco.sync
from aioduco.cli.measuring import Extent, measure
from aioduco.models.enums import RobotState
from aioduco.sim import ArmProfile, Estimate, Simulator
from aioduco.sim.calibration import Calibration, calibrate
from aioduco.sim.calibration.evidence import Evidence, Motions, Reads, StateRead, TimedCall
from aioduco.sim.calibration.times import estimate_times
from aioduco.sim.calibration.torques import estimate_friction
from aioduco.sim.controller.power import PowerControl
from aioduco.sim.controller.tasks import TaskTable

if TYPE_CHECKING:
    from collections.abc import Sequence

# what the tests of the calibration make recordings with
made = of_tests("sim.calibration.made")
exact = made.exact

CYCLE = 1e-3  # of the simulated controller [s]
EXTENT = Extent(poses=28, rounds=1, changes=3)


def hidden(seed: int) -> ArmProfile:
    """A random profile."""
    random = np.random.default_rng(seed)

    def six(name: str, low: float, high: float) -> dict[str, Estimate]:
        return {f"{name}{i}": exact(random.uniform(low, high)) for i in range(1, 7)}

    geometry = made.hidden_geometry(random)
    lag = random.uniform(0.004, 0.03, 6)
    gain = random.uniform(0.4, 0.95, 6) / lag
    drives = {f"lag{i + 1}": exact(each) for i, each in enumerate(lag)}
    drives |= {f"gain{i + 1}": exact(each) for i, each in enumerate(gain)}
    times = {"power_on": (0.3, 1.5), "enable": (0.2, 1.0), "disable": (0.1, 0.4)}
    times["power_off"] = (0.1, 0.5)
    centre = {"x": (-0.05, 0.05), "y": (-0.05, 0.05), "z": (0.02, 0.1)}
    blends = {f"{kind}_reach": (0.5, 1.2) for kind in ("joint", "line")}
    blends |= {f"{kind}_share": (0.3, 0.9) for kind in ("joint", "line")}
    after = np.random.default_rng((seed, 1))  # those below were there before
    return ArmProfile(
        made.MODEL,
        {
            "blends": {name: exact(after.uniform(*span)) for name, span in blends.items()},
            "heartbeat": {"slack": exact(after.uniform(0.0, 1.5))},
            **geometry.values,
            "drives": drives,
            "noise": six("joint", 1e-5, 5e-5),
            "readings": {"period": exact(random.choice([0.0, 0.01, 0.016, 0.02]))},
            "times": {name: exact(random.uniform(*span)) for name, span in times.items()},
            "load": {
                "mass": exact(random.uniform(0.5, 3.0)),
                **{name: exact(random.uniform(*span)) for name, span in centre.items()},
            },
            "friction": six("dry", 0.5, 6.0) | six("viscous", 1.0, 8.0),
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


def watched(profile: ArmProfile, random: np.random.Generator, repeats: int = 5) -> Evidence:
    """Changes of power in made-up time, with reads of the state that come late by chance."""
    power = PowerControl(TaskTable())
    power.times.update({name: value for name, (value, _, _) in profile.values["times"].items()})
    power.state, cycles, calls, states = RobotState.ENABLE, 0, [], []

    def run_to(time: float) -> RobotState:
        nonlocal cycles
        while (cycles + 1) * 1e-3 <= time:
            cycles += 1
            power.tick(cycles * 1e-3, safe=True, standing=True)
        return power.state

    now = 1.0
    for name in ("disable", "power_off", "power_on", "enable") * repeats:
        came = now + random.exponential(5e-4)
        run_to(came)
        power.request(name)
        calls.append(TimedCall(name, now, came + random.exponential(5e-4)))
        at, until = calls[-1].end, math.inf
        while at < until:
            began, came = at, at + random.exponential(5e-4)
            state = run_to(came)
            at = came + random.exponential(1e-3)
            states.append(StateRead(began, at, state))
            if until == math.inf and not power.busy:
                until = at + 0.02
        now = at + 0.5
    found: Evidence = replace(made.empty(), calls=tuple(calls), states=tuple(states))
    return found


def made_up(seeds: Sequence[int]) -> dict[str, Any]:
    """How near times of power are that are found in made-up time."""
    kind: dict[str, list[float]] = defaultdict(list)
    for seed in seeds:
        profile = hidden(seed)
        found = estimate_times([watched(profile, np.random.default_rng(seed))])
        for name, (value, _, _) in profile.values["times"].items():
            judge(kind, value, found.values.get(name))
    return figures(kind)


def turned(profile: ArmProfile, random: np.random.Generator) -> Evidence:
    """Each joint there and back at three speeds, in made-up time, with errors of the torques.

    An error that is constant in a motion, as of an arm that still swings or warms up, and noise.
    """
    dry, viscous = (profile.six("friction", name, 0.0) for name in ("dry", "viscous"))
    rows: list[tuple[list[float], list[float], list[float]]] = []
    q = np.array([0.3, -0.2, 1.6, 0.1, -1.5, 0.4])
    for joint in range(6):
        for speed in (0.15, 0.45, 0.8):
            for side in (0.3, -0.3):
                own = 0.05 * random.standard_normal()
                way, unit = math.copysign(speed, side), np.eye(6)[joint]
                moving = [way] * round(abs(side) / speed / 0.008)
                for fast in [0.0] * 60 + moving:
                    q = q + fast * 0.008 * unit
                    torque = 5.0 * np.cos(q)
                    torque[joint] += dry[joint] * np.sign(fast) + viscous[joint] * fast
                    torque += (own if fast else 0.0) + 0.02 * random.standard_normal(6)
                    rows.append((q.tolist(), (fast * unit).tolist(), torque.tolist()))
    joints, speeds, torques = (np.array(column) for column in zip(*rows, strict=True))
    time = 0.008 * np.arange(len(rows), dtype=np.float64)
    found: Evidence = replace(
        made.empty(),
        motions=Motions(time, joints, speeds, joints, speeds),
        torques=Reads(time[::2] - 1e-3, time[::2] + 1e-3, torques[::2]),
    )
    return found


def made_up_friction(seeds: Sequence[int]) -> dict[str, Any]:
    """How often intervals of friction hold, by recordings in made-up time."""
    kinds: dict[str, dict[str, list[float]]] = defaultdict(lambda: defaultdict(list))
    for seed in seeds:
        profile = hidden(seed)
        found = estimate_friction([turned(profile, np.random.default_rng(seed))])
        for name, (value, _, _) in profile.values["friction"].items():
            judge(kinds[name.rstrip("123456")], value, found.values.get(name))
    return {name: figures(kind) for name, kind in kinds.items()}


def judge(kind: dict[str, list[float]], value: float, estimate: Estimate | None) -> None:
    """Note how an estimate, if there is one, compares with the hidden value."""
    if estimate is None:
        kind["left out"].append(1.0)
        return
    kind["error"].append(abs(estimate.value - value))
    kind["share"].append(abs(estimate.value - value) / max(abs(value), 1e-12))
    kind["half"].append(0.5 * (estimate.high - estimate.low))
    # The last digit of the file that the simulator reads is 10 digits behind.
    kind["inside"].append(float(estimate.low - 1e-9 <= value <= estimate.high + 1e-9))


def unit(section: str, name: str) -> str:
    """Name of a kind of values, which are judged together."""
    if section == "geometry":
        return "lengths [m]" if name[:-1] in ("a", "d") else "angles [rad]"
    return f"{section} {name.rstrip('123456').removeprefix('joint_').removeprefix('line_')}"


def compare(pairs: list[tuple[ArmProfile, Calibration]]) -> dict[str, dict[str, Any]]:
    """Errors and intervals by kind of value."""
    kinds: dict[str, dict[str, list[float]]] = defaultdict(lambda: defaultdict(list))
    for truth, found in pairs:
        for section, names in truth.values.items():
            for name, (hidden_value, _, _) in names.items():
                # Readings without a period change in each cycle of the controller.
                value = max(hidden_value, CYCLE) if section == "readings" else hidden_value
                judge(
                    kinds[unit(section, name)],
                    value,
                    found.profile.values.get(section, {}).get(name),
                )
    return {name: figures(kind) for name, kind in kinds.items()}


def figures(kind: dict[str, list[float]]) -> dict[str, Any]:
    """Errors and intervals of one kind of value."""
    found: dict[str, Any] = {"estimated": len(kind["error"]), "left_out": len(kind["left out"])}
    if kind["error"]:
        found["median_error"] = statistics.median(kind["error"])
        found["largest_error"] = max(kind["error"])
        found["largest_error_percent"] = 100.0 * max(kind["share"])
        found["median_half_width"] = statistics.median(kind["half"])
        found["inside_interval_percent"] = 100.0 * statistics.mean(kind["inside"])
    return found


def main() -> None:
    options = parser(__doc__).parse_args()
    seeds = range(100, 102 if options.quick else 120)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        # two beside each other: more would slow simulated time down on two cores
        with ProcessPoolExecutor(2, multiprocessing.get_context("spawn")) as pool:
            list(pool.map(record, seeds, repeat(folder)))
        pairs = [(hidden(seed), calibrate(folder / f"run{seed}.mcap")) for seed in seeds]
    kinds = compare(pairs) | {"times in made-up time [s]": made_up(seeds)}
    many = range(seeds.start, seeds.start + 10 * len(seeds))
    for name, kind in made_up_friction(many).items():
        kinds[f"friction {name} in made-up time"] = kind
    show("values in their units", kinds)
    save(options, "calibration", {"arms": len(pairs), "kinds": kinds})


if __name__ == "__main__":
    main()
