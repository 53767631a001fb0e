"""A Python of its own for what is not to be in the tests' process."""

from __future__ import annotations

import subprocess
import sys
from typing import Any

__all__ = ["python"]


def python(*arguments: str, **options: Any) -> subprocess.CompletedProcess[str]:
    """Run an interpreter until it ends, and tell what it printed."""
    return subprocess.run(
        [sys.executable, *arguments],
        check=False,
        capture_output=True,
        text=True,
        **{"timeout": 100.0, **options},
    )
