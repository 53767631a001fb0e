"""The Gymnasium environments pass its checks, and the two kinds agree."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from numpy.typing import NDArray

from aioduco.errors import ParameterError
from aioduco.integrations.gym import TASKS

Vector = NDArray[np.float64]
Policy = Callable[[dict[str, Vector]], Vector]

TIP = slice(12, 15)


def towards(here: Vector, there: Vector) -> Vector:
    return np.clip((there - here) / 0.02, -1.0, 1.0)


def reach(seen: dict[str, Vector]) -> Vector:
    return towards(seen["observation"][TIP], seen["desired_goal"])


def press(seen: dict[str, Vector]) -> Vector:
    tip, missing = seen["observation"][TIP], seen["desired_goal"] - seen["achieved_goal"]
    if seen["achieved_goal"][0] < 1.0 and tip[2] > 0.17:
        return towards(tip, np.array((0.5, 0.0, tip[2] - 0.01)))
    return np.array((0.0, 0.0, float(np.clip(-missing[0] / 4000.0 / 0.015 * 0.5, -0.3, 0.3))))


def push(seen: dict[str, Vector]) -> Vector:
    """Round the box, down behind it, and along."""
    tip, box, goal = seen["observation"][TIP], seen["achieved_goal"], seen["desired_goal"]
    along = (goal - box)[:2] / np.linalg.norm((goal - box)[:2])
    behind = np.array((*(box[:2] - 0.06 * along), box[2]))
    side = (tip - box)[:2] - np.dot((tip - box)[:2], along) * along
    placed = np.dot((tip - box)[:2], along) < -0.03 and np.linalg.norm(side) < 0.012
    if placed and tip[2] < box[2] + 0.02:
        if np.linalg.norm((goal - box)[:2]) < 0.012:
            return np.zeros(3)
        step = 0.5 * along - 15.0 * side
        return np.array((*np.clip(step, -0.5, 0.5), 0.0))
    if np.linalg.norm((tip - behind)[:2]) > 0.01:
        above = box[2] + 0.08
        if tip[2] < above - 0.01:
            return np.array((0.0, 0.0, 1.0))
        return towards(tip, np.array((*behind[:2], above)))
    return towards(tip, behind)


def pick_and_place(seen: dict[str, Vector]) -> Vector:
    """Over the box, down, close, up, over the goal, down."""
    tip, box, goal = seen["observation"][TIP], seen["achieved_goal"], seen["desired_goal"]
    apart = np.linalg.norm((tip - box)[:2])
    if seen["observation"][15]:
        step = 0.5 * towards(tip, goal) if np.linalg.norm((tip - goal)[:2]) < 0.03 else None
        if step is None:
            step = towards(tip, np.array((*goal[:2], max(goal[2], 0.2))))
        return np.array((*step, -1.0))
    if apart < 0.006 and abs(tip[2] - box[2]) < 0.008:
        return np.array((0.0, 0.0, 0.0, -1.0))
    height = box[2] if apart < 0.006 else max(box[2] + 0.06, min(tip[2], 0.24))
    return np.array((*(0.6 * towards(tip, np.array((*box[:2], height)))), 1.0))


POLICIES: dict[str, Policy] = {
    "Reach": reach,
    "Push": push,
    "Press": press,
    "PickPlace": pick_and_place,
}


def episode(env: Any, seed: int, policy: Policy | None = None, steps: int = 100) -> Any:
    """The observations, and whether it was a success at any step; without a policy, by chance."""
    seen, _ = env.reset(seed=seed)
    rng = np.random.default_rng(seed)
    trace, done = [seen["observation"]], False
    for _ in range(steps):
        action = rng.uniform(-1, 1, env.action_space.shape) if policy is None else policy(seen)
        seen, reward, stopped, _, info = env.step(action)
        assert not stopped, info
        assert (reward == 0.0) == info["is_success"]
        trace.append(seen["observation"])
        if policy is not None and (done := info["is_success"]):
            break
    return np.array(trace), done


@pytest.fixture
def made() -> Iterator[Callable[..., Any]]:
    environments = []

    def make(*args: Any, **kwargs: Any) -> Any:
        environments.append(gymnasium.make(*args, **kwargs))
        return environments[-1]

    yield make
    for each in environments:
        each.close()


@pytest.mark.cases(1)
@pytest.mark.parametrize(("kind", "actions"), [("", "joints"), ("wire-", "cartesian")])
@pytest.mark.parametrize("task", TASKS)
def test_gymnasiums_own_check_passes(
    made: Callable[..., Any], task: str, kind: str, actions: str
) -> None:
    env = made(f"aioduco/{task}-{kind}v0", actions=actions)
    check_env(env.unwrapped, skip_render_check=True)


@pytest.mark.slow
@pytest.mark.parametrize("actions", ["cartesian", "joints"])
@pytest.mark.parametrize("task", TASKS)
def test_episodes_repeat_by_seed_and_are_the_same_over_the_wire(
    made: Callable[..., Any], task: str, actions: str
) -> None:
    """Whatever happened before; by seed bit for bit, over the wire within 2 mrad."""
    fast, wire = (made(f"aioduco/{task}-{kind}v0", actions=actions) for kind in ("", "wire-"))
    traces = []
    for env in (fast, wire):
        first, _ = episode(env, 1, steps=15)
        episode(env, 2, steps=7)
        again, _ = episode(env, 1, steps=15)
        # With a gripper over the wire something of the first episode is left, of 1e-11.
        left = 1e-8 if task == "PickPlace" and env is wire else 0.0
        np.testing.assert_allclose(first, again, rtol=0, atol=left)
        traces.append(first)
    assert np.ptp(traces[0][:, :6], axis=0).max() > 0.02
    np.testing.assert_allclose(traces[0][:, :6], traces[1][:, :6], rtol=0, atol=2e-3)


@pytest.mark.slow
@pytest.mark.parametrize("task", POLICIES)
def test_a_scripted_policy_solves_both_alike(made: Callable[..., Any], task: str) -> None:
    fast, wire = (made(f"aioduco/{task}-{kind}v0") for kind in ("", "wire-"))
    solved = 0
    for seed in range(4):
        trace, done = episode(fast, seed, POLICIES[task])
        solved += done
        if seed < 2:
            over_wire, also = episode(wire, seed, POLICIES[task])
            assert done == also
            np.testing.assert_allclose(trace[:, :6], over_wire[:, :6], rtol=0, atol=2e-3)
    assert solved >= (3 if task == "Push" else 4), "a box may turn away from the rod"


@pytest.mark.slow
def test_an_arm_that_is_wedged_is_left_all_the_same(made: Callable[..., Any]) -> None:
    """It shakes at the pad's edge, and would do so for ever."""
    env = made("aioduco/Press-wire-v0")
    env.reset(seed=1)
    for step in range(30):
        env.step(np.array([0.2 * np.sin(step / 5), 0.1, -0.9 if step < 20 else -0.3]))
    env.close()


