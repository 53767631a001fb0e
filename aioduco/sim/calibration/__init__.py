"""Estimates what a simulator needs to know of one arm, from recordings of it.

    found = calibrate(["run.mcap"])
    print(found)
    found.profile.save("arm.toml")
    Simulator(profile="arm.toml")

`evidence` reads recordings into arrays; `geometry`, `drives`, `times`, `heartbeat`, `torques` and
`blends` estimate, each a section of the profile, without files; `calibrate` puts them together.
"""

from __future__ import annotations

from aioduco.sim.calibration.calibrate import Calibration, calibrate, profile_of

__all__ = ["Calibration", "calibrate", "profile_of"]
