"""The robot for LeRobot, without LeRobot: the parts that it needs are replaced here."""

from __future__ import annotations

import contextlib
import importlib
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest

from aioduco._process.platform import boot_time
from aioduco.errors import ParameterError, StreamStarved
from aioduco.testing import eventually

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from aioduco.sim import Simulator

PACKAGE = Path(__file__).resolve().parents[2] / "integrations/lerobot_robot_duco/lerobot_robot_duco"


@pytest.fixture
def duco(monkeypatch: pytest.MonkeyPatch, duco_simulator: Simulator) -> Iterator[Any]:
    """The robot, connected to a simulated arm."""
    played: dict[str, dict[str, object]] = {
        "lerobot.cameras.utils": {"make_cameras_from_configs": dict},
        "lerobot.robots": {"Robot": type("Robot", (), {"__init__": lambda self, config: None})},
        "lerobot.utils.errors": {
            "DeviceAlreadyConnectedError": ConnectionError,
            "DeviceNotConnectedError": ConnectionError,
        },
        "lerobot_robot_duco": {"__path__": [str(PACKAGE)]},
        "lerobot_robot_duco.config_duco": {"DucoConfig": SimpleNamespace},
    }
    for name, holds in played.items():
        module: Any = ModuleType(name)
        vars(module).update(holds)
        monkeypatch.setitem(sys.modules, name, module)
    monkeypatch.delitem(sys.modules, "lerobot_robot_duco.duco", raising=False)
    module = importlib.import_module("lerobot_robot_duco.duco")
    config = SimpleNamespace(
        host=duco_simulator.host,
        port=duco_simulator.port,
        cameras={},
        record="",
        v=1.0,
        a=5.0,
        jerk=50.0,
        rate=500.0,
        hold=0.5,
        max_step=0.05,
        state_rate=100.0,
        heartbeat=20.0,
        timeout=20.0,
        max_age=20.0,
        bring_up=True,
    )
    robot = module.Duco(config)
    robot.connect()
    yield robot
    if robot.is_connected:
        robot.disconnect()
    monkeypatch.delitem(sys.modules, "lerobot_robot_duco.duco")


def test_an_action_in_degrees_is_refused_and_moves_nothing(duco: Any) -> None:
    seen = duco.get_observation()
    for key, angle in (
        ("joint_1.pos", 30.0),
        ("joint_5.pos", -90.0),
        ("joint_2.pos", float("nan")),
    ):
        with pytest.raises(ParameterError, match=f"{key} is {angle}, .*not degrees.*nothing"):
            duco.send_action({**seen, key: angle})
    for wrong in ({**seen, "joint_3.pos": 10**400}, np.zeros(6)):
        with pytest.raises(ParameterError, match="a number for each"):
            duco.send_action(wrong)
    assert duco.statistics() is None  # no stream was opened


def test_an_action_a_little_beyond_a_joint_s_end_is_cut(duco: Any) -> None:
    seen = duco.get_observation()
    sent = duco.send_action({**seen, "joint_1.pos": 6.3})
    assert sent["joint_1.pos"] == pytest.approx(seen["joint_1.pos"] + 0.05)


@pytest.mark.duco_speed(1.0)  # a stream's times are the wall's
def test_an_action_after_a_lost_heartbeat_moves_nothing_and_says_why(duco: Any) -> None:
    """It was stopped, which the program has to be told; a pause between two episodes goes on."""
    action = duco.get_observation()
    duco.send_action(action)
    eventually(lambda: duco.statistics().reason.name == "STARVED")
    duco.send_action(action)
    runner = duco._robot._runner
    gate = runner.robot._supervisor.permits.gate
    runner.call_sync(gate.lapse)
    eventually(lambda: duco.statistics().reason.name == "LAPSED")
    runner.call_sync(lambda: gate.beaten(boot_time() + 60.0))  # it beats again: all could go on
    opened = duco._stream
    with pytest.raises(StreamStarved, match="heartbeat was lost"):
        duco.send_action(action)
    assert duco._stream is opened
    with pytest.raises(StreamStarved, match="heartbeat was lost"):
        duco.disconnect()


def interrupted(duco: Any) -> None:
    """End as most commands of LeRobot do after Ctrl-C."""
    try:
        raise KeyboardInterrupt
    finally:
        duco.disconnect()


def ended(duco: Any) -> None:
    """End as lerobot-teleoperate does after Ctrl-C, which it has handled by then."""
    duco.disconnect()


@pytest.mark.slow
@pytest.mark.duco_speed(1.0)  # a stream's times are the wall's
@pytest.mark.parametrize("end", [interrupted, ended])
def test_an_interrupt_of_lerobot_s_loop_brakes_the_arm_far_from_the_last_action(
    duco: Any, duco_simulator: Simulator, end: Callable[[Any], None]
) -> None:
    action = duco.get_observation()
    start = action["joint_1.pos"]
    for number in range(1, 21):
        duco.send_action({**action, "joint_1.pos": start + 0.05 * number})
    eventually(lambda: duco_simulator.joints[0] > start + 0.01)
    with contextlib.suppress(KeyboardInterrupt):
        end(duco)
    assert not duco_simulator.moving
    assert duco_simulator.joints[0] < start + 0.8
