"""Generate the robot for programs that wait: `_generated_objects.py`, `_generated.py` of `sync/`.

And `models/places.py`: which section of the robot has which function of the wire.

    python idl/generate_sync.py            write the modules
    python idl/generate_sync.py --check    compare their whole text with what is committed

Two rules make nearly all of it: a coroutine becomes a call that waits, and a property passes on.
`_generated_objects` has what a robot hands out: feed, tasks, streams, recordings. `_generated` has
the robot itself, its sections (those of streams alone included), `connect`, and the functions that
take a robot. Signatures and docstrings are those of the asyncio interface, the latter in the words
of `WORDS`. What really differs is by hand: the classes of `sync/` that inherit these, or that these
inherit. A shape that has no rule here ends the generator.
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
from dataclasses import dataclass, field, replace
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from aioduco._wire.rpc import Functions, NewerFunctions  # noqa: E402  # of this checkout
from aioduco.api.section import Section  # noqa: E402  # of this checkout
from aioduco.api.streams import StreamMaker  # noqa: E402  # of this checkout
from aioduco.api.streams.servo import OffsetStream  # noqa: E402  # of this checkout
from aioduco.api.streams.track import TrackStream  # noqa: E402  # of this checkout
from aioduco.devices.grippers.gripper import PolledGripper  # noqa: E402  # of this checkout
from aioduco.recording.recorder import Publication, Recording  # noqa: E402  # of this checkout
from aioduco.robot import Robot, connect  # noqa: E402  # of this checkout
from aioduco.sim.twin.twin import Twin  # noqa: E402  # of this checkout
from aioduco.streaming.stream import Stream  # noqa: E402  # of this checkout
from aioduco.supervision.events import Events  # noqa: E402  # of this checkout
from aioduco.supervision.motion_path import MotionPath  # noqa: E402  # of this checkout
from aioduco.supervision.state_feed import StateFeed  # noqa: E402  # of this checkout
from aioduco.supervision.task import Task  # noqa: E402  # of this checkout

PACKAGE = ROOT / "aioduco"
Function = ast.AsyncFunctionDef | ast.FunctionDef


@dataclass(frozen=True)
class Mirror:
    """A class of the asyncio interface that programs that wait get, too.

    Attributes:
        source: the class.
        shown: its name here; one by hand inherits it if it ends in Calls.
        base: its base class here.
        inherited: whether it gets what the bases of `source` have.
        left_out: what is by hand, or for the package alone.
        on_loop: properties that must be read on the event loop.
        direct: functions that any thread may call at once.
    """

    source: type
    shown: str
    base: str = "Blocking"
    inherited: bool = True
    left_out: set[str] = field(default_factory=set)
    on_loop: set[str] = field(default_factory=set)
    direct: set[str] = field(default_factory=set)


OBJECTS = (
    Mirror(StateFeed, "Feed", left_out={"close"}),
    Mirror(Events, "Events", left_out={"close", "tell"}),
    Mirror(Recording, "Recording", "Started", left_out={"start", "stop"}),
    Mirror(Publication, "Publication", "Started", left_out={"start", "stop"}),
    Mirror(Twin, "Twin", "Started", left_out={"start", "stop"}),
    Mirror(PolledGripper, "GripperCalls", "Block", left_out={"start", "aclose", "carrying"}),
    Mirror(
        Task,
        "TaskCalls",
        "Block",
        left_out={"result", "wait", "progress", "time_over", "hold_at_end", "release_clock"},
    ),
    Mirror(MotionPath, "MotionPathCalls", "Block", left_out={"tasks", "add"}),
    Mirror(
        Stream,
        "StreamCalls",
        "Block",
        left_out={"follow", "ticks"},
        on_loop={"state", "reason", "commanded", "taken", "pid"},
        direct={"halt"},
    ),
    Mirror(OffsetStream, "OffsetStreamCalls", "StreamCalls", inherited=False),
    Mirror(TrackStream, "TrackStreamCalls", "StreamCalls", inherited=False),
)
ROBOT = Mirror(
    Robot,
    "Robot",
    "RobotLifecycle",
    left_out={"open", "aclose"},
    direct={"permit", "stop_now"},
)
#: functions that take a robot: the module that is imported when they are called, and their names
FUNCTIONS = {
    "aioduco.recording.playback": ("play", "check_path_on", "check_waypoints_on", "run_waypoints"),
    "aioduco.devices.teleoperation": ("teleoperate",),
}
MOTIONS = {"MotionCommand", "HeldMotion"}
#: class of the asyncio interface -> the class here, and its module
HERE = {
    "Events": ("Events", "_generated_objects"),
    "MotionPath": ("MotionPath", "_tasks"),
    "OffsetStream": ("OffsetStream", "_streams"),
    "Publication": ("Publication", "_generated_objects"),
    "Recording": ("Recording", "_generated_objects"),
    "StateFeed": ("Feed", "_generated_objects"),
    "Stream": ("Stream", "_streams"),
    "Subscription": ("Subscription", "_feeds"),
    "Task": ("Task", "_tasks"),
    "TrackStream": ("TrackStream", "_streams"),
    "Twin": ("Twin", "_generated_objects"),
}

DOCS = {
    "Motion": """Motions of the arm (移动控制, manual 1.3.5).

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
    """,
    "Robot": """A robot arm and its controller. Made by `connect`, used in `with`.

    Any thread may use it. Calls return when they are done; an interrupt (Ctrl-C) in a call that
    waits for a motion stops the arm before it is raised. Leaving the `with` block stops this
    program's motions, waits until the arm stands, and closes the robot. The end of a program that
    did not close the robot does the same.
    """,
}
#: what is said of a class that one by hand inherits
PART = "What `{0}` only passes on to the one for asyncio programs."

#: arguments that `connect` has here besides, and what is said of them
CONNECT = "hold_limit: float | None = 1.0, program_limit: float | None = None"
CONNECT_DOC = """\
    hold_limit: seconds for which the thread that started a motion without an end of its own (a
        jog, a velocity, with `time=None`) may make no call on the robot. After that the motion
        is stopped. None for no limit. A call in progress counts, and so does `Robot.sleep`.
    program_limit: the same for every motion that was started; None for no limit: a motion
        to a target then continues to its target, whatever the program does.
