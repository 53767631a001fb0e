"""Generate `aioduco/compat/_generated.py`: what the vendor's Python class has otherwise.

    python idl/generate_compat.py            write the module
    python idl/generate_compat.py --check    compare the whole text with what is committed

Most functions of the vendor's class are those of `aioduco/_wire/rpc.py`, which it inherits. Written
here are those that have other names of parameters or may be called with less, and a table of the
further names. Names and defaults come from `tests/data/vendor-python.json`, introspected from the
class, then from `tests/data/manual-3.8.json`.
"""

from __future__ import annotations

import argparse
import ast
import difflib
import inspect
import json
import re
import sys
from pathlib import Path
from typing import Any, NamedTuple

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from aioduco._wire import rpc  # noqa: E402  # of this checkout

MANUAL = ROOT / "tests" / "data" / "manual-3.8.json"
VENDOR = ROOT / "tests" / "data" / "vendor-python.json"
TARGET = ROOT / "aioduco" / "compat" / "_generated.py"

HEADER = '''"""The functions as the vendor's Python class has them.

Generated from `aioduco/_wire/rpc.py` and the data of the vendor's class and manual by
`idl/generate_compat.py`; change that, not this. Order and names of the functions, and the order of
arguments, are the wire's; names and defaults of arguments are the class's. What is the same in
both is inherited.
"""

# As in aioduco/_wire/rpc.py: what came over the wire becomes what the IDL says it is.
# mypy: disable-error-code="no-any-return"
# The names of arguments are the vendor's, some of which differ from the wire's on purpose.
# pyright: reportIncompatibleMethodOverride=false

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from aioduco._wire.rpc import Functions, NewerFunctions
from aioduco.compat._arguments import no_fixed_radius

if TYPE_CHECKING:
    from collections.abc import Sequence

    from aioduco._wire.rpc import {structs}

#: by function what else its arguments are called, by the manual and by other versions of the class
KEYWORDS: Final[dict[str, dict[str, str]]] = {{
{keywords}
}}


class ManualFunctions(NewerFunctions):
    """Every function of the wire, under its name there and under the manual's."""
'''

#: other spellings than those in the manual's list of functions
ALIASES = {"get_nonblock_taskstate": "get_noneblock_taskstate"}

#: defaults of the manual that stand against those of the class
PRINTED = {("fc_move", "block"): "True"}

#: parameters for which None stands for the present one: nothing is sent, or nothing is in it
NULLABLE = frozenset({"q_near", "qnear", "tool", "wobj", "ref_pos"})

#: what is to be known of a function besides its line in the IDL
NOTES = {
    "trackCartMotion": (
        "The manual prints `wobj` before `tool`; this is the wire's order: name them."
    ),
    "start_record_track": (
        "Without `interval` it is 5.0 [deg] in mode 0 and 0.25 [s] in mode 1, as the manual prints."
    ),
    "fc_move": "Without `block` it returns at the end of its task, as the manual prints it.",
    "movec": (
        "`arc_rad`, of manual 4.3, is taken as 0, no fixed radius; others cannot be sent: the "
        "number of\n        its field is not known."
    ),
    "move_eaxis": "`def_acc` is taken since the manual prints it; the wire has no place for it.",
}


class Parameter(NamedTuple):
    """A parameter of a method.

    Attributes:
        name: what the method calls it.
        kind: its annotation.
        default: what stands for it if it is left out, as Python writes it; None if it cannot be.
        sent: whether the wire has it.
    """

    name: str
    kind: str
    default: str | None
    sent: bool = True


