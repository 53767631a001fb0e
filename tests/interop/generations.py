"""The whole IDL of each generation of controllers, for the Apache compiler."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

from client.older import OLDER, layout

from aioduco._wire import idl

NAMES = ("3.8", "4.3", *OLDER)
_TORQUES = ("AuxiliaryPosition", "DynamicTorque", "GravityTorque", "ActualTorque", "ExtraTorque")
#: what manual 4.3 prints otherwise, as replacements in the present IDL
_NEWER = (
    (
        "  21: i32 robotError",
        "".join(f"  {n}: list<double> joint{name}\n" for n, name in enumerate(_TORQUES, 22))
        + "  21: i32 robotError",
    ),
    ("  2: list<list<double>> joints_pos", "  2: i32 index\n  3: i32 singularity_type"),
    ("  3: double pos", "  3: double pos\n  4: double vel\n  5: double acc"),
    (
        "2: list<double> wobj, 3: list<double> tool, 4: list<double> ref",
        "2: list<double> tool, 3: list<double> wobj, 4: list<double> ref",
    ),
    (
        "12: bool def_acc\n  )\n  /** Move the tool along the full circle",
        "12: bool def_acc, 13: double arc_rad\n  )\n  /** Move the tool along the full circle",
    ),
    ("list<double> epose, 3: double v,", "list<double> epose, 3: list<double> v,"),
    ("string scheme_name,", "list<string> scheme_name,"),
    ("list<double> epose", "list<list<double>> epose"),
    ("double eaxis_v", "list<double> eaxis_v"),
)
#: the end of the present service, and the beginning of that which extends it
_TWO_SERVICES = re.compile(r"\}\n\n/\*\*[^{]*service RPCRobotNewer extends RPCRobot \{\n")


def package(generation: str) -> str:
    """The package that the compiler writes for a generation."""
    return f"generation_{re.sub(r'[^a-z0-9]', '_', generation)}"


def text(generation: str) -> str:
    """The IDL of a generation."""
    if generation in OLDER:
        return layout(generation).idl()
    present = idl.path().read_text("utf-8")
    if generation == "4.3":
        for old, new in _NEWER:
            assert old in present, old
            present = present.replace(old, new)
        present = _TWO_SERVICES.sub("", present)
    return present.replace("namespace py duco", "")


def generate(out: Path) -> None:
    """Let the compiler write a Python client for each generation."""
    for name in NAMES:
        path = out / f"{package(name)}.thrift"
        path.write_text(text(name), "utf-8")
        subprocess.run(
            ["thrift", "--gen", "py", "-out", str(out), str(path)],
            check=True,
            capture_output=True,
            timeout=600,
        )
