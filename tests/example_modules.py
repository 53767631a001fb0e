"""Examples as modules, for tests that call their functions."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from typing import Any

__all__ = ["EXAMPLES", "example"]

EXAMPLES = Path(__file__).parents[1] / "examples"


def example(name: str) -> Any:
    """An example of `examples/`, loaded anew."""
    spec = importlib.util.spec_from_file_location(name, EXAMPLES / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    # Models of pydantic look up their annotations there.
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module
