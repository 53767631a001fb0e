"""Inverse kinematics: what a pose costs, one by one and many at once, beside EAIK.

    python benchmarks/kinematics.py [--quick] [--save]

Each arm solves the same 1,000 poses by `Arm.ikine` (the nearest of all solutions, within limits)
and by `Arm.ikine_all`. With `pip install EAIK`, `Arm.ikine` as it was with EAIK runs in turn with
them, and all solutions are compared. Figures are processor time, the least of five rounds.
"""

from __future__ import annotations

import importlib.util
import time
from typing import TYPE_CHECKING, Any

import kinematics_eaik
import numpy as np
from _common import arguments, print_table, write_results

from aioduco.kinematics import Arm, arm, models
from aioduco.kinematics.forward import singular_values
from aioduco.kinematics.inverse import closed_form, wrap

if TYPE_CHECKING:
    from collections.abc import Callable

    from aioduco.models.rotation import Array

#: EAIK counts a solution nearer to a singularity than this twice, or not at all
REGULAR = 1e-3


def least(rounds: int, poses: int, works: dict[str, Callable[[], object]]) -> dict[str, float]:
    """Microseconds a pose of each work; they take turns, so that all meet the same machine."""
    figures = dict.fromkeys(works, float("inf"))
    for _ in range(rounds):
        for name, work in works.items():
            began = time.thread_time()
            work()
            figures[name] = min(figures[name], (time.thread_time() - began) / poses * 1e6)
    return figures


def costs(any_arm: Arm, flange: Array, near: Array, rounds: int, eaik: bool) -> dict[str, float]:
    """What a pose costs each way [µs], and the ratio to EAIK."""
    works: dict[str, Callable[[], object]] = {
        "ikine_us": lambda: [any_arm.ikine(pose, near) for pose in flange],
        "ikine_all_us": lambda: [any_arm.ikine_all(pose) for pose in flange],
        "many_at_once_us": lambda: closed_form(any_arm.geometry, flange),
    }
    if eaik:
        other = kinematics_eaik.EaikArm(any_arm)
        works["with_EAIK_us"] = lambda: [other.ikine(pose, near) for pose in flange]
    figures = {name: round(us, 2) for name, us in least(rounds, len(flange), works).items()}
    if eaik:
        figures["ratio"] = round(figures["ikine_us"] / figures["with_EAIK_us"], 3)
    return figures


def compare(any_arm: Arm, flange: Array, near: Array) -> dict[str, Any]:
    """Whether all solutions of EAIK are found, and how far they are from ours [rad]."""
    geometry, robot = any_arm.geometry, kinematics_eaik.robot_of(any_arm.geometry)
    before = kinematics_eaik.EaikArm(any_arm)
    eights = ours_more = missed = 0
    apart = nearest = exactness = 0.0
    for pose in flange:
        ours = any_arm.ikine_all(pose)
        exactness = max(exactness, float(np.abs(any_arm.fkine(ours) - pose).max()))
        if np.abs(singular_values(geometry, ours)).min() < REGULAR:
            continue
        theirs = kinematics_eaik.exact(robot, geometry, pose)
        eights += len(theirs) == 8
        ours_more += len(ours) > len(theirs)
        off = np.array([np.abs(wrap(ours - q)).max(axis=1).min() for q in theirs])
        missed += int((off > 1e-9).sum())
        apart = max(apart, float(off.max()))
        nearest = max(
            nearest, float(np.abs(any_arm.ikine(pose, near) - before.ikine(pose, near)).max())
        )
    return {
        "eight_by_EAIK": eights,
        "missed": missed,
        "ours_more": ours_more,
        "apart_rad": f"{apart:.1e}",
        "nearest_apart_rad": f"{nearest:.1e}",
        "own_fkine": f"{exactness:.1e}",
    }


def main() -> None:
    options = arguments(__doc__, "kinematics")
    poses, rounds = (200, 2) if options.quick else (1000, 5)
    eaik = importlib.util.find_spec("eaik") is not None
    if not eaik:
        print("EAIK is left out: pip install EAIK")
    solved, compared = {}, {}
    for model in models():
        any_arm = arm(model)
        rng = np.random.default_rng(0)
        flange, near = any_arm.fkine(rng.uniform(-3, 3, (poses, 6))), rng.uniform(-3, 3, 6)
        solved[model] = costs(any_arm, flange, near, rounds, eaik)
        if eaik:
            compared[model] = compare(any_arm, flange, near)
    for title, table in (("µs a pose", solved), ("The same solutions as EAIK", compared)):
        if table:
            rows = [[model, *figures.values()] for model, figures in table.items()]
            print_table(title, ["model", *next(iter(table.values()))], rows)
    if options.save:
        results = {"inverse_kinematics": solved} | ({"to_EAIK": compared} if compared else {})
        print(f"written: {write_results('kinematics', results)}")


if __name__ == "__main__":
    main()
