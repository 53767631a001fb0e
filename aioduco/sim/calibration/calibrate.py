"""From recordings to a profile: every estimator in turn, and a report of what each found."""

from __future__ import annotations

import os
from dataclasses import dataclass
from itertools import combinations
from typing import TYPE_CHECKING, Final

from aioduco.errors import CalibrationError, MissingExtra
from aioduco.kinematics import arm as arm_of
from aioduco.kinematics import models
from aioduco.sim.calibration.blends import estimate_blends
from aioduco.sim.calibration.drives import estimate_drives, estimate_noise
from aioduco.sim.calibration.evidence import Evidence, read_evidence
from aioduco.sim.calibration.findings import not_played, played
from aioduco.sim.calibration.geometry import estimate_geometry
from aioduco.sim.calibration.times import (
    estimate_period,
    estimate_slack,
    estimate_times,
    single_precision,
)
from aioduco.sim.calibration.torques import estimate_friction, estimate_load
from aioduco.sim.profile import RANGES, ArmProfile

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco.sim.calibration.findings import Findings
    from aioduco.sim.profile import Estimate


_HELP: Final = "record the arm by `aioduco check HOST --motions run.mcap`"


@dataclass(frozen=True)
class Calibration:
    """A profile, and how it was found.

    Attributes:
        profile: the profile.
        notes: what was judged, and how.
        missing: what was left out, why, and what would help.
    """

    profile: ArmProfile
    notes: tuple[str, ...]
    missing: tuple[str, ...]

    def __str__(self) -> str:
        lines = [f"{self.profile.model}, from {', '.join(self.profile.sources)}"]
        for section, names in self.profile.values.items():
            lines.append(section)
            for name, (value, low, high) in names.items():
                unit = RANGES[section][name][2]
                lines.append(f"  {name:10} {value:12.6g}  {low:.6g} to {high:.6g} {unit}")
        single = self.profile.single_precision
        if single is not None:
            lines.append(f"readings are {'32-bit floats' if single else 'doubles'}")
        lines += [f"judged: {each}" for each in self.notes]
        lines += [f"left out: {each}" for each in self.missing]
        return "\n".join(lines)


def calibrate(
    paths: Sequence[str | os.PathLike[str]] | str | os.PathLike[str], *, model: str | None = None
) -> Calibration:
    """Estimate an arm's profile from recordings of it.

    Args:
        paths: one or more recordings, as `aioduco check --motions` makes them. Any recording will
            do for what it shows.
        model: the arm's model; None for what the controller reported.

    Returns:
        The profile with its intervals, and what was left out in words.

    Raises:
        CalibrationError: the recordings do not fit the arm, are of different arms, show nothing
            about it, or one is a copy of another.
        RecordingError: a file cannot be read.
        ParameterError: no such model.
        MissingExtra: the extra `calibrate` is not installed.
    """
    files = [paths] if isinstance(paths, str | os.PathLike) else paths
    return profile_of([read_evidence(path) for path in files], model=model)


def profile_of(runs: Sequence[Evidence], *, model: str | None = None) -> Calibration:
    """Estimate an arm's profile from what its recordings say; see `calibrate`."""
    name = _model(runs, model)
    for one, two in combinations(runs, 2):
        if one.says_the_same(two):
            raise CalibrationError(
                f"{two.name} says the same as {one.name}, and would count twice: leave one out; no "
                "profile was made"
            )
    with MissingExtra.named("calibration", "calibrate"):
        found = _findings(runs, name)
    missing = [text for each in found for text in each.missing]
    values: dict[str, dict[str, Estimate]] = {}
    for section, estimates in ((each.section, each.values) for each in found):
        for key, estimate in estimates.items():
            # the ranges of the geometry are around the model's, and its estimator keeps to them
            known = estimate if section == "geometry" else played(section, key, estimate)
            if known is None:
                missing.append(not_played(section, key, estimate))
            else:
                values.setdefault(section, {})[key] = known
    values = {section: values[section] for section in RANGES if section in values}
    if not values:
        raise CalibrationError(
            f"the recordings show nothing about the arm: {_HELP}; no profile was made"
        )
    profile = ArmProfile(
        name,
        values,
        single_precision([run.joints for run in runs]),
        tuple(run.name for run in runs),
    )
    notes = tuple(text for each in found for text in each.notes)
    return Calibration(profile, notes, tuple(missing))


def _findings(runs: Sequence[Evidence], model: str) -> list[Findings]:
    motions = [run.motions for run in runs]
    geometry = estimate_geometry(model, [run.poses for run in runs])
    arm = ArmProfile(model, {"geometry": geometry.values}).arm
    return [
        geometry,
        estimate_drives(motions),
        estimate_noise(motions),
        estimate_period([run.joints for run in runs]),
        estimate_times(runs),
        estimate_slack(runs),
        estimate_load(arm, runs),
        estimate_friction(runs),
        estimate_blends(arm, runs),
    ]


def _model(runs: Sequence[Evidence], model: str | None) -> str:
    told = {run.arm for run in runs if run.arm}
    if len(told) > 1:
        raise CalibrationError(
            f"the recordings are of different arms, {' and '.join(sorted(told))}: a profile is of "
            "one arm; no profile was made"
        )
    if model is not None:
        return arm_of(model).name
    text = next(iter(told), "")
    # A controller reports series, model and serial number, such as "GCR5 910 SIM00000000".
    name = "_".join(text.lower().replace("-", "_").split()[:2])
    if name not in models():
        raise CalibrationError(
            f"the recordings do not say which arm it is ({text or 'nothing was reported'}): give "
            f"--model, one of {', '.join(models())}; no profile was made"
        )
    return name
