"""Generate `aioduco/compat/_generated.py`: what the vendor's Python class has otherwise.

    python idl/generate_compat.py            write the module
    python idl/generate_compat.py --check    compare the whole text with what is committed

Most functions of the vendor's class are those of `aioduco/_wire/rpc.py`, which it inherits. Written
here are those whose parameters the manual names otherwise or lets callers leave out, and the
functions that the manual spells otherwise, as `tests/data/manual-3.8.json` has them.
"""

from __future__ import annotations

import argparse
import difflib
import inspect
import json
import re
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from aioduco._wire import rpc  # noqa: E402  # of this checkout

MANUAL = ROOT / "tests" / "data" / "manual-3.8.json"
TARGET = ROOT / "aioduco" / "compat" / "_generated.py"

HEADER = '''"""The functions as the vendor's Python class has them.

Generated from `aioduco/_wire/rpc.py` and the manual's data by `idl/generate_compat.py`; change
that, not this. Order and names of the functions, and the order of arguments, are the wire's; the
names of arguments are the manual's. What is the same in both is inherited.
"""

# As in aioduco/_wire/rpc.py: what came over the wire becomes what the IDL says it is.
# mypy: disable-error-code="no-any-return"
# The names of arguments are the manual's, which differ from the wire's on purpose.
# pyright: reportIncompatibleMethodOverride=false

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from aioduco._wire.rpc import Functions, Op

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco._wire.rpc import {structs}


class ManualFunctions(Functions):
    """Every function of the wire, under its name there and under the manual's."""
'''

#: what the vendor's Python class fills in, by function and parameter of the wire
DEFAULTS: dict[str, dict[str, str]] = {
    "fc_move": {"block": "False"},
    "trackCartMotion": {"radius": "0.005"},
    "movec_eaxis": {"mode": "0"},
    "start_record_track": {"interval": "None"},
    "spline": {"r": "0.0"},
    "spline_op": {"r": "0.0"},
}
SERVO = {"kp": "200.0", "kd": "25.0", "smooth_vel": "10.0", "smooth_acc": "1.0"}
for _name in ("servoj", "servoj_pose", "servo_tcp", "servol"):
    DEFAULTS[_name] = SERVO

#: other spellings that the manual has besides those in its list of functions
ALIASES = {"get_nonblock_taskstate": "get_noneblock_taskstate"}

#: what is to be known of a function besides its line in the IDL
NOTES = {
    "trackCartMotion": (
        "The manual prints `wobj` before `tool`; this is the wire's order: name them."
    ),
    "start_record_track": (
        "Without `interval` it is 5.0 [deg] in mode 0 and 0.5 [s] in mode 1, as the vendor has it."
    ),
}


def manual_names() -> tuple[dict[str, dict[str, str]], dict[str, str]]:
    """By function of the wire the manual's names of its parameters; by other name the function."""
    names: dict[str, dict[str, str]] = {}
    aliases = dict(ALIASES)
    for function in json.loads(MANUAL.read_text(encoding="utf-8"))["functions"]:
        wire = function["wire"]
        if wire is None:
            continue
        names[wire] = {p["wire"]: p["name"] for p in function["parameters"] if p["wire"]}
        if function["name"] != wire:
            aliases[function["name"]] = wire
    return names, aliases


def default(function: str, parameter: str, kind: str) -> str | None:
    """What stands for a parameter that is left out; None if it cannot be."""
    if kind == "Op":
        return "None"
    if parameter == "def_acc":
        return "False"
    return DEFAULTS.get(function, {}).get(parameter)


