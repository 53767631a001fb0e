"""A tap before the vendor's client: every call of the conversation is told, as it was made."""

from __future__ import annotations

import threading

import pytest

from aioduco.recording.tap import Tap, TapNote, TappedCall
from aioduco.sim import Simulator

from .conftest import Generated, connected
from .test_vendor_client import BENT, FINISHED, TURNED, bring_up, movej2

pytestmark = [pytest.mark.interop, pytest.mark.slow]


def test_every_call_of_the_vendors_client_is_told(sim: Simulator, generated: Generated) -> None:
    answers: list[object] = []
    with Tap(sim.host, sim.port) as tap:

        def talk() -> None:
            try:
                with connected(generated, tap.host, tap.port) as robot:
                    bring_up(robot)
                    answers.extend(movej2(robot, joints, block=True) for joints in (TURNED, BENT))
                    answers.extend([robot.get_tcp_pose(), robot.getRobotStatus(), robot.stop(True)])
            finally:
                tap.end()

        thread = threading.Thread(target=talk, name="vendor's client")
        thread.start()
        told = list(tap)
        thread.join()
    calls = [item for item in told if isinstance(item, TappedCall)]
    assert [call.function for call in calls] == [
        *("power_on", "enable", "get_robot_state"),
        *("movej2", "movej2", "get_tcp_pose", "getRobotStatus", "stop"),
    ]
    assert [call.error for call in calls] == [""] * len(calls)
    given = {"joints_list": TURNED, "v": 2.0, "a": 4.0, "r": 0.0, "block": True}
    assert calls[3].arguments == given
    assert [call.answer for call in (*calls[3:6], calls[7])] == [
        *(FINISHED, FINISHED, answers[2]),
        answers[4],
    ]
    assert vars(answers[3]) == {name: getattr(calls[6].answer, name) for name in vars(answers[3])}
    assert all(call.duration is not None and call.duration >= 0.0 for call in calls)
    assert isinstance(told[0], TapNote)