"""
CONNECT_THREAD = """\
The robot runs in an event loop on a thread of its own. So the heartbeat shows the controller
that this thread is alive, not that the program's own thread is. `hold_limit` and
`program_limit` stop motions when the program's own thread makes no calls.

"""

#: what is said otherwise to a program that waits
WORDS = (
    (r"async with (robot\.(?:motion\.path|record|publish|twin|permit))\(", r"with \1("),
    (r"await path\.add\((robot\.[\w.]+)\(", r"path.add(\1.prepare("),
    (r"async with (robot\.(?:servo|speed)\.\w+|robot\.\w+\.stream)\(", r"with \1("),
    (r"async with (robot\.[\w.]+)\(", r"with \1.start("),
    (r"await (robot\.[\w.]+)\((.*)\)\.start\(\)", r"\1.start(\2)"),
    (r"async (with|for) ", r"\1 "),
    (r"`async (with|for)`", r"`\1`"),
    (r"\bawait (?=[\w.]+\()", ""),
    (r"async iterator", "iterator"),
    (r"Yields:\n    The subscription, for `for`\.", "Returns:\n    The subscription, for `with`."),
    (r"The motion, not sent yet\.", "How it ended: finished or blended."),
    (r"the motions before those of `tasks` ended:", "the motions that have ended did so:"),
    # what is a cancellation there
    (r"[Cc]ancelling its await", "An interrupt while it waits"),
    (r"[Cc]ancelling this", "An interrupt"),
    (r"A cancellation (?=brings|stops)", "An interrupt (Ctrl-C) "),
    (r"An interrupt while it waits cancels", "An interrupt while it waits ends"),
    (r"ends by itself is cancelled", "ends by itself is stopped"),
    (r"A motion that is awaited alone", "A motion that is carried out alone"),
    (r"when the caller is cancelled", "when an interrupt comes"),
    (r"goes on to its end even if this is cancelled", "goes on to its end even if interrupted"),
    (r"([Ii]f) this is cancelled", r"\1 this is interrupted"),
    (r"when the await of a motion is cancelled", "when a wait for a motion is interrupted"),
    (r"when its await is cancelled", "when a wait for it is interrupted"),
    (r"an await of it returns only", "a wait for it returns only"),
    (r"The awaits of running motions raise", "Calls that wait for a running motion raise"),
    # what runs on the event loop there
    (r"a stall of the program's event loop", "a stall of the program"),
    (r"the event loop (?=may|hung)", "the robot's thread "),
    (r"heartbeat of this program", "heartbeat of the robot's thread"),
    (r"another task", "another thread"),
    (r"in the tasks that the block starts, too", "for the calls of this thread alone"),
    (
        r"predicate: called with each (?:new )?sample(?:, on the event loop)?\.",
        "predicate: called on the robot's thread with each new sample; it must not call the robot.",
    ),
    (r"feedback: (called|callback) ", r"feedback: \1 on the robot's thread "),
    (r"callback on the robot's thread that gets", "callback on the robot's thread, which gets"),
    (r"on_reading: callback ", "on_reading: callback on the robot's thread "),
    (r"a hook that is called for", "a hook that is called on the robot's threads for"),
)

HEADER = '''"""{title}

