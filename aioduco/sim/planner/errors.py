"""Why a motion cannot be planned."""

from __future__ import annotations

from typing import Literal, TypeAlias

__all__ = ["PlanCode", "PlanError"]

PlanCode: TypeAlias = Literal["unreachable", "singular", "limits", "parameter"]


class PlanError(Exception):
    """A motion cannot be planned; the arm was not moved.

    Attributes:
        code: "unreachable": no configuration reaches a pose of the path. "singular": the path
            comes so near to a singularity that the joints could not follow. "limits": a joint
            would leave its limits. "parameter": the motion makes no sense as given.
    """

    def __init__(self, code: PlanCode, message: str) -> None:
        self.code: PlanCode = code
        super().__init__(message)
