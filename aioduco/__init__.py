"""An asyncio-native SDK for DUCO (SIASUN) collaborative robot arms."""

from __future__ import annotations

from aioduco._version import __version__

__all__ = ["__version__"]