Generated by `idl/generate_sync.py` from {sources}; change those, not this.
"""

from __future__ import annotations

{run_time}

if TYPE_CHECKING:
{imports}
'''
PLACES = '''"""Attribute of the robot -> its functions of the wire; "": the robot itself.

Generated by `idl/generate_sync.py` from the robot and its sections; change those, not this.
"""

from __future__ import annotations

from typing import Final

'''
SECTION = '''

class _Section(ManualNames, Blocking):
    """A section of the manual: functions of one robot."""

    __slots__ = ()
'''


class Source:
    """The text of a module, and where the names in it come from."""

    def __init__(self, module: str) -> None:
        self.module = module
        text = inspect.getsource(importlib.import_module(module))
        self.tree = ast.parse(text)
        self.imported: dict[str, str] = {}
        for node in ast.walk(self.tree):
            if isinstance(node, ast.Import | ast.ImportFrom):
                before = f"from {node.module} " if isinstance(node, ast.ImportFrom) else ""
                for alias in node.names:
                    line = f"{before}import {ast.unparse(alias)}"
                    self.imported[alias.asname or alias.name] = line
        #: names of the module's own for types, which it keeps to itself
        self.aliases: dict[str, ast.expr] = {
            node.targets[0].id: node.value
            for node in self.tree.body
            if isinstance(node, ast.Assign)
            and isinstance(node.targets[0], ast.Name)
            and node.targets[0].id.startswith("_")
        }
        self.own = {
            ast.unparse(name)
            for node in self.tree.body
            for name in (
                *getattr(node, "targets", ()),
                *([node.target] if isinstance(node, ast.AnnAssign) else ()),
                *([ast.Name(node.name)] if isinstance(node, ast.ClassDef) else ()),
            )
        }

    def function(self, owner: str, name: str) -> Function:
        """A method of a class, or, with an empty owner, a function of the module."""
        classes = [node for node in self.tree.body if isinstance(node, ast.ClassDef)]
        for each in next((node.body for node in classes if node.name == owner), self.tree.body):
            if isinstance(each, Function) and each.name == name:
                return each
        raise SystemExit(f"{self.module}: {owner}.{name} is not to be found")

    def attribute(self, owner: str, name: str) -> ast.expr:
        """The type of an attribute that the constructor sets."""
        init = self.function(owner, "__init__")
        arguments = (*init.args.args, *init.args.kwonlyargs)
        given = {arg.arg: arg.annotation for arg in arguments if arg.annotation is not None}
        for node in ast.walk(init):
            if isinstance(node, ast.AnnAssign) and ast.unparse(node.target) == f"self.{name}":
                return node.annotation
            if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == f"self.{name}":
                if isinstance(node.value, ast.Name) and node.value.id in given:
                    return given[node.value.id]
                if isinstance(node.value, ast.Constant):
                    return ast.Name(type(node.value.value).__name__)
        raise SystemExit(f"{self.module}: of which type is {owner}.{name}?")


class _Unfolded(ast.NodeTransformer):
    """Puts what they stand for in the place of names."""

    def __init__(self, aliases: dict[str, ast.expr]) -> None:
        self._aliases = aliases

    def visit_Name(self, node: ast.Name) -> ast.expr:  # the name in `ast`
        return self._aliases.get(node.id, node)


class Generator:
    """Collects the text of one module, and the imports that its annotations need."""

    def __init__(self, target: str) -> None:
        self.target = target
        self.imports: dict[str, str] = {"Runner": "from aioduco.sync._runner import Runner"}
        self.sources: dict[str, Source] = {}
        #: imports of what is evaluated
        self.run_time: set[str] = {"from typing import TYPE_CHECKING"}

    def source(self, module: str) -> Source:
        return self.sources.setdefault(module, Source(module))

    # -- types and arguments -----------------------------------------------------------------------

    def need(self, node: ast.expr, source: Source, *, default: bool = False) -> str:
        """The text of an annotation or a default, whose names are imported."""
        if not default:
            here = {name: ast.Name(shown) for name, (shown, _) in HERE.items()}
            node = _Unfolded(source.aliases | here).visit(node)
        for each in ast.walk(node):
            if not isinstance(each, ast.Name) or each.id in vars(__import__("builtins")):
                continue
            if default:
                value = getattr(sys.modules[source.module], each.id)
                if isinstance(value, int | float | str | None) and each is node:
                    return repr(value)
            if not self.is_here(each.id):
                self.need_name(each.id, source)
        return ast.unparse(node)

    def is_here(self, name: str) -> bool:
        """Whether a name is that of a class of `sync`, which is imported then."""
        for shown, module in (*HERE.values(), ("MotionCommand", "_tasks")):
            if name == shown:
                if module != self.target:
                    self.run_time.add(f"from aioduco.sync.{module} import {name}")
                return True
        return name in {"HeldMotion", "Robot"}

    def need_name(self, name: str, source: Source) -> None:
        wanted = source.imported.get(name)
        if wanted is None and name in source.own:
            wanted = f"from {source.module} import {name}"
        if wanted is None:
            raise SystemExit(f"{source.module}: where does {name} come from?")
        if self.imports.setdefault(name, wanted) != wanted:
            raise SystemExit(f"two things are called {name}")

    def arguments(self, args: ast.arguments, source: Source) -> tuple[list[str], list[str]]:
        """What is declared, and what is handed on."""
        declared: list[str] = []
        sent: list[str] = []

        def declare(arg: ast.arg, value: ast.expr | None, before: str = "") -> str:
            if arg.annotation is None:
                raise SystemExit(f"{source.module}: {arg.arg} has no type")
            text = f"{before}{arg.arg}: {self.need(arg.annotation, source)}"
            if value is None:
                return text
            shown = self.need(value, source, default=True)
            if not isinstance(value, ast.Constant | ast.UnaryOp | ast.Name | ast.Tuple):
                self.at_run_time(value)
            return f"{text} = {shown}"

        positional = [arg for arg in args.posonlyargs + args.args if arg.arg != "self"]
        missing: list[ast.expr | None] = [None] * (len(positional) - len(args.defaults))
        for arg, value in zip(positional, missing + list(args.defaults), strict=True):
            declared.append(declare(arg, value))
            sent.append("made_of(robot)" if declared[-1] == "robot: Robot" else arg.arg)
        if args.vararg is not None:
            declared.append(declare(args.vararg, None, "*"))
            name = args.vararg.arg
            motions = ast.unparse(args.vararg.annotation or ast.Constant(None)) == "MotionCommand"
            if motions:
                self.run_time.add("from aioduco.sync._tasks import awaitables")
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

    # -- members -----------------------------------------------------------------------------------

    def method(self, mirror: Mirror, owner: type, name: str) -> list[str]:
        """The lines of one method."""
        source = self.source(owner.__module__)
        node = source.function(owner.__name__, name)
        if node.returns is None:
            raise SystemExit(f"{owner.__name__}.{name} does not say what it returns")
        declared, sent = self.arguments(node.args, source)
        call = f"self._made.{name}"
        doc = inspect.getdoc(getattr(owner, name))
        decorators = [ast.unparse(each) for each in node.decorator_list]
        if decorators == ["contextmanager"]:
            (item,) = re.findall(r"^Iterator\[(.+)\]$", self.need(node.returns, source))
            manager = "AbstractContextManager"
            self.imports[manager] = f"from contextlib import {manager}"
            self.run_time.add("from aioduco.sync._feeds import reading")
            returned = f"{manager}[{item}]"
            work = f"return reading(self._runner, {call}({', '.join(sent)}))"
            return _function(name, ["self", *declared], returned, doc, [f"        {work}"])
        # a call of a robot of `aioduco.sync` is handed over, and counts, at once
        if decorators not in ([], ["asked_at_call"]):
            raise SystemExit(f"{owner.__name__}.{name}: no rule for decorators")
        returns = self.need(node.returns, source)
        if returns in MOTIONS:
            self.imports["aio_command"] = "from aioduco.supervision import command as aio_command"
            self.run_time.add("from aioduco.sync._tasks import moves")
            returned, body = (
                "aio_command.MotionCommand",
                _broken(f"        return {call}", sent, ""),
            )
            return _function(name, ["self", *declared], returned, doc, body, motion=True)
        work = f"{call}({', '.join(sent)})"
        if isinstance(node, ast.AsyncFunctionDef):
            work = f"self._call({work})"
        elif name not in mirror.direct and not issubclass(mirror.source, (Section, StreamMaker)):
            work = f"self._runner.call_sync({f'lambda: {work}' if sent else call})"
        body = self.returned(returns, work)
        if len(body[0]) > 100:
            waits = isinstance(node, ast.AsyncFunctionDef)
            first = _broken(f"        {'work' if waits else 'made'} = {call}", sent, "")
            rest = self.returned(returns, "self._call(work)") if waits else body[1:]
            body = [*first, *rest]
        return _function(name, ["self", *declared], returns, doc, body)

    def returned(self, returns: str, work: str) -> list[str]:
        """The lines that return what some work results in, as an object of `sync` if it is one."""
        inner = returns.removesuffix(" | None").removeprefix("tuple[").removesuffix(", ...]")
        if inner not in {shown for shown, _ in HERE.values()}:
            return [f"        {'' if returns == 'None' else 'return '}{work}"]
        if returns.startswith("tuple["):
            return [f"        return tuple({inner}(self._runner, each) for each in {work})"]
        lines = [f"        made = {work}", f"        return {inner}(self._runner, made)"]
        if returns.endswith("| None"):
            lines[1] = f"        return None if made is None else {inner}(self._runner, made)"
        return lines

    def property(self, mirror: Mirror, owner: type, name: str, doc: str = "") -> list[str]:
        """The lines of one property, or of an attribute that the class documents."""
        source = self.source(owner.__module__)
        if doc:
            annotation: ast.expr | None = source.attribute(owner.__name__, name)
            settable = False
        else:
            annotation = source.function(owner.__name__, name).returns
            settable = getattr(owner, name).fset is not None
            doc = inspect.getdoc(getattr(owner, name)) or ""
        if annotation is None:
            raise SystemExit(f"{owner.__name__}.{name} does not say what it is")
        returns = self.need(annotation, source)
        work = f"self._made.{name}"
        if name in mirror.on_loop:
            work = f"self._runner.call_sync(lambda: {work})"
        lines = ["", "    @property", f"    def {name}(self) -> {returns}:"]
        lines += [*_doc(doc), *self.returned(returns, work)]
        if settable:
            lines += ["", f"    @{name}.setter", f"    def {name}(self, value: {returns}) -> None:"]
            lines += [
                f'        self._runner.call_sync(lambda: setattr(self._made, "{name}", value))'
            ]
        return lines

    def members(self, mirror: Mirror, families: tuple[type, ...]) -> list[str]:
        """The lines of all that a class has, and its bases of these families."""
        lines: list[str] = []
        seen = set(mirror.left_out)
        owners = mirror.source.__mro__ if mirror.inherited else (mirror.source,)
        for owner in owners:
            if not issubclass(owner, families) or owner is Section:
                continue
            for name, doc in _documented(owner).items():
                if name not in seen and not hasattr(owner, name):
                    seen.add(name)
                    lines += self.property(mirror, owner, name, doc)
            for name, attribute in vars(owner).items():
                if name.startswith("_") or name in seen:
                    continue
                seen.add(name)
                if isinstance(attribute, property):
                    lines += self.property(mirror, owner, name)
                elif inspect.isfunction(attribute):
                    lines += self.method(mirror, owner, name)
                else:
                    raise SystemExit(f"{owner.__name__}.{name}: no rule for this")
        return lines

    # -- classes and functions ---------------------------------------------------------------------

    def object(self, mirror: Mirror) -> list[str]:
        """The lines of the class of something that a robot hands out."""
        source, shown = mirror.source, mirror.shown
        part, alias = shown.removesuffix("Calls"), f"Aio{source.__name__}"
        doc = _own_doc(source) if part == shown else PART.format(part)
        if mirror.inherited:
            self.imports[alias] = f"from {source.__module__} import {source.__name__} as {alias}"
        lines = ["", "", f"class {shown}({mirror.base}):", *_doc(doc, indent=4)]
        # type checkers let no attribute have a narrower type than in a base, except for Any
        lines += ["", f"    _made: {alias if mirror.inherited else 'Any'}"]
        families = tuple(each for each in source.__mro__ if each.__module__.startswith("aioduco"))
        return lines + self.members(mirror, families)

    def section(self, shown: str, section: type) -> list[str]:
        """The lines of one section's class."""
        doc = DOCS.get(shown) or _own_doc(section)
        lines = ["", "", f"class {shown}(_Section):", *_doc(inspect.cleandoc(doc), indent=4)]
        lines += ["", "    __slots__ = ()", f"    _made: Aio{shown}"]
        self.imports[f"Aio{shown}"] = (
            f"from {section.__module__} import {section.__name__} as Aio{shown}"
        )
        return lines + self.members(Mirror(section, shown), (Section, StreamMaker))

    def robot(self, sections: dict[str, str]) -> list[str]:
        """The lines of the class that holds the sections."""
        said = _documented(Robot)
        doc = [inspect.cleandoc(DOCS["Robot"]), "", "Attributes:"]
        doc += [f"    {name}: {said[name]}" for name in sections]
        lines = ["", "", "class Robot(RobotLifecycle, ManualNames):"]
        lines += _doc("\n".join(doc), indent=4)
        lines += ["", "    def __init__(self, runner: Runner) -> None:"]
        lines += ["        robot = runner.robot", "        super().__init__(runner, robot)"]
        lines += [
            f"        self.{name}: {shown} = {shown}(runner, robot.{name})"
            for name, shown in sections.items()
        ]
        return lines + self.members(replace(ROBOT, left_out=ROBOT.left_out | {*sections}), (Robot,))

    def connect(self) -> list[str]:
        """The lines of the function that makes a robot."""
        source = self.source("aioduco.robot")
        declared, sent = self.arguments(source.function("", "connect").args, source)
        doc = inspect.getdoc(connect) or ""
        doc = doc.replace("Args:\n", f"{CONNECT_THREAD}Args:\n")
        doc = doc.replace("\nReturns:\n", f"{CONNECT_DOC}\nReturns:\n").replace(
            "aioduco.connect(", "aioduco.sync.connect("
        )
        body = _broken("    robot = aio_robot.connect", sent, "")
        body += ["    return Robot(Runner(robot, hold_limit, program_limit))"]
        declared += CONNECT.split(", ")
        return _function("connect", declared, "Robot", doc, body, indent=0)

    def function(self, module: str, name: str) -> list[str]:
        """The lines of a function that takes a robot."""
        function = getattr(importlib.import_module(module), name)
        source = self.source(function.__module__)
        node = source.function("", name)
        assert node.returns is not None
        declared, sent = self.arguments(node.args, source)
        package, _, short = module.rpartition(".")
        body = [f"    from {package} import {short}  # noqa: PLC0415  # only when it is used"]
        body += ["", *_broken(f"    work = {short}.{name}", sent, "")]
        body += ["    return robot._runner.call(work)"]
        returns = self.need(node.returns, source)
        return _function(name, declared, returns, inspect.getdoc(function), body, indent=0)

    # -- modules -----------------------------------------------------------------------------------

    def objects(self) -> str:
        """The whole text of the module of what a robot hands out."""
        self.run_time.add("from aioduco.sync._blocking import Block, Blocking, Started")
        lines = [line for mirror in OBJECTS for line in self.object(mirror)]
        title = "What a robot hands out to programs that wait: feed, tasks, streams, recordings."
        return self.text(title, "the asyncio interface", lines)

    def everything(self) -> str:
        """The whole text of the module of the robot."""
        sections = self.sections()
        lines = SECTION.rstrip("\n").split("\n")
        for section in sections.values():
            lines += self.section(section.__name__, section)
        shown_as = {name: section.__name__ for name, section in sections.items()}
        lines += [*self.robot(shown_as), *self.connect()]
        for module, names in FUNCTIONS.items():
            for name in names:
                lines += self.function(module, name)
        self.run_time |= {
            "from aioduco import robot as aio_robot",
            "from aioduco.models.names import ManualNames",
            "from aioduco.sync._blocking import Blocking",
            "from aioduco.sync._robot import RobotLifecycle, made_of",
            "from aioduco.sync._runner import Runner",
        }
        title = "The robot for programs that wait, its sections, and what takes a robot."
        return self.text(title, "`api/` and `robot.py`", lines)

    def sections(self) -> dict[str, type]:
        """The sections of the robot, in the order in which it declares them."""
        robot = self.source("aioduco.robot")
        found: dict[str, type] = {}
        for each in robot.tree.body:
            if isinstance(each, ast.ClassDef) and each.name == "Robot":
                for node in each.body:
                    if isinstance(node, ast.AnnAssign):
                        _, module, _, kind, *_ = robot.imported[
                            ast.unparse(node.annotation)
                        ].split()
                        found[ast.unparse(node.target)] = getattr(
                            importlib.import_module(module), kind
                        )
        return found

    def places(self) -> str:
        """The whole text of the module that says where each function of the wire is."""
        lines = ["PLACES: Final = {"]
        for section, kind in {"": Robot, **self.sections()}.items():
            if section == "blocking":
                continue  # the same functions again
            every = (*vars(Functions), *vars(NewerFunctions))
            names = [name for name in every if name[0] != "_" and hasattr(kind, name)]
            filled = textwrap.wrap(" ".join(names), 92)
            if filled:
                lines += [
                    f'    "{section}": """',
                    *(f"        {line}" for line in filled),
                    '    """,',
                ]
        return PLACES + "\n".join([*lines, "}"]) + "\n"

    def text(self, title: str, sources: str, lines: list[str]) -> str:
        imports = {*self.imports.values()} - self.run_time
        if "from typing import Any" in imports:
            imports.remove("from typing import Any")
            self.run_time.add("from typing import Any")
        header = HEADER.format(
            title=title,
            sources=sources,
            run_time="\n".join(_grouped(self.run_time, indent="")),
            imports="\n".join(_grouped(imports)),
        )
        return header + "\n".join(lines) + "\n"