@pytest.mark.slow
def test_two_processes_step_as_one(made: Callable[..., Any]) -> None:
    several = gymnasium.make_vec("aioduco/Reach-v0", num_envs=2, vectorization_mode="async")
    try:
        seen, _ = several.reset(seed=5)
        assert several.action_space.shape is not None
        action = np.full(several.action_space.shape, 0.5, np.float32)
        seen, *_ = several.step(action)
    finally:
        several.close()
    for i in range(2):
        one = made("aioduco/Reach-v0")
        one.reset(seed=5 + i)
        alone, *_ = one.step(action[i])
        np.testing.assert_array_equal(seen["observation"][i], alone["observation"])


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["", "wire-"])
def test_pictures_show_the_arm_and_the_goal(made: Callable[..., Any], kind: str) -> None:
    env = made(f"aioduco/Reach-{kind}v0", observations="both", render_mode="rgb_array")
    seen, _ = env.reset(seed=1)
    assert env.observation_space.contains(seen)
    red = seen["pixels"].astype(int) @ (1, -1, -1) > 20
    assert 3 < red.sum() < 400, "the goal is a red ball"
    after, *_ = env.step(np.array((0.0, -1.0, 1.0)))
    assert (after["pixels"] != seen["pixels"]).any()
    again, _ = env.reset(seed=1)
    np.testing.assert_array_equal(again["pixels"], seen["pixels"])
    assert env.render().shape == (480, 480, 3)


def test_what_is_no_action_is_refused_and_does_nothing(made: Callable[..., Any]) -> None:
    env = made(
        "aioduco/Reach-v0", reward="dense", render_mode="rgb_array", disable_env_checker=True
    ).unwrapped
    for outside in (lambda: env.step(np.zeros(3)), env.render):
        with pytest.raises(RuntimeError, match="reset"):
            outside()
    before, _ = env.reset(seed=1)
    bad: Any
    for bad in (np.zeros(4), np.array((0.0, np.nan, 0.0)), "abc", {}, [[0.0], [0.0, 1.0]]):
        with pytest.raises(ParameterError, match="action"):
            env.step(bad)
    with pytest.raises(ParameterError, match="there are no options"):
        env.reset(options={"goal": (0.5, 0.0, 0.2)})
    after, reward, *_ = env.step(np.zeros(3))
    np.testing.assert_allclose(after["observation"][:6], before["observation"][:6], atol=1e-6)
    assert reward == -np.linalg.norm(after["achieved_goal"] - after["desired_goal"])
    wrongs: list[dict[str, Any]]
    wrongs = [{"actions": "wishes"}, {"observations": "smells"}, {"task": "Dance"}]
    for wrong in wrongs:
        (name,) = wrong
        with pytest.raises(ParameterError, match=f'{name} is .*, but must be "'):
            gymnasium.make("aioduco/Reach-v0", **wrong)
    for size in (64, (64,), (64, 0), (64.0, 64.0), "64", np.array(64)):
        with pytest.raises(ParameterError, match=r"size is .*, but must be height and width"):
            gymnasium.make("aioduco/Reach-v0", size=size)


@pytest.mark.slow
def test_no_target_leaves_the_space_of_the_task(made: Callable[..., Any]) -> None:
    for actions in ("cartesian", "joints"):
        env = made("aioduco/Reach-v0", actions=actions)
        env.reset(seed=1)
        low = env.unwrapped._task.low - 1e-3
        rng = np.random.default_rng(1)
        push = rng.uniform(-1, 1, env.action_space.shape)
        for _ in range(60):
            seen, *_ = env.step(push)
        assert (seen["observation"][TIP] >= low).all()
