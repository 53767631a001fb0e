"""Fingers and suction cups in MuJoCo, which hold things by friction and can drop them.

`FingerControl` is the gripper's own controller: a state machine without physics. `Hand` connects it
to the model. Any thread may give orders; everything else runs on the world's thread.
"""

from __future__ import annotations

import math
from importlib import resources
from string import Template
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from aioduco.sim.cycle import GripperReading

if TYPE_CHECKING:
    from collections.abc import Iterable

    from aioduco.models.gripper_models import GripperModel


#: friction between finger tips, or cup, and a thing that they hold; an assumption, as of rubber
FRICTION = 0.8
#: stiffness and damping of the drive [N/m, N s/m], and its inertia at each finger [kg]
_STIFFNESS, _DAMPING, _INERTIA = 20_000.0, 100.0, 0.2
#: mass of a finger [kg]
_FINGER = 0.05
#: a finger's half width, half thickness, and extent from its tip's middle up and down [m]
_ACROSS, _THICK, _UP, _DOWN = 0.011, 0.006, 0.045, 0.008
#: thresholds: distance that is arrived, speed that is none and for how long, distance that is moved
#: away [m, m/s, s, m]
_ARRIVED, _STANDING, _STALLED, _AWAY = 5e-4, 2e-3, 0.05, 3e-3
#: how far the drive's set-point leads a stopped finger, beyond what its force needs [m]
_LEAD = 0.003
#: time until a vacuum has built up, and until it is gone without blowing off [s]; assumptions
_BUILD_UP, _FADING = 0.1, 0.2
_CUP = 0.02  # radius of a cup [m]
_SLIPPERY = 1e-5  # MuJoCo's smallest friction
#: cosine of the largest angle at which a contact is one of a finger's inner face, or a cup's lip
_FACING = 0.7


class GripperOrder(NamedTuple):
    """An order to a gripper.

    Attributes:
        number: number of the order, counted from the first.
        targets: openings to move to, one after another [m]; none to stop. For a cup: 0 to suck, 1
            to release.
        speed: speed of the opening [m/s]; for a cup 1 to blow off.
        force: force of the fingers or the cup [N].
    """

    number: int
    targets: tuple[float, ...]
    speed: float
    force: float


class FingerControl:
    """Moves the fingers to an opening, detects a thing that stops them, and presses on it.

    It has no clock and no physics.

    Args:
        opening: opening at the beginning [m].
    """

    def __init__(self, opening: float) -> None:
        self._order = GripperOrder(0, (), 0.0, 0.0)
        self._ramp = opening
        self._index = 0
        self._stopped = 0.0
        self._caught_at = 0.0
        self._direction = 0
        self._moving = self._lost = False

    def tick(self, order: GripperOrder, opening: float, rate: float, step: float) -> float:
        """Run one step.

        Args:
            order: the present order.
            opening: distance between the fingers [m].
            rate: speed of the opening [m/s].
            step: length of the step [s].

        Returns:
            The drive's set-point of the opening [m].
        """
        if order.number != self._order.number:
            self._order = order
            self._ramp, self._index, self._stopped = opening, 0, 0.0
            self._direction, self._lost = 0, False
            self._moving = bool(order.targets)
        if not order.targets:
            return self._ramp
        reach = order.force / _STIFFNESS
        if self._direction:
            if abs(opening - self._caught_at) <= _AWAY:
                return opening - self._direction * 1.5 * reach
            self._direction, self._lost, self._moving = 0, True, True
            self._ramp = opening
        target = order.targets[self._index]
        way = target - self._ramp
        self._ramp += math.copysign(min(abs(way), order.speed * step), way)
        lead = 1.5 * reach + _LEAD
        self._ramp = min(max(self._ramp, opening - lead), opening + lead)
        if abs(target - opening) <= _ARRIVED:
            self._next()
        elif abs(rate) < _STANDING and abs(self._ramp - opening) > 2.0 * _ARRIVED:
            self._stopped += step
            if self._stopped >= _STALLED:
                if self._index + 1 == len(order.targets):
                    self._direction = 1 if target < opening else -1
                    self._caught_at, self._moving = opening, False
                self._next()
        else:
            self._stopped = 0.0
        return self._ramp

    def _next(self) -> None:
        self._stopped = 0.0
        if self._index + 1 < len(self._order.targets):
            self._index += 1
        else:
            self._moving = False

    def reading(self, opening: float) -> GripperReading:
        """Give the present state, at an opening [m]."""
        return GripperReading(
            self._order.number, opening, self._moving, self._direction, self._lost
        )


