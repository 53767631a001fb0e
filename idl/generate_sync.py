"""Generate `aioduco/sync/_generated.py`: the sections of the robot for programs that wait.

    python idl/generate_sync.py            write the module
    python idl/generate_sync.py --check    compare the whole text with what is committed

Each section of `aioduco.robot.Robot`, those of streams alone included, and each coroutine of the
robot itself, becomes a class or a method with the same signature and docstring. A shape that has
no rule here ends the generator.
"""

from __future__ import annotations

import argparse
import ast
import difflib
import importlib
import inspect
import re
import sys
import textwrap
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from aioduco.api.section import Section  # noqa: E402  # of this checkout
from aioduco.robot import Robot  # noqa: E402  # of this checkout
from aioduco.streaming.realtime import RealtimeStreams  # noqa: E402  # of this checkout
from aioduco.streaming.servo import Servo  # noqa: E402  # of this checkout
from aioduco.streaming.speed import Speed  # noqa: E402  # of this checkout
from aioduco.streaming.track import TrackStreams  # noqa: E402  # of this checkout

TARGET = ROOT / "aioduco" / "sync" / "_generated.py"

#: coroutines of the robot that `aioduco/sync/_robot.py` has in its own way
BY_HAND = {"open", "aclose"}
MOTIONS = {"MotionCommand", "HeldMotion"}
#: classes whose methods make streams: bases of sections, or sections by themselves
STREAM_MAKERS = (Servo, Speed, RealtimeStreams, TrackStreams)
#: what functions return that do not wait; what ties it to a block is in these modules
TIED = {
    "MotionPath": "aioduco.sync._tasks",
    "OffsetStream": "aioduco.sync._streams",
    "Stream": "aioduco.sync._streams",
    "TrackStream": "aioduco.sync._streams",
}

DOCS = {
    "Motion": '''"""Motions of the arm (移动控制, manual 1.3.5).

    Each function checks its arguments, sends the motion, and returns when it has ended; `.start`
    returns its task as soon as the controller has accepted it; `.prepare` sends nothing:

        robot.motion.movej2(home, v=1.0, a=1.0)
        move = robot.motion.movel.start(target, v=0.2, a=0.5)
        robot.motion.run(approach, pass_by, retreat)         # made by .prepare, blended

    A motion with a blend radius `r` blends only into one that the controller has in time: see
    `run` and `path`.

    Motions at a velocity, jogs and hand guiding go on until their time is over or they are told to
    end: they are tied to a block, which ends them when it is left:

        with robot.motion.speedl.start([0, 0, -0.02, 0, 0, 0], a=0.5, time=5.0):
            ...
    """''',
}

#: what is said otherwise to a program that waits
WORDS = (
    (r"async with (robot\.motion\.path)\(", r"with \1("),
    (r"await path\.add\((robot\.[\w.]+)\(", r"path.add(\1.prepare("),
    (r"async with (robot\.(?:servo|speed)\.\w+|robot\.\w+\.stream)\(", r"with \1("),
    (r"async with (robot\.[\w.]+)\(", r"with \1.start("),
    (r"await (robot\.[\w.]+)\((.*)\)\.start\(\)", r"\1.start(\2)"),
    (r"async (with|for) ", r"\1 "),
    (r"\bawait (?=[\w.]+\()", ""),
    (r"[Cc]ancelling its await", "An interrupt while it waits"),
    (r"Cancelling this brings", "An interrupt brings"),
    (r"if this is cancelled", "if this is interrupted"),
    (r"If this is cancelled", "If this is interrupted"),
    (r"goes on to its end even if this is interrupted", "goes on to its end even if interrupted"),
    (r"The motion, not sent yet\.", "How it ended: finished or blended."),
)

HEADER = '''"""The sections of the robot for programs that wait.

Generated from `aioduco/api/` and `aioduco/robot.py` by `idl/generate_sync.py`; change those, not
this.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from aioduco.models.names import ManualNames
from aioduco.sync._tasks import awaitables, moves

if TYPE_CHECKING:
{imports}


class _Section(ManualNames):
    """A section of the manual: functions of one robot."""

    __slots__ = ("_runner", "_section")

    def __init__(self, runner: Runner, section: Any) -> None:
        self._runner = runner
        self._section = section

    def __repr__(self) -> str:
        return repr(self._section)
'''


#: what it needs of the package when it is imported
RUN_TIME = "from aioduco.sync._tasks import MotionPath, awaitables, moves"
#: what the module needs besides
OWN = {
    "from aioduco import robot as aio_robot",
    "from aioduco.supervision import command as aio_command",
    "from aioduco.sync._runner import Runner",
    "from aioduco.sync._tasks import MotionCommand",
}


