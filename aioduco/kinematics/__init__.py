"""Kinematics of the DUCO arms on this computer, without a controller."""

from __future__ import annotations

from aioduco.kinematics.arm import POSITION_LIMIT, Arm, Singularity
from aioduco.kinematics.catalogue import arm, models
from aioduco.kinematics.checking import Finding, PointReport, Problem, check
from aioduco.kinematics.geometry import DhCorrections, Geometry
from aioduco.kinematics.mounting import gravity
from aioduco.kinematics.payload import (
    MeasuredLoad,
    identify_load_by_forces,
    identify_load_by_torques,
)
from aioduco.kinematics.tool_tip import (
    ToolAxes,
    ToolTip,
    calibrate_tool_axes,
    calibrate_tool_tip,
)

__all__ = [
    "POSITION_LIMIT",
    "Arm",
    "DhCorrections",
    "Finding",
    "Geometry",
    "MeasuredLoad",
    "PointReport",
    "Problem",
    "Singularity",
    "ToolAxes",
    "ToolTip",
    "arm",
    "calibrate_tool_axes",
    "calibrate_tool_tip",
    "check",
    "gravity",
    "identify_load_by_forces",
    "identify_load_by_torques",
    "models",
]
