"""Jogging (点动, manual 1.3.5): one joint or one Cartesian direction, continuously or by a step."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING, Final, Literal, TypeAlias

from aioduco._wire import rpc
from aioduco.errors import ParameterError
from aioduco.models.named_int import NamedInt
from aioduco.models.rules import LONGEST_ARM, Choice, Integer, Number, Real, Whole
from aioduco.models.words import one_of

if TYPE_CHECKING:
    from aioduco.models.version import ControllerVersion

__all__ = ["Axis", "Jog", "JogDirections", "JogFrame", "directions_of"]

Axis: TypeAlias = Literal["x", "y", "z", "rx", "ry", "rz"]
_AXES: tuple[str, ...] = ("x", "y", "z", "rx", "ry", "rz")

_SOURCE = "1.3.5"
#: the manual does not say to which speed the percentage refers
JOG_SPEED = Number(0.0, 100.0, "%", open_low=True, source=_SOURCE)
#: this project's values; the values on the wire depend on `JogDirections`
JOG_DIRECTION = Choice({-1: "negative", 1: "positive"}, source=_SOURCE)
_JOINT = Integer(1, 6, source=_SOURCE)
_STEP_ANGLE = Number(0.0, 2 * math.pi, "rad", open_low=True, source=_SOURCE)
_STEP_LENGTH = Number(0.0, unit="m", open_low=True, plausible=LONGEST_ARM, source=_SOURCE)

_CARTESIAN, _JOINTS = 1, 2


class JogFrame(NamedInt):
    """The frame whose directions a Cartesian jog follows (参考坐标系, manual 1.3.5)."""

    WORLD = 0
    BASE = 1
    TOOL = 2
    WORK_OBJECT = 3


class JogDirections(Enum):
    """Numbers that a controller uses for the direction of a jog.

    The vendor's documents contradict each other: 1 is positive in manual 3.8, and negative in
    manual 4.3 and in a C++ header. The value of each member is the number that is sent for the
    positive direction, then the one for the negative direction.
    """

    MANUAL_3_8 = (1, -1)
    MANUAL_4_3 = (0, 1)

    def number(self, direction: int) -> int:
        """Return the number that is sent for a direction, which is above 0 if it is positive."""
        return self.value[0 if direction > 0 else 1]


_BY_MANUAL: Final = {"3.8": JogDirections.MANUAL_3_8, "4.3": JogDirections.MANUAL_4_3}


def directions_of(
    given: JogDirections | None, version: ControllerVersion, *, external: bool = False
) -> JogDirections:
    """Return what a controller understands by the directions of a jog.

    Manual 4.3 prints -1 and 1 for external axes, against its own 0 and 1 for the arm. So newer
    versions tell nothing about external axes.

    Args:
        given: what the program says; None: as its version says.
        version: the version of the controller's software.
        external: whether the jog is of external axes.

    Raises:
        ParameterError: no member, or None although the version does not tell.
    """
    if isinstance(given, JogDirections):
        return given
    if given is not None:
        raise ParameterError("directions", given, "a member of JogDirections, or None")
    manual = version.manual
    if manual is None or (external and manual != "3.8"):
        raise ParameterError(
            *("directions", given),
            "given, since the jog would go the wrong way if it were guessed, and the "
            f"controller's version ({version}; known once the robot was opened) does not tell "
            f"{'for external axes' if external else 'which it means'}. Nothing was sent. "
            "directions=JogDirections.MANUAL_3_8 sends 1 for positive and -1 for negative, as "
            "controllers up to 3.8 expect; JogDirections.MANUAL_4_3 sends 0 and 1, from 4.3 on. "
            "`aioduco jog` and `aioduco panel` have --manual. Try it with a small step at a low "
            "speed",
        )
    return _BY_MANUAL[manual]


FRAME_TYPE = Choice({frame.value: f"JogFrame.{frame.name}" for frame in JogFrame}, source=_SOURCE)


@dataclass(frozen=True, slots=True)
class Jog:
    """One jog, made by `Jog.joint` or `Jog.cartesian`.

    Attributes:
        axis: index of the joint or the direction, from 0.
        joint_space: whether the jog is of a joint, and not along or about a Cartesian direction.
        direction: 1 or -1.
        vel: speed in percent.
        frame: the frame of a Cartesian jog.
        step: length of one step [m or rad]; None to move until `stop_manual_move`.
    """

    axis: int
    joint_space: bool
    direction: int
    vel: float
    frame: JogFrame
    step: float | None

    @classmethod
    def joint(cls, num: Whole, direction: Whole, vel: Real, *, step: Real | None = None) -> Jog:
        """Jog one joint.

        Args:
            num: the joint, 1 to 6.
            direction: 1 or -1.
            vel: speed in percent, above 0, up to 100.
            step: angle of one step [rad], above 0; None to move until `stop_manual_move`.

        Raises:
            ParameterError: a value out of range.
        """
        return cls(
            _JOINT("num", num) - 1,
            True,
            JOG_DIRECTION("direction", direction),
            JOG_SPEED("vel", vel),
            JogFrame.BASE,
            None if step is None else _STEP_ANGLE("step", step),
        )

    @classmethod
    def cartesian(
        cls,
        axis: Axis,
        direction: Whole,
        vel: Real,
        *,
        frame: JogFrame = JogFrame.BASE,
        step: Real | None = None,
    ) -> Jog:
        """Jog the tool along or about one direction of a frame.

        Args:
            axis: "x", "y", "z", "rx", "ry" or "rz".
            direction: 1 or -1.
            vel: speed in percent, above 0, up to 100.
            frame: the frame of the direction.
            step: length of one step [m, or rad about an axis], above 0; None to move until
                `stop_manual_move`.

        Raises:
            ParameterError: a value out of range.
        """
        one_of("axis", axis, _AXES)
        rule = _STEP_ANGLE if axis.startswith("r") else _STEP_LENGTH
        return cls(
            _AXES.index(axis),
            False,
            JOG_DIRECTION("direction", direction),
            JOG_SPEED("vel", vel),
            JogFrame(FRAME_TYPE("frame", frame)),
            None if step is None else rule("step", step),
        )

    def wire(self, directions: JogDirections) -> rpc.MoveJogTaskParam:
        """Return the struct of the wire.

        Args:
            directions: numbers that the controller uses for positive and negative.
        """
        step = 0.0 if self.step is None else self.step
        turns = self.joint_space or self.axis >= 3
        return rpc.MoveJogTaskParam(
            jog_direction=directions.number(self.direction),
            jog_type=_JOINTS if self.joint_space else _CARTESIAN,
            # an index in manual 3.8, 0 to 5 in 4.3
            axis_num=self.axis,
            vel=self.vel,
            jog_coordinate=int(self.frame),
            use_step=self.step is not None,
            # Steps about rx, ry, rz: step_cartvalue in manual 3.8, step_jointValue in 4.3. Both
            # have the same unit, so the step is right in both cases.
            step_jointValue=step if turns else 0.0,
            step_cartvalue=0.0 if self.joint_space else step,
        )
