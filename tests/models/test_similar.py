"""Suggestions for misspelt names."""

from __future__ import annotations

from typing import Any

import pytest
from for_each import for_each

import aioduco
import aioduco.sync
from aioduco.envelope import Envelope
from aioduco.models.similar import did_you_mean, unknown


@for_each(
    "name, says",
    [
        ("lefft", ": did you mean 'left'?"),
        ("LEFT", ": did you mean 'left'?"),
        ("get_tcp_pos", ": did you mean 'get_tcp_pose'?"),
        ("xyz", ""),
        (5, ""),
        (None, ""),
    ],
)
def test_the_nearest_name(name: object, says: str) -> None:
    assert did_you_mean(name, ["left", "right", "get_tcp_pose", "get_tcp_offset"]) == says


def test_a_short_list_is_shown_whole() -> None:
    assert (
        unknown("lefft", ["left"]) == "'lefft' is not known; there are left: did you mean 'left'?"
    )
    assert unknown("a", [str(each) for each in range(20)]) == "'a' is not known"
    assert unknown("a", []) == "'a' is not known; there are none"


ROBOTS = (aioduco.connect("nowhere"), aioduco.sync.connect("nowhere"))
both = pytest.mark.parametrize("robot", ROBOTS, ids=["awaited", "waiting"])


@both
@for_each(
    "name", ["envelop", "evelope", "enevlope", "Envelope", "en_velope", "envelope_", "envelopes"]
)
def test_a_misspelt_envelope_is_refused(robot: Any, name: str) -> None:
    with pytest.raises(AttributeError, match=f"no '{name}': did you mean 'envelope'"):
        setattr(robot, name, Envelope("gcr5_910"))
    assert name not in vars(robot)
    assert robot.envelope is None


@both
@for_each("name, meant", [("rates", "rate"), ("Rate", "rate"), ("force", "forces")])
def test_so_is_a_misspelt_setting_of_the_feed(robot: Any, name: str, meant: str) -> None:
    with pytest.raises(AttributeError, match=f"no '{name}': did you mean '{meant}'"):
        setattr(robot.feed, name, 100)


@both
@for_each(
    "name",
    ["gripper", "home", "name", "box", "limits", "my_envelope", "envelope_2", "old_envelope"],
)
def test_a_program_keeps_its_own_things_with_a_robot(robot: Any, name: str) -> None:
    setattr(robot, name, 1)
    assert getattr(robot, name) == 1
    delattr(robot, name)


@both
def test_so_it_does_with_a_feed(robot: Any) -> None:
    feed = robot.feed
    feed.name, feed.date, feed.state, feed.force_limit = range(4)
    feed.rate, feed.forces = 20.0, True
    assert (feed.rate, feed.forces) == (20.0, True)
    assert (feed.name, feed.force_limit) == (0, 3)
