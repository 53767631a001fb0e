"""LeRobot's own commands on simulated arms, and what must come out; see .ci/integrations."""
# The figures go to benchmarks/results/lerobot.json by --save.

from __future__ import annotations

import argparse
import math
import multiprocessing
import os
import subprocess
import sys
import threading
import time
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np

import aioduco.recording
import aioduco.sync
from aioduco.recording.tap import Tap, TappedCall
from aioduco.sim import Simulator

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "benchmarks"))
from _common import write_results
from streaming import Lateness, bare_loop

READY = [0.0, 0.0, 1.57, 0.0, -1.57, 0.0]
FAR = [0.3, 0.1, 1.45, 0.1, -1.5, 0.3]
NAMES = [f"joint_{number}.pos" for number in range(1, 7)]
NEAR = 1e-3  # rad
FPS, EPISODES = 30, 3
TRIES = 5  # of a replay on a machine that does not let the stream have its ticks
Figures = dict[str, dict[str, Any]]
V, A, JERK, RATE = 1.0, 5.0, 50.0, 500.0
# A leader that is looked at 30 times a second has an uneven speed; with less than this the arm
# swings about it by some mrad.
FOLLOWING_A, FOLLOWING_JERK = 20.0, 1000.0


def say(text: str) -> None:
    print(text, flush=True)


def check(what: str, good: bool) -> None:
    say(f"{'ok  ' if good else 'FAIL'} {what}")
    if not good:
        sys.exit(1)


def command(name: str, *arguments: str) -> None:
    """Run one of LeRobot's commands, as it was installed."""
    program = Path(sys.executable).with_name(name)
    begin = time.monotonic()
    done = subprocess.run(
        [str(program), *arguments],
        check=False,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        timeout=900,
    )
    if done.returncode:
        say(done.stdout[-3000:] + done.stderr[-6000:])
    check(f"{name} ended well after {time.monotonic() - begin:.0f} s", done.returncode == 0)


def moving(sim: Any) -> aioduco.sync.Robot:
    """A robot that is led by a machine which has other things to do as well."""
    return aioduco.sync.connect(
        sim.host,
        sim.port,
        heartbeat=30.0,
        loop_stall_limit=30.0,
        call_timeout=30.0,
        lag_limit=None,
    )


class Leading:
    """Something that moves the leader arm to and fro, until it is told to end."""

    def __init__(self, sim: Any) -> None:
        self._sim = sim
        self._end = threading.Event()
        self._thread = threading.Thread(target=self._run)

    def _run(self) -> None:
        with moving(self._sim) as robot:
            robot.bring_up()
            while not self._end.is_set():
                for goal in (FAR, READY):
                    robot.motion.movej2(goal, v=0.2, a=0.5)

    def __enter__(self) -> Leading:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._end.set()
        self._thread.join()


def joints_of(sim: Any) -> np.ndarray:
    with aioduco.sync.connect(sim.host, sim.port, heartbeat=None, lag_limit=None) as robot:
        return np.array(robot.state.get_actual_joints_position())


def robot_of(sim: Any, *more: str) -> list[str]:
    return [
        "--robot.type=duco", f"--robot.host={sim.host}", f"--robot.port={sim.port}",
        f"--robot.v={V}", f"--robot.a={FOLLOWING_A}", f"--robot.jerk={FOLLOWING_JERK}",
        "--robot.heartbeat=30", "--robot.timeout=20", "--robot.max_age=10", *more,
    ]  # fmt: skip


def leader_of(sim: Any) -> list[str]:
    return [
        "--teleop.type=duco_leader", f"--teleop.host={sim.host}", f"--teleop.port={sim.port}",
        "--teleop.guide=false", "--teleop.max_age=10",
    ]  # fmt: skip


def away(values: np.ndarray, samples: np.ndarray) -> float:
    """The largest distance of values from the nearest of the samples [rad]."""
    return max(float(np.abs(samples - value).max(axis=1).min()) for value in values)


