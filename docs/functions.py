"""Write `docs/functions.md`: each function of the manual, on the wire, and in this package.

    python docs/functions.py            write the page
    python docs/functions.py --check    compare the whole text with what is committed

The wire and its meanings come from `idl/robot.thrift`, the manuals' names from
`tests/data/manual-3.8.json` and `manual-4.3.json`, what older controllers lack from
`aioduco/sim/server/older_wires.json`, our names from `aioduco/models/names.py`.
"""

from __future__ import annotations

import argparse
import json
import re
import sys
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
PAGE = HERE / "functions.md"
IDL = ROOT / "idl" / "robot.thrift"
DATA = ROOT / "tests" / "data"

sys.path.insert(0, str(ROOT))

from aioduco.api.blocking import BlockingMotions  # noqa: E402  # of this checkout
from aioduco.models import names  # noqa: E402  # of this checkout
from aioduco.models.names import BY_ITSELF, CLIENT_SIDE  # noqa: E402  # of this checkout

#: Section -> the tables of `docs/fidelity.md` on its functions in the simulated controller
TABLES = {
    "1.3.1": "Heartbeat",
    "1.3.2": "States",
    "1.3.3": "Stop, pause, resume",
    "1.3.4": "Programs; Files, settings, service",
    "1.3.5": (
        "Motion; Triggers along a path (`op`); Servo motions; Velocities, jogs, hand guiding; "
        "Recorded tracks; Paths and speeds"
    ),
    "1.3.6": "Buses",
    "1.3.7": (
        "Signals; Registers and system values; What is read; Status structs; "
        "States; Recorded tracks; Files, settings, service"
    ),
    "1.3.8": "Tasks; Stop, pause, resume; Safety",
    "1.3.9": "Buses",
    "1.3.10": "Force control",
    "1.3.11": "Motion, other settings",
    "1.3.12": "Track pool",
    "1.3.13": "Combined motion",
    "1.3.14": "External axes",
    "1.3.15": "Realtime control",
    "1.3.16": "What is read",
    "Service": "Files, settings, service; Refused",
}

BLOCKING = {name for name in vars(BlockingMotions) if name[0] != "_"}

HEAD = """# Functions

Every function of the manual (version 3.8, sections 1.3.1 to 1.3.16) and of the wire, and its name
here. Names are those of the wire; where the manual has another one, it stands in brackets. The
parameter `block` does not appear here: a motion is awaited, or started and followed. Those that
[`robot.blocking`](reference/blocking.md) has, too, are called there with `block` true. What a
function does is said of the wire: times that it has in ms are in seconds here.

The last column says which controllers lack the function: *oldest* and *older* are two generations
of the vendor's client that public repositories carry; which versions of the controller's software
they belong to is not known. A call of a function that a controller lacks raises
[`UnknownFunction`](reference/errors.md), which names the controller's version, and does nothing.
`robot.version.controller` has it from connecting on. What older controllers take otherwise, and
what [manual 4.3](#manual-43) adds, is at the end of the page.

`aioduco call NAME` calls any of them from a shell, and `aioduco call NAME --describe` says what it
takes. A call that changes something asks first.

Written by `docs/functions.py`."""

OLDER = """
## Older controllers

They ignore parameters and fields that they do not know, without an error: what this table lists has
no effect there.

| function | oldest and older | oldest alone |
|---|---|---|"""

OLDER_REST = """
`combine_motion_config` and `set_hand_teach_parameter` have parameters of another type there, which
such a controller ignores and takes for zero: do not call them on it. `fc_move` blocks there: call
`robot.blocking.fc_move`, since `robot.force.fc_move` is stopped as one that is not answered. The
oldest does not know `Op.on_stop`: **an output that a stop is to switch is not switched**. In the
oldest, `getRobotIOStatus` has fewer lists, under other field numbers. An answer that does not fit
the present numbers is read by those; the lists that are missing are empty. With `active` false
`robot.frames.set_wobj_offset` sends an offset of zero, which ends a shift on the oldest, too.

Of a still older one, wrappers are public that give `tcp_move` and `tcp_move_2p` no tool and no work
object, and `servoj` and `servoj_pose` no `block`; later parameters move up. Nothing tells this
controller from the oldest. If it takes no other calls, it **moves by the tool in use, whatever
`tool` says, and switches no outputs of these motions**; and `servoj` gets its `kp` as `kd`."""

NEWER = """
## Manual 4.3

What manual 4.3 has beyond 3.8. Only functions whose place on the wire is known can be called: the
wire is numbered, and no public source has the numbers of the others. A function without arguments
needs none; a controller that is older raises [`UnknownFunction`](reference/errors.md).

| function | here | what it does |
|---|---|---|"""