# -- text ------------------------------------------------------------------------------------------


def _grouped(imports: set[str], indent: str = "    ") -> list[str]:
    """The lines that import the same, each module once; the package's own come last."""
    names: dict[str, list[str]] = {}
    for each in sorted(each for each in imports if each.startswith("from ")):
        module, name = each.removeprefix("from ").split(" import ")
        names.setdefault(module, []).append(name)
    lines = [f"{indent}{each}" for each in sorted(imports) if each.startswith("import ")]
    own: list[str] = []
    for module, imported in names.items():
        imported.sort(key=lambda name: (not name.isupper(), name))
        group = own if module.startswith("aioduco") else lines
        line = f"{indent}from {module} import {', '.join(imported)}"
        if len(line) <= 100:
            group.append(line)
        else:
            each_on_its_own = [f"{indent}    {one}," for one in imported]
            group += [f"{indent}from {module} import (", *each_on_its_own, f"{indent})"]
    return [*lines, "", *own]


def _function(
    name: str,
    declared: list[str],
    returns: str,
    doc: str | None,
    body: list[str],
    *,
    motion: bool = False,
    indent: int = 4,
) -> list[str]:
    """The lines of a function: of a method, or, without an indent, of the module."""
    before = ["", "    @moves"] if motion else [""] if indent else ["", ""]
    head = _broken(f"{' ' * indent}def {name}", declared, f" -> {returns}:")
    return [*before, *head, *_doc(doc, motion=motion, indent=indent + 4), *body]