def recorded(follower: Any, leader: Any, work: Path, figures: Figures) -> tuple[Any, np.ndarray]:
    """A data set by lerobot-record, loaded again and compared with what the arms did."""
    root, kept = work / "dataset", work / "record.mcap"
    with Leading(leader):
        command(
            "lerobot-record",
            *robot_of(follower, f"--robot.record={kept}"),
            *leader_of(leader),
            "--dataset.repo_id=local/duco", f"--dataset.root={root}",
            "--dataset.single_task=follow the leader", f"--dataset.fps={FPS}",
            f"--dataset.num_episodes={EPISODES}", "--dataset.episode_time_s=6",
            "--dataset.reset_time_s=2", "--dataset.push_to_hub=false", "--dataset.video=false",
            "--play_sounds=false",
        )  # fmt: skip
    from lerobot.datasets.lerobot_dataset import LeRobotDataset  # noqa: PLC0415

    dataset = LeRobotDataset("local/duco", root=root)
    check(
        f"the data set loads: {dataset.num_episodes} episodes, {dataset.num_frames} frames at "
        f"{dataset.fps} Hz",
        dataset.num_episodes == EPISODES and dataset.fps == FPS and dataset.num_frames > 90,
    )
    for what in ("action", "observation.state"):
        names = dataset.features[what]["names"]
        check(f"{what}: {', '.join(names)}", list(names) == NAMES)
    table = dataset.hf_dataset.with_format("numpy")
    actions = np.array(table["action"], dtype=float)
    states = np.array(table["observation.state"], dtype=float)
    episodes = np.array(table["episode_index"])
    seen = aioduco.recording.read(kept).arrays("/joint_states")["position"]
    watched = away(states, seen)
    check(f"each observation is where the arm was, within {watched * 1e3:.3f} mrad", watched < NEAR)
    # The leader goes on a straight line in joint space.
    way = np.array(FAR) - READY
    share = np.clip((actions - READY) @ way / (way @ way), 0, 1)
    led = float(np.abs(actions - (np.array(READY) + share[:, None] * way)).max())
    check(f"each action is where the leader was, within {led * 1e3:.3f} mrad", led < NEAR)
    check(f"the leader moved by {np.ptp(actions, axis=0).max():.2f} rad", np.ptp(actions) > 0.05)
    last = actions[np.flatnonzero(episodes == EPISODES - 1)[-1]]
    end = float(np.abs(joints_of(follower) - last).max())
    check(f"the arm stands at the last action, within {end * 1e3:.3f} mrad", end < NEAR)
    figures["observations, from where the arm was"] = {"worst_mrad": watched * 1e3}
    figures["actions, from where the leader was"] = {"worst_mrad": led * 1e3}
    figures["the arm at the end, from the last action"] = {"worst_mrad": end * 1e3}
    return dataset, actions


def replayed(
    follower: Any, dataset: Any, actions: np.ndarray, work: Path, figures: Figures
) -> None:
    """Each episode by lerobot-replay: the arm goes by each action, and stands at the last one."""
    episodes = np.array(dataset.hf_dataset.with_format("numpy")["episode_index"])
    for episode in range(EPISODES):
        rows = actions[episodes == episode]
        for number in range(1, TRIES + 1):
            with moving(follower) as robot:
                robot.bring_up()
                robot.motion.movej2(rows[0].tolist(), v=0.5, a=1.0)
            kept = work / f"replay{episode}_{number}.mcap"
            command(
                "lerobot-replay",
                *robot_of(follower, f"--robot.record={kept}"),
                "--dataset.repo_id=local/duco", f"--dataset.root={dataset.root}",
                f"--dataset.episode={episode}", "--play_sounds=false",
            )  # fmt: skip
            worst = float(np.abs(joints_of(follower) - rows[-1]).max())
            run = aioduco.recording.read(kept)
            seen = run.arrays("/joint_states")["position"]
            # Between two samples of the state, too: the arm goes on a line from one to the next.
            fine = np.vstack([seen[:-1] + (seen[1:] - seen[:-1]) * k / 8 for k in range(8)])
            off = away(rows, fine)
            # Ticks that the machine did not let the stream have are time that the arm lacks.
            ended = run.arrays("/streams")
            missed = float(ended["missed"][-1] / (ended["missed"][-1] + ended["ticks"][-1]))
            if max(worst, off) < NEAR or not missed or number == TRIES:
                break
            say(
                f"     episode {episode}: {off * 1e3:.3f} mrad, but {missed:.1%} of the ticks were "
                "not served on this machine: once more"
            )
        check(
            f"episode {episode} is replayed: the arm stands at its last action within "
            f"{worst * 1e3:.3f} mrad, and went by each within {off * 1e3:.3f} mrad "
            f"({missed:.2%} of the ticks missed)",
            max(worst, off) < NEAR,
        )
        figures[f"episode {episode} replayed, from its actions"] = {
            "worst_mrad": max(worst, off) * 1e3
        }


