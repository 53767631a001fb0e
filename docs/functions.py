"""Write `docs/functions.md`: each function of the manual, on the wire, and in this package.

    python docs/functions.py            write the page
    python docs/functions.py --check    compare the whole text with what is committed

The wire and its meanings come from `idl/robot.thrift`, the manual's names from
`tests/data/manual-3.8.json`, our names from the methods in `aioduco/api/` and `aioduco/robot.py`.
"""

from __future__ import annotations

import argparse
import ast
import json
import re
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
PAGE = HERE / "functions.md"
IDL = ROOT / "idl" / "robot.thrift"
MANUAL = ROOT / "tests" / "data" / "manual-3.8.json"

HEAD = """# Functions

Every function of the manual (version 3.8, sections 1.3.1 to 1.3.16) and of the wire, and its name
here. Names are those of the wire; where the manual has another one, it stands in brackets. The
parameter `block` does not appear here: a motion is awaited, or started and followed.
Written by `docs/functions.py`."""

#: what this package does in another way than by a function of the same name
ELSEWHERE = {
    "rpc_heartbeat": "sent by itself while connected",
    "get_noneblock_taskstate": "followed by itself for each task",
}

#: functions of the manual that are not on the wire
CLIENT_SIDE = {
    "DucoCobot": "`aioduco.connect()`",
    "open": "`async with aioduco.connect() as robot`",
    "close": "the end of `async with`",
    "get_version": "`aioduco.__version__`",
}


def sections() -> dict[str, list[tuple[str, str]]]:
    """Section heading -> its functions on the wire, each with its meaning."""
    text = IDL.read_text(encoding="utf-8")
    service = text[text.index("service RPCRobot {") :]
    found: dict[str, list[tuple[str, str]]] = {}
    current: list[tuple[str, str]] = []
    pattern = r"^  // (?P<head>.+)$|/\*\* (?P<about>.+?) \*/\n\s*[\w<>,]+ (?P<name>\w+)\("
    for match in re.finditer(pattern, service, re.MULTILINE):
        if match["head"]:
            current = found.setdefault(match["head"], [])
        else:
            current.append((match["name"], match["about"]))
    return found


def ours() -> dict[str, str]:
    """Method -> how a program writes it, for the sections' classes and for `Robot`."""
    found: dict[str, str] = {}
    api = ROOT / "aioduco" / "api"
    # A section is a module, or a package whose modules hold parts of its class.
    modules = [
        (path, f"robot.{path.relative_to(api).with_suffix('').parts[0]}")
        for path in sorted(api.rglob("*.py"))
    ]
    robot = ROOT / "aioduco" / "robot.py"
    if robot.exists():
        modules.append((robot, "robot"))
    for path, prefix in modules:
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            if not isinstance(node, ast.ClassDef) or node.name.startswith("_"):
                continue
            for item in node.body:
                if not isinstance(item, ast.FunctionDef | ast.AsyncFunctionDef):
                    continue
                if not item.name.startswith("_"):
                    found[item.name] = f"`{prefix}.{item.name}`"
    return found


def page() -> str:
    """The whole text of the page."""
    functions = json.loads(MANUAL.read_text(encoding="utf-8"))["functions"]
    manual = {entry["wire"]: entry["name"] for entry in functions if entry["wire"]}
    names = ours()
    lines = [HEAD]
    for head, entries in sections().items():
        number = head.split()[0]
        lines.append(f"\n## {head[0].upper()}{head[1:]}\n")
        lines += ["| function | here | what it does |", "|---|---|---|"]
        for name, about in entries:
            printed = manual.get(name)
            shown = f"`{name}`" + (f" (`{printed}`)" if printed not in {name, None} else "")
            lines.append(f"| {shown} | {names.get(name) or ELSEWHERE.get(name, '')} | {about} |")
        if number == "1.3.1":
            lines += [
                f"| `{name}` | {here} | Not on the wire. |"
                for name, here in CLIENT_SIDE.items()
                if name != "get_version"
            ]
        if number == "1.3.16":
            lines.append(f"| `get_version` | {CLIENT_SIDE['get_version']} | Not on the wire. |")
    return "\n".join(lines) + "\n"


def main() -> int:
    """Write the page, or compare it."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--check", action="store_true", help="fail if the page is out of date")
    text = page()
    if not parser.parse_args().check:
        PAGE.write_text(text, encoding="utf-8")
        return 0
    if PAGE.read_text(encoding="utf-8") == text:
        sys.stdout.write("functions.md is up to date\n")
        return 0
    sys.stdout.write("functions.md is out of date: run python docs/functions.py\n")
    return 1


if __name__ == "__main__":
    sys.exit(main())