def _broken(head: str, arguments: list[str], tail: str) -> list[str]:
    line = f"{head}({', '.join(arguments)}){tail}"
    if len(line) <= 100:
        return [line]
    indent = " " * (len(head) - len(head.lstrip()))
    inner = f"{indent}    {', '.join(arguments)}"
    starred = any(each.startswith("*") and each != "*" for each in arguments)
    if len(inner) <= 100:
        return [f"{head}(", inner, f"{indent}){tail}"]
    if not head.lstrip().startswith(("def ", "async def ")):
        # of a call nobody reads but whether it passes everything on
        filled = textwrap.wrap(", ".join(arguments), 96 - len(indent), break_long_words=False)
        return [f"{head}(", *(f"{indent}    {line}" for line in filled), f"{indent}){tail}"]
    comma = "," if not starred or arguments[-1][:1] != "*" else ""
    body = [f"{indent}    {each}," for each in arguments[:-1]]
    return [f"{head}(", *body, f"{indent}    {arguments[-1]}{comma}", f"{indent}){tail}"]


def _own_doc(source: type) -> str:
    """A class's docstring, without what is said of its making and of its attributes."""
    return re.split(r"\n\n(?:Args|Attributes):", inspect.cleandoc(source.__doc__ or ""))[0]


def _documented(owner: type) -> dict[str, str]:
    """The attributes that the docstring of a class names, and what it says of them."""
    doc = inspect.cleandoc(owner.__doc__ or "")
    _, _, text = doc.partition("Attributes:\n")
    found = re.findall(r"^    (\w+): (.+(?:\n     +.+)*)", text, re.MULTILINE)
    return {name: re.sub(r"\s+", " ", about) for name, about in found}