def teleoperated(follower: Any, leader: Any, figures: Figures) -> None:
    """lerobot-teleoperate: the arm comes to stand where the leader is."""
    with moving(leader) as robot:
        robot.bring_up()
        robot.motion.movej2(FAR, v=0.5, a=1.0)
    command(
        "lerobot-teleoperate",
        *robot_of(follower),
        *leader_of(leader),
        f"--fps={FPS}",
        "--teleop_time_s=6",
    )
    worst = float(np.abs(joints_of(follower) - joints_of(leader)).max())
    check(f"the follower stands where the leader does, within {worst * 1e3:.3f} mrad", worst < NEAR)
    figures["the follower, from its leader"] = {"worst_mrad": worst * 1e3}


def environments() -> None:
    """LeRobot's factory makes the environments, and what they give is what they declare."""
    from lerobot.configs.types import FeatureType  # noqa: PLC0415
    from lerobot.envs.configs import EnvConfig  # noqa: PLC0415
    from lerobot.envs.factory import make_env  # noqa: PLC0415
    from lerobot.envs.utils import (  # noqa: PLC0415
        close_envs,
        env_to_policy_features,
        preprocess_observation,
    )
    from lerobot.utils.import_utils import register_third_party_plugins  # noqa: PLC0415

    register_third_party_plugins()
    kind = EnvConfig.get_choice_class("duco")
    for task in ("Reach", "Push", "PickPlace", "Press", "Reach-wire"):
        config = kind(task=task)
        made = make_env(config, n_envs=2)
        (env,) = made["duco"].values()
        seen, _ = env.reset(seed=[1, 2])
        shapes = {}
        for _ in range(5):
            seen, reward, _, _, info = env.step(env.action_space.sample())
            shapes = {
                key: tuple(value.shape[1:]) for key, value in preprocess_observation(seen).items()
            }
        declared = {
            key: feature.shape
            for key, feature in env_to_policy_features(config).items()
            if feature.type is not FeatureType.ACTION
        }
        action = config.features["action"].shape == env.single_action_space.shape
        said = env.call("task_description")
        check(
            f"environment {task}: {shapes}, actions {env.single_action_space.shape}, {said[0]!r}",
            shapes == declared
            and action
            and len(said) == 2
            and reward.shape == (2,)
            and "is_success" in info
            and env.call("_max_episode_steps") == (config.episode_length,) * 2,
        )
        close_envs(made)


def busy(seconds: float) -> None:
    """Compute, as a network does, and hold the interpreter."""
    until, value = time.perf_counter() + seconds, 1.0
    while time.perf_counter() < until:
        value = math.sqrt(value + 1.0)


def policy_loop(host: str, port: int, seconds: float, answer: Any) -> None:
    """LeRobot's loop at 30 Hz: observe, think for 20 ms, act. Runs in a process of its own."""
    from lerobot.utils.robot_utils import precise_sleep  # noqa: PLC0415
    from lerobot_robot_duco import Duco, DucoConfig  # noqa: PLC0415

    robot = Duco(DucoConfig(id="trial", host=host, port=port, v=V, a=A, jerk=JERK, rate=RATE))
    robot.connect()
    start = robot.get_observation()
    begin, steps, late = time.perf_counter(), 0, 0
    while (now := time.perf_counter()) - begin < seconds:
        robot.get_observation()
        busy(0.020)
        moment = now - begin
        turn = 0.15 * (1 - math.cos(1.5 * moment))
        robot.send_action({name: angle + turn for name, angle in start.items()})
        left = 1 / FPS - (time.perf_counter() - now)
        late += left < 0
        precise_sleep(max(left, 0.0))
        steps += 1
    found = robot.statistics()
    robot.disconnect()
    answer.put((steps, late, found.as_dict()))


def looped(sim: Any, seconds: float) -> tuple[dict[str, Any], list[Lateness], np.ndarray]:
    """Run the loop through a tap, beside loops that only sleep to their ticks.

    One of them is on any processor, as the stream's worker is, and one on each.

    Returns:
        Figures of the loop and of its stream, the bare loops, and the set-points.
    """
    context = multiprocessing.get_context("spawn")
    answers, points = context.Queue(), []
    with Tap(sim.host, sim.port) as tap:

        def listen() -> None:
            points.extend(
                np.array(next(iter(item.arguments.values())), dtype=float)
                for item in tap
                if isinstance(item, TappedCall) and item.function == "servoj"
            )

        listener = threading.Thread(target=listen)
        listener.start()
        program = context.Process(target=policy_loop, args=(tap.host, tap.port, seconds, answers))
        with ExitStack() as stack:
            cores = [None, *sorted(os.sched_getaffinity(0))]
            bare = [Lateness() for _ in cores]
            for each, core in zip(bare, cores, strict=True):
                stack.enter_context(bare_loop(each, RATE, core))
            program.start()
            steps, late, found = answers.get(timeout=seconds + 300)
        program.join()
        tap.end()
        listener.join()
    return {"steps": steps, "late": late, **found}, bare, np.array(points)


