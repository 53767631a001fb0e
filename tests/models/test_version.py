"""Versions of the controller's software: read from its text, and compared."""

from __future__ import annotations

from for_each import for_each

from aioduco.models.version import ControllerVersion


@for_each(
    "text, numbers",
    [
        ("V3.4.1", (3, 4, 1)),
        ("v2.7", (2, 7)),
        ("Core 3.10.0-rc1+20260101", (3, 10, 0)),
        ("4", (4,)),
        ("", ()),
        ("none", ()),
    ],
)
def test_numbers_are_read(text: str, numbers: tuple[int, ...]) -> None:
    version = ControllerVersion(text)
    assert version.numbers == numbers
    assert version.known is bool(numbers)
    assert str(version) == (text or "unknown")


def test_order() -> None:
    rising = [ControllerVersion(text) for text in ("", "2.7", "V3.4", "3.4.1", "3.10", "4.0.0.1")]
    for index, older in enumerate(rising):
        for newer in rising[index + 1 :]:
            assert older < newer
            assert newer > older
            assert not newer <= older
            assert not older >= newer
    assert ControllerVersion("3.4") <= ControllerVersion("V3.4.0") <= ControllerVersion("3.4")
    assert max(rising) is rising[-1]


def test_at_least() -> None:
    version = ControllerVersion("V3.4.1")
    assert version.at_least(3, 4, 1)
    assert version.at_least(3, 4)
    assert version.at_least(3)
    assert version.at_least(3, 4, 1, 0)
    assert not version.at_least(3, 4, 2)
    assert not version.at_least(4)
    assert not ControllerVersion("").at_least(0)
