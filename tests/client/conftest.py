"""Fixtures: a controller without an arm, and a robot connected to it."""

from __future__ import annotations

from collections.abc import AsyncIterator, Iterator

import pytest

import aioduco
from aioduco.testing import FaultProxy
from client.bench import Bench


@pytest.fixture
def bench() -> Iterator[Bench]:
    with Bench() as bench:
        yield bench


@pytest.fixture
def proxy(bench: Bench) -> Iterator[FaultProxy]:
    """Between the program and the controller."""
    with FaultProxy(bench.host, bench.port) as proxy:
        yield proxy


@pytest.fixture
async def robot(bench: Bench) -> AsyncIterator[aioduco.Robot]:
    async with aioduco.connect(bench.host, bench.port) as robot:
        yield robot
