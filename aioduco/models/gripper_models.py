"""Grippers by name: stroke, force, speed, mass, length, and the source of these figures."""

from __future__ import annotations

from typing import NamedTuple

from aioduco.models.words import one_of


class GripperModel(NamedTuple):
    """Published data of a gripper.

    Attributes:
        name: name in this package.
        title: name that the manufacturer uses.
        stroke: largest opening between the fingers [m]; 0 for suction.
        force: smallest and largest force that can be set [N]; equal if it cannot be set.
        speed: smallest and largest opening speed that can be set [m/s]; None if it cannot be set.
        fastest: maximum opening speed [m/s].
        mass: mass without a coupling [kg].
        length: distance from the flange to the middle of the finger tips, closed on a part [m].
        source: source of the figures.
    """

    name: str
    title: str
    stroke: float
    force: tuple[float, float]
    speed: tuple[float, float] | None
    fastest: float
    mass: float
    length: float
    source: str


_ROBOTIQ_2F = "Robotiq, 2F-85 & 2F-140 instruction manual, section 6.1"
_HAND_E = "Robotiq, Hand-E Gripper instruction manual, section 6"
_AG = "DH-Robotics, AG-95 Gripper short manual (Modbus-RTU), section 1.1"
_PGE = "DH-Robotics, PGE series short manual, section 1.1"
_OURS = "no make: figures of a gripper of its kind"

_ALL = (
    GripperModel(
        "robotiq_2f85", "Robotiq 2F-85", 0.085, (20.0, 235.0), (0.02, 0.15), 0.15, 0.9, 0.15,
        _ROBOTIQ_2F,
    ),
    GripperModel(
        "robotiq_2f140", "Robotiq 2F-140", 0.140, (10.0, 125.0), (0.03, 0.25), 0.25, 1.0, 0.22,
        _ROBOTIQ_2F,
    ),
    GripperModel(
        "robotiq_hand_e", "Robotiq Hand-E", 0.050, (60.0, 130.0), (0.02, 0.15), 0.15, 1.0, 0.14,
        _HAND_E,
    ),
    # Its speed cannot be set: it opens or closes in 0.7 s.
    GripperModel("dh_ag95", "DH AG-95", 0.095, (45.0, 160.0), None, 0.135, 1.0, 0.17, _AG),
    # 26 mm in 0.45 s; its speed is set in hundredths.
    GripperModel(
        "dh_pge", "DH PGE-50-26", 0.026, (15.0, 50.0), (0.00058, 0.058), 0.058, 0.4, 0.13, _PGE
    ),
    GripperModel("parallel", "parallel gripper", 0.080, (80.0, 80.0), None, 0.2, 0.6, 0.14, _OURS),
    # Force of a cup of 40 mm at 60 kPa below ambient pressure, from its area.
    GripperModel("vacuum", "suction cup", 0.0, (75.0, 75.0), None, 0.0, 0.3, 0.10, _OURS),
)  # fmt: skip

GRIPPERS: dict[str, GripperModel] = {model.name: model for model in _ALL}
"""The grippers that are known, by name."""


def gripper_model(name: str) -> GripperModel:
    """Return the gripper of this name.

    Raises:
        ParameterError: there is no gripper of this name.
    """
    return GRIPPERS[one_of("gripper", name, GRIPPERS)]