class Source:
    """The text of a module, and where the names in it come from."""

    def __init__(self, module: str) -> None:
        self.module = module
        text = inspect.getsource(importlib.import_module(module))
        self.tree = ast.parse(text)
        self.imported: dict[str, str] = {}
        for node in ast.walk(self.tree):
            if isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
                for alias in node.names:
                    self.imported[alias.asname or alias.name] = _import(node.module, alias)
        #: names of the module's own for types, which it keeps to itself
        self.aliases: dict[str, ast.expr] = {
            node.targets[0].id: node.value
            for node in self.tree.body
            if isinstance(node, ast.Assign)
            and isinstance(node.targets[0], ast.Name)
            and node.targets[0].id.startswith("_")
        }
        self.own = {
            target
            for node in self.tree.body
            for target in (
                [node.name]
                if isinstance(node, ast.ClassDef)
                else [
                    each.id for each in getattr(node, "targets", []) if isinstance(each, ast.Name)
                ]
            )
        }

    def function(self, owner: str, name: str) -> ast.AsyncFunctionDef | ast.FunctionDef:
        for node in self.tree.body:
            if isinstance(node, ast.ClassDef) and node.name == owner:
                for each in node.body:
                    if not isinstance(each, ast.AsyncFunctionDef | ast.FunctionDef):
                        continue
                    if each.name == name:
                        return each
        raise SystemExit(f"{self.module}: {owner}.{name} is not to be found")


class _Unfolded(ast.NodeTransformer):
    """Puts what they stand for in the place of names."""

    def __init__(self, aliases: dict[str, ast.expr]) -> None:
        self._aliases = aliases

    def visit_Name(self, node: ast.Name) -> ast.expr:  # the name in `ast`
        return self._aliases.get(node.id, node)


def _import(module: str, alias: ast.alias) -> str:
    renamed = f" as {alias.asname}" if alias.asname else ""
    return f"from {module} import {alias.name}{renamed}"