def head(name: str, signature: inspect.Signature, renamed: dict[str, str]) -> list[str]:
    """The lines of a method's `def`."""
    declared = ["self"]
    optional = False
    for parameter, given in list(signature.parameters.items())[1:]:
        kind = str(given.annotation)
        value = default(name, parameter, kind)
        if optional and value is None:
            raise SystemExit(f"{name}: {parameter} follows one that may be left out")
        optional = value is not None
        text = f"{renamed.get(parameter, parameter)}: {kind}"
        if value == "None":
            text += " | None"
        declared.append(text if value is None else f"{text} = {value}")
    line = f"    def {name}({', '.join(declared)}) -> {signature.return_annotation}:"
    if len(line) <= 100:
        return [line]
    inner = f"        {', '.join(declared)}"
    body = [inner] if len(inner) <= 100 else [f"        {each}," for each in declared]
    return [f"    def {name}(", *body, f"    ) -> {signature.return_annotation}:"]


def call(name: str, sent: list[str]) -> list[str]:
    """The lines of the call, as a formatter breaks them."""
    arguments = f"({', '.join(sent)}{',' if len(sent) == 1 else ''})"
    line = f'        return self._call("{name}", {arguments})'
    if len(line) <= 100:
        return [line]
    flat = f'            "{name}", {arguments}'
    if len(flat) <= 100:
        return ["        return self._call(", flat, "        )"]
    if len(arguments) + 13 <= 100:
        inner = [f"            {arguments},"]
    else:
        inner = ["            (", *(f"                {each}," for each in sent), "            ),"]
    return ["        return self._call(", f'            "{name}",', *inner, "        )"]


def method(name: str, function: Any, renamed: dict[str, str]) -> list[str]:
    """The lines of one method."""
    signature = inspect.signature(function)
    sent = [
        renamed.get(parameter, parameter) + (" or Op()" if given.annotation == "Op" else "")
        for parameter, given in list(signature.parameters.items())[1:]
    ]
    lines = head(name, signature, renamed)
    note = f'\n\n        {NOTES[name]}\n        """' if name in NOTES else '"""'
    lines += f'        """{function.__doc__}{note}'.split("\n")
    if name == "start_record_track":
        lines += [
            "        if interval is None:",
            "            interval = 5.0 if mode == 0 else 0.5",
        ]
    return lines + call(name, sent)


def differs(name: str, function: Any, renamed: dict[str, str]) -> bool:
    """Whether the manual has a function otherwise than the wire."""
    parameters = inspect.signature(function).parameters
    return any(
        renamed.get(parameter, parameter) != parameter
        or default(name, parameter, str(given.annotation)) is not None
        for parameter, given in parameters.items()
    )


def generate() -> str:
    """The whole text of the module."""
    names, aliases = manual_names()
    functions = {
        name: function
        for name, function in vars(rpc.Functions).items()
        if inspect.isfunction(function) and not name.startswith("_")
    }
    out = []
    written = set()
    for name, function in functions.items():
        renamed = names.get(name, {})
        if differs(name, function, renamed):
            written.add(name)
            out += ["", *method(name, function, renamed)]
    out += ["", "    # as the manual spells them"]
    for alias, name in sorted(aliases.items()):
        out.append(
            f"    {alias}: Final = {name}"
            if name in written
            else f"    {alias}: Final = Functions.{name}"
        )
    text = "\n".join(out)
    structs = [
        name
        for name, struct in sorted(vars(rpc).items())
        if name != "Op"
        and hasattr(struct, "thrift_spec")
        and re.search(rf"[ \[]{name}\b(?! =)", text)
    ]
    return HEADER.format(structs=", ".join(structs)) + text + "\n"


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--check", action="store_true", help="fail if the module is out of date")
    options = parser.parse_args()
    text = generate()
    if not options.check:
        TARGET.write_text(text, encoding="utf-8")
        return 0
    committed = TARGET.read_text(encoding="utf-8") if TARGET.exists() else ""
    diff = list(
        difflib.unified_diff(
            committed.splitlines(), text.splitlines(), str(TARGET), "generated", lineterm=""
        )
    )
    if diff:
        print("\n".join(diff[:80]))
        print("compat/_generated.py is out of date: run python idl/generate_compat.py")
        return 1
    print("compat/_generated.py is up to date")
    return 0


if __name__ == "__main__":
    sys.exit(main())