class Sources:
    """What the vendor's class and manual say of names and defaults.

    Attributes:
        keywords: by function of the wire its parameters' other names.
        aliases: by further name of a function the function of the wire.
    """

    def __init__(self) -> None:
        vendor = json.loads(VENDOR.read_text(encoding="utf-8"))
        self._newest = {name: next(iter(by_text)) for name, by_text in vendor["signatures"].items()}
        self._manual: dict[tuple[str, str], Any] = {}
        self._names: dict[str, dict[str, str]] = {}
        self.keywords: dict[str, dict[str, str]] = {"fc_config": {"num_list": "dead_zone"}}
        self.aliases = dict(ALIASES)
        for function in json.loads(MANUAL.read_text(encoding="utf-8"))["functions"]:
            wire = function["wire"]
            if wire is None:
                continue
            self._names[wire] = {p["wire"]: p["name"] for p in function["parameters"] if p["wire"]}
            for p in function["parameters"]:
                if "default" in p:
                    self._manual[wire, p["wire"] or p["name"]] = p["default"]
            if function["name"] != wire:
                self.aliases[function["name"]] = wire
        for row in vendor["manual_text"]:
            self._manual[row["function"], row["parameter"]] = row["default"]
        for row in vendor["chosen"]:
            for name in row["functions"]:
                self._manual[name, row["parameter"]] = row.get("default", row.get("class"))

    def parameters(self, name: str, function: Any) -> list[Parameter]:
        """The parameters of one function, and its other names for them in `keywords`."""
        declared = list(inspect.signature(function).parameters.items())[1:]
        theirs = self._newest.get(name, "").split(", ") if self._newest.get(name) else []
        given = [text.partition("=")[::2] for text in theirs]
        found = []
        for index, (wire, parameter) in enumerate(declared):
            vendor, default = given[index] if index < len(given) else (wire, "")
            kind = str(parameter.annotation)
            default = PRINTED.get((name, wire), default)
            found.append(Parameter(vendor, kind, self._default(name, wire, kind, default)))
            for other in (wire, self._names.get(name, {}).get(wire, wire)):
                if other != vendor:
                    self.keywords.setdefault(name, {})[other] = vendor
        if (name, "def_acc") in self._manual and not any(p.name == "def_acc" for p in found):
            found.append(Parameter("def_acc", "bool", "False", sent=False))
        if name == "movec":
            found.append(Parameter("arc_rad", "float", "0.0", sent=False))
        for index in reversed(range(len(found) - 1)):  # what follows may not be left out
            if found[index + 1].default is None:
                found[index] = found[index]._replace(default=None)
        return [self._nullable(name, parameter) for parameter in found]

    def _default(self, name: str, wire: str, kind: str, vendor: str) -> str | None:
        if kind == "Op" or vendor in ("op_", "[]"):
            return "None"
        if not vendor:
            if (name, wire) not in self._manual:
                return None
            vendor = repr(self._manual[name, wire])
        value = ast.literal_eval(vendor)
        if kind == "float" and value is not None:
            value = float(value)
        return repr(value).replace("'", '"')

    @staticmethod
    def _nullable(name: str, parameter: Parameter) -> Parameter:
        known = parameter.name in NULLABLE or parameter.name in ("toolname", "wobjname")
        if parameter.default == "None" or (known and not name.startswith("set_")):
            return parameter._replace(kind=f"{parameter.kind} | None")
        return parameter


def head(name: str, returned: str, parameters: list[Parameter]) -> list[str]:
    """The lines of a method's `def`."""
    declared = ["self"]
    for parameter in parameters:
        text = f"{parameter.name}: {parameter.kind}"
        declared.append(text if parameter.default is None else f"{text} = {parameter.default}")
    line = f"    def {name}({', '.join(declared)}) -> {returned}:"
    if len(line) <= 100:
        return [line]
    inner = f"        {', '.join(declared)}"
    body = [inner] if len(inner) <= 100 else [f"        {each}," for each in declared]
    return [f"    def {name}(", *body, f"    ) -> {returned}:"]


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


def method(name: str, function: Any, parameters: list[Parameter]) -> list[str]:
    """The lines of one method."""
    lines = head(name, str(inspect.signature(function).return_annotation), parameters)
    note = f'\n\n        {NOTES[name]}\n        """' if name in NOTES else '"""'
    lines += f'        """{function.__doc__}{note}'.split("\n")
    if name == "start_record_track":
        lines += [
            "        if interval is None:",
            "            interval = 5.0 if mode == 0 else 0.25",
        ]
    if name == "movec":
        lines.append("        no_fixed_radius(arc_rad)")
    return lines + call(name, [parameter.name for parameter in parameters if parameter.sent])


def differs(function: Any, parameters: list[Parameter]) -> bool:
    """Whether a method is otherwise than the wire's."""
    declared = list(inspect.signature(function).parameters.values())[1:]
    return [(p.name, p.kind, p.default) for p in parameters] != [
        (each.name, str(each.annotation), None) for each in declared
    ]


def table_row(name: str, names: dict[str, str]) -> list[str]:
    """The lines of one entry of a table, as a formatter breaks them."""
    line = f'    "{name}": {json.dumps(names)},'
    if len(line) <= 100:
        return [line]
    return [
        f'    "{name}": {{',
        *(f'        "{key}": "{value}",' for key, value in names.items()),
        "    },",
    ]


def generate() -> str:
    """The whole text of the module."""
    sources = Sources()
    functions = {
        name: function
        for name, function in vars(rpc.Functions).items()
        if inspect.isfunction(function) and not name.startswith("_")
    }
    out = []
    written = set()
    for name, function in functions.items():
        parameters = sources.parameters(name, function)
        if differs(function, parameters):
            written.add(name)
            out += ["", *method(name, function, parameters)]
    out += ["", "    # as the manual spells them"]
    for alias, name in sorted(sources.aliases.items()):
        home = "" if name in written else "Functions."
        out.append(f"    {alias}: Final = {home}{name}")
    text = "\n".join(out)
    structs = [
        name
        for name, struct in sorted(vars(rpc).items())
        if hasattr(struct, "thrift_spec") and re.search(rf"[ \[]{name}\b(?! =)", text)
    ]
    keywords = "\n".join(
        line for name, names in sorted(sources.keywords.items()) for line in table_row(name, names)
    )
    return HEADER.format(structs=", ".join(structs), keywords=keywords) + text + "\n"


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
