"""The public names."""

from __future__ import annotations

import aioduco
from aioduco import errors

NAMES = {
    "the robot": "__version__ connect stop_all freeze_support ClosingSteps RecoverReport Robot "
    "Cell HeldMotion MotionCommand MotionPath OnCancel Outcome Task",
    "values": "deg mm Joints JointsLike Pose PoseLike",
    "outputs": "bool_register event float_register output tool_output word_register Op PointOp",
    "what motions are made of": "ExternalAxis ExternalAxisScheme ExternalAxisState FileKind "
    "ForceFrame ForceLogic GuardedForce Jog Load "
    "JogDirections JogFrame OutputMode RealtimeMode RealtimePoint WeavePlane WeaveShape",
    "streams": "JointTrajectory WorkerOptions ServoGains StreamStatistics SwitchPlace TaughtPoints "
    "Tolerances TrajectorySwitch",
    "states": "ControllerVersion ForceStatus HeartbeatState IOStatus OperationMode ProgramState "
    "RobotState RobotStates RobotStatus SafetyState Snapshot TaskState events",
    "errors": " ".join(errors.__all__),
}


def test_public_names() -> None:
    assert sorted(aioduco.__all__) == sorted(" ".join(NAMES.values()).split())
    assert len(set(aioduco.__all__)) == len(aioduco.__all__)
    for name in aioduco.__all__:
        assert getattr(aioduco, name) is not None


def test_every_public_name_is_documented() -> None:
    for name in aioduco.__all__:
        thing = getattr(aioduco, name)
        if callable(thing) and getattr(thing, "__module__", "").startswith("aioduco"):
            assert thing.__doc__, name
