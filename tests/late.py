"""Delays each answer, so that a test that relies on quick ones always fails.

A simulator without the clock goes through a motion of a second within some ten milliseconds. Then
a client whose call is on its way for longer finds the arm at its goal. In locked simulated time,
and in real time, nothing is late.
"""

from __future__ import annotations

import math
import time
from typing import Any

from aioduco.sim.handlers.base import HandlerSection
from aioduco.sim.server.processor import Processor


def answer_late(seconds: float) -> None:
    """Let the simulators of this process begin each call, and answer it, so much later [s]."""
    carry_out = Processor._result

    def wait(processor: Processor) -> None:
        handler = processor._handler
        if not isinstance(handler, HandlerSection):  # a test's own server
            return
        runtime = handler._runtime
        if math.isinf(runtime._speed) and runtime._limit is None:
            time.sleep(seconds)  # what is tested is that tests pass after any time

    def late(self: Processor, message: Any) -> tuple[int, Any]:
        wait(self)
        answer = carry_out(self, message)
        wait(self)
        return answer

    Processor._result = late  # type: ignore[method-assign]
