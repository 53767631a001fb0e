"""The way of a motion from the program to the send is short: no task of its own, few frames."""

from __future__ import annotations

import asyncio
import sys
from typing import TYPE_CHECKING

from aioduco._wire.deadline_socket import DeadlineSocket
from aioduco.models.enums import Outcome
from client.bench import HOME

if TYPE_CHECKING:
    import pytest

    import aioduco

#: frames from the program to the system call, without the program's own
MOST = 8


async def test_an_awaited_motion_is_sent_by_the_task_that_awaits_it(
    robot: aioduco.Robot, monkeypatch: pytest.MonkeyPatch
) -> None:
    way: list[str] = []
    senders: list[asyncio.Task[object] | None] = []
    send_at_once = DeadlineSocket.send_at_once

    def noted(self: DeadlineSocket, data: bytes) -> int:
        if b"movej2" in data:
            senders.append(asyncio.current_task())
            frame = sys._getframe(1)
            while frame.f_back is not None and frame.f_code.co_filename != __file__:
                way.append(frame.f_code.co_name)
                frame = frame.f_back
        return send_at_once(self, data)

    monkeypatch.setattr(DeadlineSocket, "send_at_once", noted)
    assert await robot.motion.movej2(HOME, v=1.0, a=1.0) is Outcome.FINISHED
    assert senders == [asyncio.current_task()]
    assert len(way) + 2 <= MOST, way  # the socket's method, and the function that it calls
