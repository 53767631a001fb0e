"""Steps a second of the environments of Gymnasium, beside panda-gym's in the same run.

    python benchmarks/gym.py                   in one and in two processes
    chrt -r 5 python benchmarks/gym.py --save  and keep the result

Rounds of ours and of theirs take turns, so that what else the machine does meets both; each figure
is the median of the rounds. panda-gym is measured where it is installed; its steps are 40 ms as
well, and its physics Bullet's.
"""

from __future__ import annotations

import contextlib
import importlib
import statistics
import time
from typing import Any

import gymnasium
from _common import in_turns, parser, report

import aioduco.integrations.gym  # noqa: F401 - registers the names

OURS = {"reach": "aioduco/Reach-v0", "push": "aioduco/Push-v0"}
THEIRS = {"reach": "PandaReach-v3", "push": "PandaPush-v3"}


def several(name: str, processes: int) -> Any:
    mode: Any = "sync" if processes == 1 else "async"
    made: Any = gymnasium.make_vec(name, processes, mode, max_episode_steps=1_000_000)
    made.reset(seed=1)
    made.action_space.seed(1)
    return made


def rate(made: Any, steps: int) -> float:
    """Steps of all processes together, in a second."""
    actions = [made.action_space.sample() for _ in range(steps)]
    begun = time.perf_counter()
    for action in actions:
        made.step(action)
    return float(steps * made.num_envs) / (time.perf_counter() - begun)


def main() -> None:
    options = parser(__doc__).parse_args()
    rounds, steps = (2, 40) if options.quick else (8, 400)
    kinds = {"aioduco": OURS}
    with contextlib.suppress(ImportError):
        importlib.import_module("panda_gym")
        kinds["panda-gym"] = THEIRS
    result: dict[str, Any] = {}
    for task in OURS:
        for processes in (1, 2):
            made = {kind: several(names[task], processes) for kind, names in kinds.items()}
            for each in made.values():
                rate(each, 10)
            rates: dict[str, list[float]] = {kind: [] for kind in made}
            for kind, each in in_turns(rounds, made):
                rates[kind].append(rate(each, steps))
            for each in made.values():
                each.close()
            figures: dict[str, Any] = {
                f"{kind}, steps/s": round(statistics.median(all_)) for kind, all_ in rates.items()
            }
            if len(rates) > 1:
                ours, theirs = rates.values()
                shares = [one / other for one, other in zip(ours, theirs, strict=True)]
                figures["ours to theirs, p50"] = round(statistics.median(shares), 2)
                figures["at the least"] = round(min(shares), 2)
            result[f"{task}, {processes} process{'es' * (processes > 1)}"] = figures
    wire = several("aioduco/Reach-wire-v0", 1)
    rate(wire, 10)
    result["reach over the wire, 1 process"] = {"aioduco, steps/s": round(rate(wire, steps))}
    wire.close()
    results = {"steps a second, of all processes together": result}
    report(options, "gym", {"steps a round": steps, "rounds": rounds, **results})


if __name__ == "__main__":
    main()