class Hand:
    """A gripper in a compiled model.

    Args:
        model, data: MuJoCo model and data, whose tool `gripper_mjcf` has made.
        gripper: model of the gripper.

    Attributes:
        reading: state of the gripper; a new one after each step.
    """

    def __init__(self, model: Any, data: Any, gripper: GripperModel) -> None:
        self.gripper = gripper
        self._data = data
        self._model = model
        self._order = GripperOrder(0, (), 0.0, 0.0)
        # A gripper's contacts must resist creeping more than the arm alone needs.
        model.opt.impratio = 10.0
        self._actuator: int = model.actuator("tool/grip").id
        self._control = FingerControl(gripper.stroke)
        self.reading: GripperReading = self._control.reading(gripper.stroke)
        self._suction_time = 0.0
        self._fading = 0.0
        #: share of its usual grip, and seconds of holding after which it drops what it holds
        self._grip, self._drop_after = 1.0, math.inf
        self._dropped = -1  # number of the order whose part is being dropped
        self._held_for = 0.0
        if gripper.stroke:
            self._at = [int(model.joint(f"tool/{side}").qposadr[0]) for side in ("left", "right")]
            self._by = [int(model.joint(f"tool/{side}").dofadr[0]) for side in ("left", "right")]
            # Direction in which each of them closes, along the y axis of its geom.
            self._pads = {model.geom("tool/left").id: -1.0, model.geom("tool/right").id: 1.0}
        else:
            self._cup: int = model.geom("tool/cup").id
        self._friction = model.geom_friction[self.pads].copy()
        self._gain = float(model.actuator_gainprm[self._actuator, 0])

    @property
    def pads(self) -> list[int]:
        """Geoms by which it grips: the fingers, or the cup's lip."""
        return list(self._pads) if self.gripper.stroke else [self._cup]

    def is_pad(self, geom: int) -> bool:
        """Whether it grips by this geom."""
        return geom in self.pads

    def drop(self, after: float) -> None:
        """Lose what it holds, once, as soon as it has held it for some seconds."""
        self._drop_after = after

    def set_grip(self, share: float) -> None:
        """Grip with a share of the usual friction or suction from now on, 0 to 1."""
        self._grip = share
        self._apply_grip()

    def _apply_grip(self) -> None:
        share = 0.0 if self._dropped == self._order.number else self._grip
        if self.gripper.stroke:
            self._model.geom_friction[self.pads] = np.maximum(share * self._friction, _SLIPPERY)
        else:
            self._model.actuator_gainprm[self._actuator, 0] = share * self._gain

    def _lose(self, seconds: float) -> None:
        """Drop what it holds when that is due, and grip as usual with the next order."""
        held = self.reading.caught == 1
        self._held_for = self._held_for + seconds if held else 0.0
        if held and self._held_for >= self._drop_after:
            self._drop_after, self._dropped = math.inf, self._order.number
            self._apply_grip()
        elif 0 <= self._dropped != self._order.number:
            self._dropped = -1
            self._apply_grip()

    def command(self, targets: Iterable[float], speed: float, force: float) -> int:
        """Give an order, from any thread; return its number."""
        goals = tuple(min(max(float(goal), 0.0), self.gripper.stroke or 1.0) for goal in targets)
        self._order = GripperOrder(self._order.number + 1, goals, speed, force)
        return self._order.number

    def reset(self) -> None:
        """Return to the initial state, open and without an order; on the world's thread."""
        self._order = GripperOrder(self._order.number, (), 0.0, 0.0)
        self._control = FingerControl(self.gripper.stroke)
        self.reading = self._control.reading(self.gripper.stroke)
        self._suction_time = self._fading = self._held_for = 0.0

    @property
    def still(self) -> bool:
        """Whether the latest order has been carried out."""
        reading = self.reading
        return reading.number == self._order.number and not reading.moving

    def grips(self, contact: int) -> bool:
        """Whether a contact is one by which the gripper grips, holds or releases a thing.

        This holds for a contact of a finger's inner face with a thing that may move, while the
        fingers move or press on what stopped them, and for one of a cup's lip with such a thing.
        A finger does not grip a thing that it is set down on, that it pushes aside with its back,
        or that it is moved against while the fingers stand still. A thing that is fixed to the
        world is never gripped.

        Args:
            contact: number of the contact in the model's data.
        """
        found = self._data.contact
        first, second = (int(geom) for geom in found.geom[contact])
        mine, axis = (self._pads, 1) if self.gripper.stroke else ({self._cup: 1.0}, 2)
        if (first in mine) == (second in mine):
            return False
        pad, thing = (first, second) if first in mine else (second, first)
        body = int(self._model.geom_bodyid[thing])
        if self._model.body_weldid[body] == 0:
            return False
        if self._model.body_rootid[body] == self._model.body_rootid[self._model.geom_bodyid[pad]]:
            return False
        if self.gripper.stroke and not (self.reading.moving or self.reading.caught == 1):
            return False
        # MuJoCo's normal points from the first geom to the second.
        normal = found.frame[contact][:3] * (1.0 if pad == first else -1.0)
        inward = mine[pad] * self._data.geom_xmat[pad].reshape(3, 3)[:, axis]
        return float(normal @ inward) > _FACING

    def step(self, seconds: float) -> None:
        """Drive the gripper for the world's next step [s]."""
        self._lose(seconds)
        if self.gripper.stroke:
            self._drive(seconds)
        else:
            self._suck(seconds)

    def _drive(self, seconds: float) -> None:
        order, stroke = self._order, self.gripper.stroke
        qpos, qvel = self._data.qpos, self._data.qvel
        left, right = self._at
        opening = stroke - float(qpos[left]) - float(qpos[right])
        rate = -float(qvel[self._by[0]]) - float(qvel[self._by[1]])
        aim = self._control.tick(order, opening, rate, seconds)
        if order.number != self.reading.number:
            force = order.force or self.gripper.force[1]
            self._model.actuator_forcerange[self._actuator] = (-force, force)
        self._data.ctrl[self._actuator] = stroke - aim
        self.reading = self._control.reading(opening)

    def _suck(self, seconds: float) -> None:
        order = self._order
        sucking = order.targets == (0.0,)
        if order.number != self.reading.number:
            self._fading = 0.0 if sucking or order.speed else _FADING
        # A cup whose part is dropped has no vacuum until the next order.
        touching = self._dropped != order.number and bool(
            (self._data.contact.geom == self._cup).any()
        )
        self._fading = max(0.0, self._fading - seconds)
        self._data.ctrl[self._actuator] = float(sucking or self._fading > 0.0)
        before = self._suction_time >= _BUILD_UP
        self._suction_time = self._suction_time + seconds if sucking and touching else 0.0
        held = self._suction_time >= _BUILD_UP
        lost = sucking and not held and (self.reading.lost or before)
        waiting = sucking and touching and not held
        self.reading = GripperReading(
            order.number, 0.0, waiting or self._fading > 0.0, int(held), lost
        )


