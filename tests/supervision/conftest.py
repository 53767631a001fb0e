"""Fixtures: those of the client's tests."""

from __future__ import annotations

from client.conftest import bench, proxy, robot

__all__ = ["bench", "proxy", "robot"]
