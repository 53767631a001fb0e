"""Descriptions of the arms for other programs: URDF, SRDF, MJCF, MoveIt's configuration.

They are made from lengths, limits, masses and shapes of our own, and contain no part of the
vendor's files.
"""

from __future__ import annotations

from aioduco.descriptions.mjcf_text import mjcf_scene
from aioduco.descriptions.texts import ArmLike, mesh_files, mjcf, moveit, srdf, urdf
from aioduco.descriptions.tree import STATES, ArmDescription, ToolDescription
from aioduco.kinematics.bodies import Capsule

__all__ = [
    "STATES",
    "ArmDescription",
    "ArmLike",
    "Capsule",
    "ToolDescription",
    "mesh_files",
    "mjcf",
    "mjcf_scene",
    "moveit",
    "srdf",
    "urdf",
]