def policy(sim: Any, seconds: float) -> tuple[Figures, Figures]:
    """A policy at 30 Hz that computes 20 ms a step: jerk is kept, and no tick is missed by it."""
    found, bare, sent = looped(sim, seconds)
    lateness = {name: value * 1e6 for name, value in found["lateness"].items()}
    share = found["missed"] / found["ticks"]
    say(
        f"     {found['steps']} steps of the policy, {found['late']} late; {found['ticks']} ticks, "
        f"{found['missed']} missed ({share:.3%}), {found['starved']} starved, lateness p50 "
        f"{lateness['p50']:.0f} us, p99 {lateness['p99']:.0f} us, max {lateness['max']:.0f} us"
    )
    own = max(each.missed / each.ticks for each in bare)
    where = ["any processor", *(f"processor {number}" for number in range(len(bare) - 1))]
    for at, each in zip(where, bare, strict=True):
        say(
            f"     a loop on {at} that only sleeps, meanwhile: {each.ticks} ticks, "
            f"{each.missed} missed ({each.missed / each.ticks:.3%})"
        )
    change = np.diff(sent, axis=0) * RATE
    most = [float(np.abs(np.diff(change, n=n, axis=0)).max()) * RATE**n for n in range(3)]
    check(
        f"{len(sent)} set-points at {RATE:g} Hz: up to {most[0]:.3f} rad/s of {V:g}, "
        f"{most[1]:.2f} rad/s2 of {A:g}, {most[2]:.1f} rad/s3 of {JERK:g}",
        len(sent) > 0.9 * seconds * RATE
        and most[0] <= V * 1.001
        and most[1] <= A * 1.001
        and most[2] <= JERK * 1.02,
    )
    check(
        f"ticks missed: {share:.3%}, and {own:.3%} by a loop that only sleeps",
        share <= own + 0.001,
    )
    ticks = {
        "stream": {
            "ticks": found["ticks"],
            "missed": found["missed"],
            "missed_percent": share * 100,
            "lateness_p50_us": lateness["p50"],
            "lateness_p99_us": lateness["p99"],
            "lateness_max_us": lateness["max"],
        }
    } | {
        f"bare loop on {at}": {
            "ticks": each.ticks,
            "missed": each.missed,
            "missed_percent": each.missed / each.ticks * 100,
        }
        for at, each in zip(where, bare, strict=True)
    }
    kinds = ("speed [rad/s]", "acceleration [rad/s²]", "jerk [rad/s³]")
    points = {
        kind: {"largest": largest, "limit": limit}
        for kind, largest, limit in zip(kinds, most, (V, A, JERK), strict=True)
    }
    return ticks, points


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--work", type=Path, required=True)
    parser.add_argument("--seconds", type=float, default=60.0)
    parser.add_argument(
        "--save", action="store_true", help="write the figures to benchmarks/results/lerobot.json"
    )
    given = parser.parse_args()
    import lerobot  # noqa: PLC0415

    say(f"LeRobot {lerobot.__version__}, Python {sys.version.split()[0]}, {os.cpu_count()} cores")
    environments()
    figures: Figures = {}
    with Simulator.spawn(joints=READY) as follower:
        with Simulator.spawn(joints=READY) as leader:
            dataset, actions = recorded(follower, leader, given.work, figures)
            replayed(follower, dataset, actions, given.work, figures)
            teleoperated(follower, leader, figures)
        ticks, points = policy(follower, given.seconds)
    say("all of it is as it must be")
    if given.save:
        results = {
            "command": "chrt -r 5 .ci/integrations --save",
            "lerobot-record, lerobot-replay, lerobot-teleoperate on simulated arms": figures,
            f"a policy at {FPS} Hz that computes 20 ms a step, {given.seconds:g} s": ticks,
            "its set-points": points,
        }
        say(f"written: {write_results('lerobot', results)}")


if __name__ == "__main__":
    main()