class Generator:
    """Collects the text of classes, and the imports that their annotations need."""

    def __init__(self) -> None:
        self.imports: dict[str, str] = {}
        self.sources: dict[str, Source] = {}
        #: imports of what is evaluated
        self.run_time: set[str] = {
            "from aioduco.models.names import ManualNames",
            "from aioduco.sync._tasks import awaitables, moves",
        }

    def source(self, module: str) -> Source:
        return self.sources.setdefault(module, Source(module))

    def need(self, node: ast.expr, source: Source, *, default: bool) -> str:
        """The text of an annotation or a default, whose names are imported."""
        if not default:
            node = _Unfolded(source.aliases).visit(node)
        for each in ast.walk(node):
            if not isinstance(each, ast.Name) or each.id in vars(__import__("builtins")):
                continue
            if default:
                value = getattr(sys.modules[source.module], each.id)
                if isinstance(value, int | float | str | None) and each is node:
                    return repr(value)
            wanted = source.imported.get(each.id)
            if wanted is None and each.id in source.own:
                wanted = f"from {source.module} import {each.id}"
            if wanted is None:
                raise SystemExit(f"{source.module}: where does {each.id} come from?")
            if each.id in MOTIONS | TIED.keys():
                continue
            if self.imports.setdefault(each.id, wanted) != wanted:
                raise SystemExit(f"two things are called {each.id}")
        return ast.unparse(node)

    def method(self, owner: type, name: str, target: str) -> list[str]:
        """The lines of one method."""
        source = self.source(owner.__module__)
        node = source.function(owner.__name__, name)
        if node.returns is None:
            raise SystemExit(f"{owner.__name__}.{name} does not say what it returns")
        returns = self.need(node.returns, source, default=False)
        tied = returns in TIED
        motion = isinstance(node, ast.FunctionDef) and not tied
        if motion and returns not in MOTIONS:
            raise SystemExit(f"{owner.__name__}.{name}: no rule for what returns {returns}")
        if node.decorator_list:
            raise SystemExit(f"{owner.__name__}.{name}: no rule for decorators")
        declared, sent = self.arguments(node.args, source)
        returned = "aio_command.MotionCommand" if motion else returns
        lines = ["", "    @moves"] if motion else [""]
        lines += _broken(f"    def {name}", ["self", *declared], f" -> {returned}:")
        lines += _doc(inspect.getdoc(getattr(owner, name)), motion=motion)
        call = f"{target}.{name}"
        if tied:
            self.run_time.add(f"from {TIED[returns]} import {returns}")
            return [
                *lines,
                *_broken(f"        made = {call}", sent, ""),
                f"        return {returns}(self._runner, made)",
            ]
        if motion:
            return lines + _broken(f"        return {call}", sent, "")
        back = "" if returns == "None" else "return "
        line = f"        {back}self._runner.call({call}({', '.join(sent)}))"
        if len(line) <= 100:
            return [*lines, line]
        lines += _broken(f"        work = {call}", sent, "")
        return [*lines, f"        {back}self._runner.call(work)"]

    def property(self, owner: type, name: str) -> list[str]:
        """The lines of one property."""
        source = self.source(owner.__module__)
        node = source.function(owner.__name__, name)
        if node.returns is None:
            raise SystemExit(f"{owner.__name__}.{name} does not say what it is")
        returns = self.need(node.returns, source, default=False)
        lines = ["", "    @property", f"    def {name}(self) -> {returns}:"]
        lines += _doc(inspect.getdoc(getattr(owner, name)), motion=False)
        return [*lines, f"        return self._section.{name}"]

    def arguments(self, args: ast.arguments, source: Source) -> tuple[list[str], list[str]]:
        """What is declared, and what is handed on."""
        declared: list[str] = []
        sent: list[str] = []

        def declare(arg: ast.arg, value: ast.expr | None, before: str = "") -> str:
            if arg.annotation is None:
                raise SystemExit(f"{source.module}: {arg.arg} has no type")
            text = f"{before}{arg.arg}: {self.need(arg.annotation, source, default=False)}"
            if value is None:
                return text
            shown = self.need(value, source, default=True)
            if not isinstance(value, ast.Constant | ast.UnaryOp | ast.Name | ast.Tuple):
                self.at_run_time(value)
            return f"{text} = {shown}"

        positional = args.posonlyargs + args.args
        missing: list[ast.expr | None] = [None] * (len(positional) - len(args.defaults))
        for arg, value in list(zip(positional, missing + list(args.defaults), strict=True))[1:]:
            declared.append(declare(arg, value))
            sent.append(arg.arg)
        if args.vararg is not None:
            declared.append(declare(args.vararg, None, "*"))
            name = args.vararg.arg
            motions = ast.unparse(args.vararg.annotation or ast.Constant(None)) == "MotionCommand"
            sent.append(f"*awaitables({name})" if motions else f"*{name}")
        elif args.kwonlyargs:
            declared.append("*")
        for arg, value in zip(args.kwonlyargs, args.kw_defaults, strict=True):
            declared.append(declare(arg, value))
            sent.append(f"{arg.arg}={arg.arg}")
        if args.kwarg is not None:
            declared.append(declare(args.kwarg, None, "**"))
            sent.append(f"**{args.kwarg.arg}")
        return declared, sent

    def at_run_time(self, value: ast.expr) -> None:
        """A default such as an enum's member is evaluated: its import stands outside."""
        for each in ast.walk(value):
            if isinstance(each, ast.Name):
                self.run_time.add(self.imports[each.id])

    def section(self, shown: str, section: type) -> list[str]:
        """The lines of one section's class."""
        doc = DOCS.get(shown)
        text = inspect.cleandoc(section.__doc__ or "")
        if not issubclass(section, Section):
            text = text.partition("\n\nArgs:")[0]  # of its making
        lines = ["", "", f"class {shown}(_Section):"]
        lines += [f"    {doc}"] if doc else _doc(text, motion=False, indent=4)
        lines += ["", "    __slots__ = ()", f"    _section: Aio{shown}"]
        self.imports[f"Aio{shown}"] = (
            f"from {section.__module__} import {section.__name__} as Aio{shown}"
        )
        seen: set[str] = set()
        for base in section.__mro__:
            if not issubclass(base, (Section, *STREAM_MAKERS)) or base is Section:
                continue
            for name, attribute in vars(base).items():
                if name.startswith("_") or name in seen:
                    continue
                if isinstance(attribute, property):
                    seen.add(name)
                    lines += self.property(base, name)
                    continue
                if not inspect.isfunction(attribute):
                    raise SystemExit(f"{base.__name__}.{name}: no rule for this")
                seen.add(name)
                lines += self.method(base, name, "self._section")
        return lines

    def robot(self, sections: dict[str, str]) -> list[str]:
        """The lines of the class that holds the sections."""
        doc = inspect.getdoc(Robot) or ""
        said = dict(re.findall(r"^    (\w+): (.+)$", doc, re.MULTILINE))
        lines = [
            "",
            "",
            "class Sections(ManualNames):",
            '    """The sections of a robot, and what it does.',
            "",
        ]
        lines += ["    Attributes:"]
        lines += [f"        {name}: {said[name]}" for name in sections]
        lines += ['    """', ""]
        lines += ["    def __init__(self, runner: Runner, robot: aio_robot.Robot) -> None:"]
        lines += ["        self._runner = runner", "        self._robot = robot"]
        lines += [
            f"        self.{name}: {shown} = {shown}(runner, robot.{name})"
            for name, shown in sections.items()
        ]
        for name, attribute in vars(Robot).items():
            if name.startswith("_") or name in BY_HAND or isinstance(attribute, property):
                continue
            if inspect.iscoroutinefunction(attribute):
                lines += self.method(Robot, name, "self._robot")
        return lines

    def generate(self) -> str:
        """The whole text of the module."""
        robot = self.source("aioduco.robot")
        declared = {
            node.target.id: ast.unparse(node.annotation)
            for each in robot.tree.body
            if isinstance(each, ast.ClassDef) and each.name == "Robot"
            for node in each.body
            if isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name)
        }
        lines: list[str] = []
        shown_as: dict[str, str] = {}
        for name, alias in declared.items():
            _, module, _, kind, *_ = robot.imported[alias].split()
            section = getattr(importlib.import_module(module), kind)
            shown_as[name] = kind
            lines += self.section(kind, section)
        lines += self.robot(shown_as)
        text = "\n".join(lines)
        header = HEADER.replace(
            "from aioduco.models.names import ManualNames\n"
            "from aioduco.sync._tasks import awaitables, moves",
            "\n".join(_grouped(self.run_time, indent="")),
            1,
        )
        imports = {*self.imports.values(), *OWN} - self.run_time - {"from typing import Any"}
        return header.format(imports="\n".join(_grouped(imports))) + text + "\n"


