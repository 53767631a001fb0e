"""Options with a few allowed words: others are refused by name, with the nearest one."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from for_each import for_each

import aioduco
from aioduco import ParameterError, Pose, descriptions, kinematics
from aioduco._wire.owner_loop import OwnerLoop
from aioduco.api.streams.realtime import RealtimeStreams
from aioduco.api.streams.track import TrackStreams
from aioduco.devices.cameras import calibrate_hand_eye
from aioduco.envelope import ToolSpeed, Zone
from aioduco.kinematics.mounting import base_in_world
from aioduco.models.gripper_models import gripper_model
from aioduco.models.jog import Jog
from aioduco.recording.playback.envelope_file import limit_of
from aioduco.sim import Simulator
from aioduco.streaming.endpoint import StreamEndpoint
from aioduco.streaming.shared.options import Feeding
from aioduco.supervision.state_feed import Subscription
from aioduco.testing.preflight.variation import Variation

HOST = "192.0.2.1"
NOWHERE = StreamEndpoint(HOST, 1)
VIEWS = [Pose(0.1 * n, 0, 0, 0.3 * n, 0.2 * n, 0) for n in range(5)]

#: by name: what takes a word, and one that is nearly right
TAKERS: dict[str, tuple[Callable[[Any], Any], str]] = {
    "on_cancel": (lambda x: aioduco.connect(HOST, on_cancel=x), "detatch"),
    "guard": (lambda x: aioduco.connect(HOST, guard=x), "proces"),
    "space": (lambda x: TrackStreams(NOWHERE).stream(x, speed=0.1, acc=1.0), "joint"),
    "policy": (lambda x: Subscription(x, 3, OwnerLoop()), "drop_oldets"),
    "run_in": (lambda x: aioduco.WorkerOptions(run_in=x), "thred"),
    "upsample": (lambda x: Feeding(upsample=x), "linaer"),
    "mode": (lambda x: RealtimeStreams(NOWHERE).stream(x, v=1.0, a=1.0), "joint_positon"),
    "keep": (lambda x: Zone.sphere([0, 0, 1], 0.1, keep=x), "outt"),
    "action": (lambda x: ToolSpeed(0.1, action=x), "slwo"),
    "kind of limit": (lambda x: limit_of("limit", {"kind": x, "most": 0.5}), "tool_sped"),
    "model": (kinematics.arm, "gcr5_901"),
    "length": (lambda x: kinematics.arm("gcr5_910", **_named(x)), "d22"),
    "mounting": (lambda x: base_in_world(x, kinematics.arm("gcr5_910")), "celing"),
    "generation": (lambda x: Simulator(generation=x), "oldst"),
    "gripper": (gripper_model, "robotiq_2f58"),
    "axis": (lambda x: Jog.cartesian(x, 1, 10.0), "rxx"),
    "order": (lambda x: Pose.from_quaternion((0, 0, 0), (1, 0, 0, 0), order=x), "wxzy"),
    "distro": (lambda x: descriptions.moveit(kinematics.arm("gcr5_910"), distro=x), "humbel"),
    "mounted": (lambda x: calibrate_hand_eye(VIEWS, VIEWS, mounted=x), "flang"),
    "vary": (lambda x: Variation.of([x], 1), "lateny"),
}
NO_WORDS: list[Any] = [
    *(np.array([1.0, 2.0]), np.array(["stop"]), [], ["stop"], {}, {"stop": 1}, {1}, object()),
    *(math.nan, 77, 10**5000, True, b"stop", "", "\ud800", "x" * 1_000_000, "\x1b[2J"),
]


def _named(word: Any) -> Any:
    return {word if isinstance(word, str) else "x": 1.0}


@for_each("name", TAKERS)
def test_what_is_no_word_of_a_few_is_refused_by_name(name: str) -> None:
    take, nearly = TAKERS[name]
    for value in NO_WORDS:
        pose = name == "mounting" and not isinstance(value, str)
        asked = "pose" if pose else name.partition(" ")[0]
        with pytest.raises(ParameterError, match=asked) as caught:
            take(value)
        assert len(str(caught.value)) < 2000
    with pytest.raises(ParameterError, match=r"did you mean '\w+'\?"):
        take(nearly)