def gripper_mjcf(gripper: GripperModel) -> str:
    """Give a gripper as an MJCF tool: boxes of about its size, by its stroke, length and mass."""
    values = _fingers(gripper) if gripper.stroke else _cup(gripper)
    name = "fingers.xml" if gripper.stroke else "cup.xml"
    text = Template(resources.files("aioduco.sim.physics").joinpath(name).read_text("utf-8"))
    shown = {key: f"{value:.6g}" for key, value in values.items()}
    return text.substitute(shown, name=gripper.name, grip=_GRIP, force=f"{gripper.force[1]:g}")


#: contact parameters of finger tips and cup; by the priority they hold for whatever touches these
_GRIP = (
    f'priority="5" condim="4" friction="{FRICTION} 0.01 0.0005" '
    'solref="0.004 1" solimp="0.99 0.999 0.0005"'
)


def _fingers(gripper: GripperModel) -> dict[str, float]:
    """The lengths and masses of a gripper with fingers."""
    palm = 0.5 * (gripper.length - _UP)
    wide = 0.5 * gripper.stroke + 2.0 * _THICK
    return {
        "palm": palm,
        "palm_width": min(wide, 0.045),
        "palm_mass": gripper.mass - 2 * _FINGER,
        "wide": wide,
        "rail": 2 * palm - 0.008,
        "beside": 0.5 * gripper.stroke + _THICK,
        "length": gripper.length,
        "travel": 0.5 * gripper.stroke,
        "inertia": _INERTIA,
        "across": _ACROSS,
        "thick": _THICK,
        "half": 0.5 * (_UP + _DOWN),
        "below": 0.5 * (_DOWN - _UP),
        "finger": _FINGER,
        "stiffness": _STIFFNESS,
        "damping": _DAMPING,
    }


def _cup(gripper: GripperModel) -> dict[str, float]:
    """The lengths and masses of a gripper with a cup."""
    return {
        "stem": 0.5 * (gripper.length - 0.01),
        "stem_mass": gripper.mass - 0.02,
        "lip": gripper.length - 0.005,
        "cup": _CUP,
    }