CHANGED = """
And what it describes otherwise:

| what | change |
|---|---|"""


def sections() -> dict[str, list[tuple[str, str]]]:
    """Section heading -> its functions on the wire, each with its meaning."""
    text = IDL.read_text(encoding="utf-8")
    service = text[text.index("service RPCRobot {") : text.index("service RPCRobotNewer")]
    found: dict[str, list[tuple[str, str]]] = {}
    current: list[tuple[str, str]] = []
    pattern = r"^  // (?P<head>.+)$|/\*\* (?P<about>.+?) \*/\n\s*[\w<>,]+ (?P<name>\w+)\("
    for match in re.finditer(pattern, service, re.MULTILINE):
        if match["head"]:
            current = found.setdefault(match["head"], [])
        else:
            current.append((match["name"], match["about"]))
    return found


def ours(name: str) -> str:
    """How a program writes a function of the wire; empty if it cannot."""
    where = names.place(name)
    if where is None:
        return BY_ITSELF.get(name, "")
    return f"`{where}`, `robot.blocking.{name}`" if name in BLOCKING else f"`{where}`"


def lacking() -> dict[str, str]:
    """Function -> which older controllers lack it."""
    older = {name: set(one["lacks"]) for name, one in _older_wires().items()}
    every = set.union(*older.values())
    return {name: ", ".join(one for one in older if name in older[one]) for name in every}


def older() -> list[str]:
    """The rows of the parameters that older controllers do not know."""
    wire = _data("wire")["methods"]
    unknown: dict[str, dict[str, list[str]]] = {}
    for generation, one in _older_wires().items():
        for name, fields in one["methods"].items():
            places = {tuple(place) for place in fields}
            missing = [place[2] for place in wire[name]["args"] if tuple(place) not in places]
            unknown.setdefault(name, {})[generation] = missing
    rows = []
    for name in sorted(unknown):
        both = unknown[name].get("older", [])
        oldest = [one for one in unknown[name].get("oldest", []) if one not in both]
        if both or oldest:
            shown = (", ".join(f"`{one}`" for one in each) for each in (both, oldest))
            rows.append(f"| `{name}` | {' | '.join(shown)} |")
    return rows


def newer() -> list[str]:
    """The rows of what manual 4.3 adds, and of what it changes."""
    data = _data("manual-4.3")
    rows = [
        f"| `{one['name']}` | {ours(one['name']) or 'not callable'} | {one['meaning']} |"
        for one in data["new"]
    ]
    changed = [f"| {one['item']} | {one['change'].replace('|', ',')} |" for one in data["changed"]]
    return [*rows, CHANGED, *changed]


def _older_wires() -> dict[str, Any]:
    """The generations of which a generated client is known."""
    path = ROOT / "aioduco" / "sim" / "server" / "older_wires.json"
    versions = json.loads(path.read_text(encoding="utf-8"))["versions"]
    return {name: versions[name] for name in ("older", "oldest")}


def _data(name: str) -> Any:
    return json.loads((DATA / f"{name}.json").read_text(encoding="utf-8"))


def _anchor(heading: str) -> str:
    """The address of a heading on its page."""
    return re.sub(r"\s+", "-", re.sub(r"[^\w\s-]", "", heading).strip().lower())


def page() -> str:
    """The whole text of the page."""
    functions = _data("manual-3.8")["functions"]
    lacks = lacking()
    manual = {entry["wire"]: entry["name"] for entry in functions if entry["wire"]}
    lines = [HEAD]
    for head, entries in sections().items():
        number = head.split()[0].rstrip(":").capitalize()
        lines.append(f"\n## {head[0].upper()}{head[1:]}\n")
        links = (f"[{one}](fidelity.md#{_anchor(one)})" for one in TABLES[number].split("; "))
        lines.append(f"Simulated: {'; '.join(links)}.\n")
        lines += ["| function | here | what it does | missing |", "|---|---|---|---|"]
        for name, about in entries:
            printed = manual.get(name)
            shown = f"`{name}`" + (f" (`{printed}`)" if printed not in {name, None} else "")
            lines.append(f"| {shown} | {ours(name)} | {about} | {lacks.get(name, '')} |")
        if number == "1.3.1":
            lines += [
                f"| `{name}` | {here} | Not on the wire. | |"
                for name, here in CLIENT_SIDE.items()
                if name != "get_version"
            ]
        if number == "1.3.16":
            lines.append(f"| `get_version` | {CLIENT_SIDE['get_version']} | Not on the wire. | |")
    lines += [OLDER, *older(), OLDER_REST, NEWER, *newer()]
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
