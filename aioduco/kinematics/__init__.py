"""Kinematics of the DUCO arms on this computer, without a controller."""

from __future__ import annotations

from aioduco.kinematics.arm import POSITION_LIMIT, Arm, Singularity
from aioduco.kinematics.catalogue import arm, models
from aioduco.kinematics.checking import Finding, PointReport, Problem, check
from aioduco.kinematics.geometry import Geometry

__all__ = [
    "POSITION_LIMIT",
    "Arm",
    "Finding",
    "Geometry",
    "PointReport",
    "Problem",
    "Singularity",
    "arm",
    "check",
    "models",
]
