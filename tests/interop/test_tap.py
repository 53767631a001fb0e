"""A tap reports every call of the vendor's client, as it was made."""

from __future__ import annotations

import math
import threading

import pytest

from aioduco.recording.tap import Tap, TapNote, TappedCall
from aioduco.sim import Simulator

from .conftest import Generated, connected

pytestmark = [pytest.mark.interop, pytest.mark.slow]

FINISHED = 4  # task state (manual 3.8 section 1.2)
BENT = [0.0, 0.0, math.pi / 2, 0.0, -math.pi / 2, 0.0]
TURNED = [1.0, 0.2, 1.4, 0.1, -1.4, 0.3]


def test_every_call_of_the_vendors_client_is_told(sim: Simulator, generated: Generated) -> None:
    answers: list[object] = []
    with Tap(sim.host, sim.port) as tap:

        def talk() -> None:
            try:
                with connected(generated, tap.host, tap.port) as robot:
                    assert [robot.power_on(True), robot.enable(True)] == [FINISHED] * 2
                    # as the vendor's wrapper sends it: op and def_acc left out
                    rest = (2.0, 4.0, 0.0, True, None, None)
                    answers.extend(robot.movej2(joints, *rest) for joints in (TURNED, BENT))
                    answers.extend([robot.get_tcp_pose(), robot.getRobotStatus(), robot.stop(True)])
            finally:
                tap.end()

        thread = threading.Thread(target=talk, name="vendor's client")
        thread.start()
        told = list(tap)
        thread.join()
    calls = [item for item in told if isinstance(item, TappedCall)]
    assert [call.function for call in calls] == [
        *("power_on", "enable"),
        *("movej2", "movej2", "get_tcp_pose", "getRobotStatus", "stop"),
    ]
    assert [call.error for call in calls] == [""] * len(calls)
    given = {"joints_list": TURNED, "v": 2.0, "a": 4.0, "r": 0.0, "block": True}
    assert calls[2].arguments == given
    assert [call.answer for call in (*calls[2:5], calls[6])] == [
        *(FINISHED, FINISHED, answers[2]),
        answers[4],
    ]
    assert vars(answers[3]) == {name: getattr(calls[5].answer, name) for name in vars(answers[3])}
    assert all(call.duration is not None and call.duration >= 0.0 for call in calls)
    assert isinstance(told[0], TapNote)
