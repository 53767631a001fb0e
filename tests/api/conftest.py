"""Fixtures: a controller with all motions, and a robot connected to it."""

from __future__ import annotations

from collections.abc import AsyncIterator, Iterator

import pytest

import aioduco
from aioduco.testing import FaultProxy
from api.desk import Desk


@pytest.fixture
def desk() -> Iterator[Desk]:
    with Desk() as desk:
        yield desk


@pytest.fixture
def proxy(desk: Desk) -> Iterator[FaultProxy]:
    """Between the program and the controller."""
    with FaultProxy(desk.host, desk.port) as proxy:
        yield proxy


@pytest.fixture
async def robot(desk: Desk) -> AsyncIterator[aioduco.Robot]:
    async with aioduco.connect(desk.host, desk.port) as robot:
        yield robot
