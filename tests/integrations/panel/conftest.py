from __future__ import annotations

from typing import TYPE_CHECKING

import pytest
from client.bench import Bench

if TYPE_CHECKING:
    from collections.abc import Iterator


@pytest.fixture
def bench() -> Iterator[Bench]:
    with Bench() as bench:
        bench.answer("get_tcp_pose_coord", [0.5, 0.1, 0.6, 3.1, 0.0, -1.5])
        yield bench
