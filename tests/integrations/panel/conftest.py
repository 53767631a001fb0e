from __future__ import annotations

from collections.abc import Iterator

import pytest
from client.bench import Bench


@pytest.fixture
def bench() -> Iterator[Bench]:
    with Bench() as bench:
        bench.answer("get_tcp_pose_coord", [0.5, 0.1, 0.6, 3.1, 0.0, -1.5])
        yield bench