def _grouped(imports: set[str], indent: str = "    ") -> list[str]:
    """The lines that import the same, each module once."""
    names: dict[str, list[str]] = {}
    for each in sorted(imports):
        module, name = each.removeprefix("from ").split(" import ")
        names.setdefault(module, []).append(name)
    lines: list[str] = []
    for module, imported in names.items():
        line = f"{indent}from {module} import {', '.join(imported)}"
        if len(line) <= 100:
            lines.append(line)
        else:
            each_on_its_own = [f"{indent}    {one}," for one in imported]
            lines += [f"{indent}from {module} import (", *each_on_its_own, f"{indent})"]
    return lines


def _broken(head: str, arguments: list[str], tail: str) -> list[str]:
    line = f"{head}({', '.join(arguments)}){tail}"
    if len(line) <= 100:
        return [line]
    indent = " " * (len(head) - len(head.lstrip()))
    inner = f"{indent}    {', '.join(arguments)}"
    starred = any(each.startswith("*") and each != "*" for each in arguments)
    if len(inner) <= 100:
        return [f"{head}(", inner, f"{indent}){tail}"]
    if not head.lstrip().startswith("def "):
        # of a call nobody reads but whether it passes everything on
        filled = textwrap.wrap(", ".join(arguments), 96 - len(indent), break_long_words=False)
        return [f"{head}(", *(f"{indent}    {line}" for line in filled), f"{indent}){tail}"]
    comma = "," if not starred or arguments[-1][:1] != "*" else ""
    body = [f"{indent}    {each}," for each in arguments[:-1]]
    return [f"{head}(", *body, f"{indent}    {arguments[-1]}{comma}", f"{indent}){tail}"]


def _doc(doc: str | None, *, motion: bool, indent: int = 8) -> list[str]:
    if not doc:
        raise SystemExit("something has no docstring")
    for pattern, other in WORDS:
        doc = re.sub(pattern, other, doc)
    if motion:
        errors = "Raises:\n    TaskError: it ended otherwise: one of the subclasses.\n"
        doc = doc.replace("Raises:\n", errors, 1)
    raw = "r" if "\\" in doc else ""
    body = f'{raw}"""{doc}\n"""' if "\n" in doc else f'{raw}"""{doc}"""'
    return textwrap.indent(body, " " * indent).split("\n")


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--check", action="store_true", help="fail if the module is out of date")
    options = parser.parse_args()
    text = Generator().generate()
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
        print("sync/_generated.py is out of date: run python idl/generate_sync.py")
        return 1
    print("sync/_generated.py is up to date")
    return 0


if __name__ == "__main__":
    sys.exit(main())
