"""Fixtures for tests of programs that drive an arm: they cost nothing unless a test asks for one."""

from __future__ import annotations
