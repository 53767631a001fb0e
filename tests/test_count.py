"""`.ci/count` finds no circle of imports."""

from __future__ import annotations

from pathlib import Path

import pytest
from interpreter import python

ROOT = Path(__file__).parents[1]


@pytest.mark.slow
def test_no_module_of_this_package_imports_itself_through_others() -> None:
    """When it is loaded, or for type checkers."""
    done = python(".ci/count", cwd=ROOT)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.splitlines()[-2:] == [
        "circles of imports when modules are loaded: 0",
        "circles of imports with imports for type checkers: 0",
    ]
