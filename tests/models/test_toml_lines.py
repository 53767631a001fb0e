"""The places of fields in a TOML text."""

from __future__ import annotations

import pytest

from aioduco.models.toml_lines import line_of, statements

TEXT = '''\
# the first line
arm = "x"  # a comment
"a = b" = [
  [1],
  [2]] # the end
[robots]
left = { host = "1", "port" = 3 }
[[limit]]
kind = "a"
[limit.inner]
k = 1
[[limit]]
kind.x = """
[no]
k = 2
"""
k = 3
'''


@pytest.mark.parametrize(
    ("path", "line"),
    [
        (("arm",), 2),
        (("a = b",), 3),
        (("robots", "left", "port"), 7),
        (("robots", "right"), 6),
        (("limit", 0, "kind"), 9),
        (("limit", 0, "inner", "k"), 11),
        (("limit", 1), 12),
        (("limit", 1, "kind", "x"), 13),
        (("limit", 1, "k"), 17),
        (("none",), 1),
    ],
)
@pytest.mark.parametrize("newline", ["\n", "\r\n"])
def test_the_line_of_a_field(path: tuple[str | int, ...], line: int, newline: str) -> None:
    assert line_of(TEXT.replace("\n", newline), path) == line


def test_statements_have_their_values() -> None:
    found = {each.path: each.value for each in statements(TEXT) if each.value is not None}
    assert found["a = b",] == [[1], [2]]
    assert found["limit", 1, "kind", "x"] == "[no]\nk = 2\n"
    assert [each.end for each in statements(TEXT)][:2] == [2, 5]
