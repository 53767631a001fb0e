"""Parameters of tests that run with and without the guard."""

from __future__ import annotations

import pytest

#: a test that is run without the guard, and with it
BOTH = pytest.mark.parametrize("guard", [None, "process"], ids=["alone", "guard"])
