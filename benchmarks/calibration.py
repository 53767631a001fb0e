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
from functools import partial
from itertools import repeat
from pathlib import Path
from typing import TYPE_CHECKING, Any

import anyio
import numpy as np
from _common import of_tests, parser, report

import aioduco.sync
from aioduco.cli.measuring import Extent, measure
from aioduco.models.enums import RobotState
from aioduco.sim import ArmProfile, Estimate, Simulator
from aioduco.sim.calibration import Calibration, calibrate
from aioduco.sim.calibration.evidence import Evidence, Reads, StateRead, TimedCall
from aioduco.sim.calibration.times import estimate_times
from aioduco.sim.calibration.torques import estimate_friction
from aioduco.sim.controller.power import PowerControl
from aioduco.sim.controller.tasks import TaskTable

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    Estimates = Mapping[str, Estimate]

Kinds = dict[str, dict[str, list[float]]]

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


def watched(times: Estimates, random: np.random.Generator, repeats: int = 5) -> Evidence:
    """Changes of power in made-up time, with reads of the state that come late by chance."""
    power = PowerControl(TaskTable())
    power.times.update({name: value for name, (value, _, _) in times.items()})
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


def turned(friction: Estimates, random: np.random.Generator) -> Evidence:
    """Each joint there and back at three speeds, in made-up time, with errors of the torques.

    An error that is constant in a motion, as of an arm that still swings or warms up, and noise.
    """
    six = range(1, 7)
    dry, viscous = ([friction[f"{name}{i}"].value for i in six] for name in ("dry", "viscous"))
    motions = made.turns(random, np.zeros(6), np.full(6, 200.0), np.zeros(6))
    speed = motions.speed
    begins = np.diff(speed != 0.0, axis=0, prepend=False) & (speed != 0.0)
    own = 0.05 * random.standard_normal(speed.shape)  # one of these for each motion
    torque = 5.0 * np.cos(motions.joints) + 0.02 * random.standard_normal(speed.shape)
    torque += np.array(dry) * np.sign(speed) + np.array(viscous) * speed
    torque += np.where(speed == 0.0, 0.0, np.take_along_axis(own, np.cumsum(begins, axis=0), 0))
    times = motions.time[::2]
    found: Evidence = replace(
        made.empty(), motions=motions, torques=Reads(times - 1e-3, times + 1e-3, torque[::2])
    )
    return found


def unit(section: str, name: str, note: str = "") -> str:
    """Name of a kind of values, which are judged together."""
    if section == "geometry":
        return "lengths [m]" if name[:-1] in ("a", "d") else "angles [rad]"
    kind = name.rstrip("123456").removeprefix("joint_").removeprefix("line_")
    return f"{section} {kind}{note}"


def judge(
    kinds: Kinds, kind_of: Callable[[str], str], truth: Estimates, found: Estimates | None
) -> None:
    """Note how the estimates of a section, where there are any, compare with the hidden values."""
    for name, (value, _, _) in truth.items():
        kind, estimate = kinds[kind_of(name)], (found or {}).get(name)
        if estimate is None:
            kind["left out"].append(1.0)
            continue
        kind["error"].append(abs(estimate.value - value))
        kind["half"].append(0.5 * (estimate.high - estimate.low))
        # The last digit of the file that the simulator reads is 10 digits behind.
        kind["inside"].append(float(estimate.low - 1e-9 <= value <= estimate.high + 1e-9))


def compare(kinds: Kinds, truth: ArmProfile, found: Calibration) -> None:
    """Judge all that one recording gave."""
    hidden_values = dict(truth.values)
    # Readings without a period change in each cycle of the controller.
    period = max(hidden_values["readings"]["period"].value, CYCLE)
    hidden_values["readings"] = {"period": exact(period)}
    for section, values in hidden_values.items():
        judge(kinds, partial(unit, section), values, found.profile.values.get(section))


def made_up(kinds: Kinds, seeds: Sequence[int]) -> None:
    """Judge times of power and friction by evidence in made-up time; friction of ten times as many.

    It tells how often intervals of friction hold.
    """
    for seed in range(seeds[0], seeds[0] + 10 * len(seeds)):
        values, random = hidden(seed).values, partial(np.random.default_rng, seed)
        times, friction = values["times"], values["friction"]
        if seed in seeds:
            estimate = estimate_times([watched(times, random())])
            judge(kinds, lambda _: "times in made-up time [s]", times, estimate.values)
        estimate = estimate_friction([turned(friction, random())])
        kind_of = partial(unit, "friction", note=" in made-up time")
        judge(kinds, kind_of, friction, estimate.values)


def figures(kind: dict[str, list[float]]) -> dict[str, Any]:
    """Errors and intervals of one kind of value."""
    found: dict[str, Any] = {"estimated": len(kind["error"]), "left_out": len(kind["left out"])}
    if kind["error"]:
        found["median_error"] = statistics.median(kind["error"])
        found["largest_error"] = max(kind["error"])
        found["median_half_width"] = statistics.median(kind["half"])
        found["inside_interval_percent"] = 100.0 * statistics.mean(kind["inside"])
    return found


def main() -> None:
    options = parser(__doc__).parse_args()
    seeds = range(100, 102 if options.quick else 120)
    kinds: Kinds = defaultdict(lambda: defaultdict(list))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        # two beside each other: more would slow simulated time down on two cores
        with ProcessPoolExecutor(2, multiprocessing.get_context("spawn")) as pool:
            list(pool.map(record, seeds, repeat(folder)))
        for seed in seeds:
            compare(kinds, hidden(seed), calibrate(folder / f"run{seed}.mcap"))
    made_up(kinds, seeds)
    found = {name: figures(kind) for name, kind in kinds.items()}
    report(options, "calibration", {"arms": len(seeds), "kinds": found})


if __name__ == "__main__":
    main()
