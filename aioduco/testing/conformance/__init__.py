"""Comparison of a controller's behaviour with that of the simulated one."""

from __future__ import annotations

from aioduco.testing.conformance.controller_report import CheckResult, ControllerReport, Verdict
from aioduco.testing.conformance.suite import check_controller

__all__ = ["CheckResult", "ControllerReport", "Verdict", "check_controller"]
