"""Fixtures: a controller that answers from a script, and an object of the vendor's class."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from aioduco.compat import DucoCobot
from aioduco.testing import RecordingServer


@pytest.fixture
def server() -> Iterator[RecordingServer]:
    with RecordingServer() as running:
        yield running


@pytest.fixture
def robot(server: RecordingServer) -> Iterator[DucoCobot]:
    with DucoCobot(server.host, server.port) as connected:
        yield connected
