"""numpy, loaded when it is first used: opening a robot and stopping it needs none of it."""

from __future__ import annotations

import importlib
import sys
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from typing import TypeGuard

    import numpy as np
    from numpy.typing import NDArray
else:

    class _NumpyOnUse:
        """Loads numpy for the first attribute, and keeps each for the next time."""

        def __getattr__(self, name: str) -> Any:
            value = getattr(importlib.import_module("numpy"), name)
            setattr(self, name, value)
            return value

    np = _NumpyOnUse()

__all__ = ["is_array", "is_scalar", "np"]


def is_array(value: object) -> TypeGuard[NDArray[Any]]:
    """Whether a value is an array of numpy, which is not loaded for it."""
    return isinstance(value, _kinds("ndarray"))


def is_scalar(value: object) -> TypeGuard[np.generic[Any] | NDArray[Any]]:
    """Whether a value is a scalar of numpy, or an array without dimensions."""
    return isinstance(value, _kinds("generic")) or (is_array(value) and value.ndim == 0)


def _kinds(name: str) -> tuple[type, ...]:
    """The class of numpy with this name; none before numpy is loaded, perhaps by another thread."""
    kind = getattr(sys.modules.get("numpy"), name, None)
    return () if kind is None else (kind,)