def _doc(doc: str | None, *, motion: bool = False, indent: int = 8) -> list[str]:
    if not doc:
        raise SystemExit("something has no docstring")
    for pattern, other in WORDS:
        doc = re.sub(pattern.replace(" ", r"\s+"), other, doc)
    if motion:
        errors = "Raises:\n    TaskError: it ended otherwise: one of the subclasses.\n"
        doc = doc.replace("Raises:\n", errors, 1)
    doc = _filled(doc[0].upper() + doc[1:], 100 - indent)
    raw = "r" if "\\" in doc else ""
    body = f'{raw}"""{doc}\n"""' if "\n" in doc else f'{raw}"""{doc}"""'
    return textwrap.indent(body, " " * indent).split("\n")


def _filled(doc: str, width: int) -> str:
    """The same text, with its long lines broken anew, each with the rest of its paragraph."""
    lines = doc.split("\n")
    if len(lines) == 1 and len(doc) + 6 > width:  # the first sentence alone, then the rest
        first, rest = re.split(r"[.;] ", doc, maxsplit=1)
        lines = [f"{first}.", "", rest[0].upper() + rest[1:]]
    done: list[str] = []
    while lines:
        line = lines.pop(0)
        if len(line) <= width:
            done.append(line)
            continue
        first = " " * (len(line) - len(line.lstrip()))
        rest = first + ("    " if re.match(r" *\w+: ", line) else "")
        while lines and re.match(rest + r"\S", lines[0]):
            line += f" {lines.pop(0).strip()}"
        done += textwrap.wrap(
            line.strip(),
            width,
            initial_indent=first,
            subsequent_indent=rest,
            break_on_hyphens=False,
        )
    return "\n".join(done)


def texts() -> dict[str, str]:
    """What is generated, by its file in the package."""
    return {
        "sync/_generated_objects.py": Generator("_generated_objects").objects(),
        "sync/_generated.py": Generator("_generated").everything(),
        "models/places.py": Generator("places").places(),
    }


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--check", action="store_true", help="fail if a module is out of date")
    options = parser.parse_args()
    modules = {PACKAGE / name: text for name, text in texts().items()}
    if not options.check:
        for target, text in modules.items():
            target.write_text(text, encoding="utf-8")
        return 0
    diff: list[str] = []
    for target, text in modules.items():
        committed = target.read_text(encoding="utf-8") if target.exists() else ""
        diff += difflib.unified_diff(
            committed.splitlines(), text.splitlines(), str(target), "generated", lineterm=""
        )
    if diff:
        print("\n".join(diff[:80]))
        print("a generated module is out of date: run python idl/generate_sync.py")
        return 1
    print("the generated modules are up to date")
    return 0


if __name__ == "__main__":
    sys.exit(main())
