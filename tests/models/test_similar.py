"""Names that were written wrongly."""

from __future__ import annotations

import pytest

from aioduco.models.similar import did_you_mean, unknown


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("lefft", ": did you mean 'left'?"),
        ("LEFT", ": did you mean 'left'?"),
        ("get_tcp_pos", ": did you mean 'get_tcp_pose'?"),
        ("xyz", ""),
    ],
)
def test_the_nearest_name(name: str, says: str) -> None:
    assert did_you_mean(name, ["left", "right", "get_tcp_pose", "get_tcp_offset"]) == says


def test_a_short_list_is_shown_whole() -> None:
    assert (
        unknown("lefft", ["left"]) == "'lefft' is not known; there are left: did you mean 'left'?"
    )
    assert unknown("a", [str(each) for each in range(20)]) == "'a' is not known"
    assert unknown("a", []) == "'a' is not known; there are none"
