"""Fixtures: those of the client's tests."""

from __future__ import annotations

from client.conftest import bench, robot

__all__ = ["bench", "robot"]
