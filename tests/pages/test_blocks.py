"""Every block of code of the README files and of the pages runs as it is printed.

Only the address is another one: that of a simulated controller, on an address of loopback of its
own. `blocks.py` says how a page tells what a block needs.
"""

from __future__ import annotations

import ast
import asyncio
import builtins
import contextlib
import inspect
import itertools
import os
import re
import socket
import sys
import sysconfig
import types
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from for_each import for_each
from interpreter import python
from patient import patient_queue

import aioduco
import aioduco.sync
from aioduco.sim import Simulator
from aioduco.sim.console import Console
from aioduco.sim.server.line_server import LineServer
from aioduco.testing import eventually
from pages.blocks import PYTHON, ROOT, SHELL, Block, Page, pages
from pages.session import ENDLESS, INSTALLS, SHOWN, Session, commands

#: addresses that the pages use for an arm, and for a simulated one
ARM, SIMULATED = "192.168.1.10", "127.0.0.1"
PAGES = pages()
#: the block of commands that the quick run takes
QUICK = "guides/from-the-vendor-sdk-3"


class Enough(Exception):
    """What a block's names raise to end a loop that has no end."""


def helpers(namespace: dict[str, Any]) -> dict[str, Any]:
    """What a block's comment may use: an arm that is brought up, and an end of its loop."""
    calls = itertools.count(1)

    def enabled(sim: Any) -> None:
        with aioduco.sync.connect(sim.host) as robot:
            robot.bring_up()
            namespace["here"] = robot.state.get_actual_joints_position()

    def enough(most: int) -> None:
        if next(calls) >= most:
            raise Enough

    return {"enabled": enabled, "enough": enough}


def key(block: Block) -> tuple[str, str]:
    return block.code, block.after


def alone(languages: set[str]) -> list[Block]:
    """Blocks that are run by themselves; those that are printed again are run once."""
    found: dict[tuple[str, str], Block] = {}
    for page in PAGES:
        for block in page.blocks:
            apart = not page.whole or (page.whole == "one program" and block.language in SHELL)
            if apart and block.language in languages and not block.why_not:
                found.setdefault(key(block), block)
    return list(found.values())


def whole(how: str) -> list[Page]:
    """Pages that are one program or one session; those in Chinese have the blocks of the others."""
    return [page for page in PAGES if page.whole == how and not page.path.startswith("docs/zh/")]


def loopback() -> Iterator[str]:
    """Addresses of this computer: each has a port 7003 of its own."""
    process = os.getpid()
    for number in itertools.count(1):
        yield f"127.{number % 250 + 1}.{process // 250 % 250 + 1}.{process % 250 + 1}"


def free_host() -> str:
    """An address on which nobody listens on the port that controllers have."""
    for host in itertools.islice(loopback(), 100):
        with contextlib.suppress(OSError), socket.create_server((host, 7003)):
            return host
    raise AssertionError("no free address")


def names(code: str) -> tuple[set[str], set[str]]:
    """Names that code uses, and those that it binds."""
    used: set[str] = set()
    bound: set[str] = set()
    for node in ast.walk(ast.parse(code)):
        if isinstance(node, ast.Name):
            (used if isinstance(node.ctx, ast.Load) else bound).add(node.id)
    return used, bound


def run(code: str, namespace: dict[str, Any]) -> Any:
    """Run code that may await. What it gives is awaited by the caller."""
    compiled = compile(code, "example", "exec", ast.PyCF_ALLOW_TOP_LEVEL_AWAIT)
    return types.FunctionType(compiled, namespace)()


def needs_robot(code: str) -> bool:
    used, bound = names(code)
    return "robot" in used and "robot" not in bound


def run_with_robot(code: str, namespace: dict[str, Any], host: str) -> None:
    """Run a block; one that awaits has an awaited robot, another one a robot that waits."""
    compiled = compile(code, "example", "exec", ast.PyCF_ALLOW_TOP_LEVEL_AWAIT)
    awaits = bool(compiled.co_flags & inspect.CO_COROUTINE)

    async def awaited() -> None:
        async with contextlib.AsyncExitStack() as stack:
            if needs_robot(code):
                namespace["robot"] = await stack.enter_async_context(aioduco.connect(host))
            with contextlib.suppress(Enough):
                await run(code, namespace)

    if awaits:
        asyncio.run(awaited())
        return
    with contextlib.ExitStack() as stack:
        if needs_robot(code):
            namespace["robot"] = stack.enter_context(aioduco.sync.connect(host))
        with contextlib.suppress(Enough):
            run(code, namespace)


def run_in_pytest(code: str, folder: Path) -> None:
    (folder / "test_page.py").write_text(code, encoding="utf-8")
    done = python("-m", "pytest", "-q", "-p", "no:cacheprovider", "test_page.py", cwd=folder)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.cases(2)
@pytest.mark.parametrize("block", [pytest.param(b, id=b.name) for b in alone(PYTHON)])
def test_a_block_of_python_runs(
    block: Block, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    if re.search(r"^(?:async )?def test_", block.code, re.MULTILINE):
        (tmp_path / "conftest.py").write_text(block.after, encoding="utf-8")
        run_in_pytest(block.code, tmp_path)
        return
    # Dataclasses and pickles look for a module by its name.
    module = types.ModuleType("__main__")
    namespace = vars(module)
    namespace.update(__builtins__=builtins, Enough=Enough, ROOT=ROOT, aioduco=aioduco)
    namespace.update(helpers(namespace))
    monkeypatch.setitem(sys.modules, "__main__", module)
    exec(compile(block.after, "what the block comes after", "exec"), namespace)
    options = {"speed": 5, "host": free_host(), "port": 7003, **namespace.pop("options", {})}
    # Streams keep to the wall's time: their controller has a process of its own.
    made = Simulator.spawn if re.search(r"stream|follow_joint|play\(", block.code) else Simulator
    with patient_queue(), made(**options) as sim:
        namespace.get("prepare", lambda _: None)(sim)
        code = block.code.replace(ARM, sim.host).replace(SIMULATED, sim.host)
        try:
            run_with_robot(code, namespace, sim.host)
        finally:
            left_open = namespace.get("robot")
            if isinstance(left_open, aioduco.sync.Robot):
                left_open.close()
        with aioduco.sync.connect(sim.host) as robot:
            eventually(lambda: not robot.state.robotmoving())


@pytest.mark.slow
@pytest.mark.parametrize("page", [pytest.param(p, id=p.path) for p in whole("one program")])
def test_a_page_that_is_one_program_runs(page: Page, tmp_path: Path) -> None:
    parts = [block.code for block in page.blocks if block.language in PYTHON and not block.why_not]
    assert len(parts) > 1
    file = tmp_path / "program.py"
    file.write_text("\n".join(parts), encoding="utf-8")
    done = python("-W", "error", str(ROOT / "tests" / "patient.py"), str(file), cwd=tmp_path)
    # A busy machine may hold up the event loop of a program.
    said = [line for line in done.stderr.splitlines() if "loop did not get to run" not in line]
    assert (done.returncode, said) == (0, [])


@contextlib.contextmanager
def session(folder: Path) -> Iterator[tuple[Session, str]]:
    """Commands with the environment of this test, and an address for their simulated arm."""
    config = folder / "config"
    (config / "aioduco").mkdir(parents=True)
    host = free_host()
    (config / "aioduco" / "robots.toml").write_text(
        "".join(f'[{name}]\nhost = "{host}"\n' for name in ("left", "right"))
    )
    environment = {
        "PATH": f"{sysconfig.get_path('scripts')}{os.pathsep}{os.environ['PATH']}",
        "XDG_CONFIG_HOME": str(config),
        "AIODUCO_HOST": host,
        "HOME": str(folder),
        "NO_COLOR": "1",
        "MPLBACKEND": "Agg",
    }
    if "AIODUCO_TESTS_BARE" in os.environ:  # see tests/bare: its commands go without it too
        environment |= {name: os.environ[name] for name in ("AIODUCO_TESTS_BARE", "PYTHONPATH")}
    replaced = {ARM: host, SIMULATED: host, ".venv/bin/": ""}
    work = folder / "work"
    work.mkdir()
    with Session(work, environment, replaced) as commands_there:
        yield commands_there, host


@pytest.mark.slow
@pytest.mark.timeout(400)
@pytest.mark.parametrize(
    "block",
    [
        pytest.param(block, id=block.name)
        for block in sorted(alone(SHELL), key=lambda block: block.name != QUICK)
    ],
)
def test_a_block_of_commands_runs(block: Block, tmp_path: Path) -> None:
    with (
        session(tmp_path) as (there, host),
        Simulator(host=host, port=7003, speed=3) as sim,
        contextlib.closing(LineServer(Console(sim).answer, 0)) as lines,
    ):
        there.replace({"aioduco sim-do": f"aioduco sim-do --control-port {lines.port}"})
        for command in commands(block.after, "sh"):
            there.run(command)
        tried = 0
        for printed in commands(block.code, block.language):
            if INSTALLS.match(printed) or SHOWN.search(printed):
                continue
            tried += 1
            command = re.sub(r"--seconds \d+", "--seconds 1", printed)
            if re.search(r"\baioduco sim\b(?!-)", printed):
                # beside the one that is there
                command = printed.partition(" #")[0] + " --port 0 --control-port 0"
            there.run(command)
            if ENDLESS.search(printed):
                there.end_last()
        assert tried, "nothing of it was run: say why by a comment before it"


def test_what_is_not_run_says_why_and_is_little() -> None:
    left = [(block.name, block.why_not) for page in PAGES for block in page.blocks if block.why_not]
    assert [name for name, why in left if len(why.split()) < 4] == []
    # A page in Chinese has the blocks of the English one.
    counted = [page for page in PAGES if "zh" not in page.path]
    single = [
        block.name
        for page in counted
        for block in page.blocks
        if block.why_not and "manual-examples" not in block.name
    ]
    assert len(single) <= sum(len(page.blocks) for page in counted) / 5, single
    # `.ci/tutorial` runs it, from the wheel
    assert [page.path for page in whole("one session")] == ["docs/tutorial.md"]
    # What is run elsewhere is.
    for _, why in left:
        for named in re.findall(r"(?:tests/|\.ci/)[\w/.-]*\w", why):
            assert (ROOT / named).exists(), named


def test_a_new_environment_gets_the_package_from_the_clone() -> None:
    """Of an index pip would take another package of that name, or none."""
    blocks = [block for page in PAGES for block in page.blocks if block.language in SHELL]
    first = [
        line
        for block in blocks
        for line in re.findall(r".*pip install .*", block.code)
        if "-m venv" in block.code or "/lerobot_robot_duco" in line
    ]
    assert len(first) > 5
    assert [line for line in first if not re.search(r" '?\.(/aioduco)?(\[|'| )", line)] == []


def test_no_line_of_a_page_in_chinese_ends_within_a_sentence() -> None:
    """A browser shows a space there."""
    wide = r"[\u3001-\u303f\u4e00-\u9fff\uff01-\uff5e]"
    found = [
        f"{path.name}: {broken}"
        for path in [*(ROOT / "docs").rglob("*zh*/*.md"), *ROOT.glob("README.zh*")]
        for broken in re.findall(
            rf".{{0,8}}{wide}\n *{wide}.{{0,8}}",
            re.sub("```.*?```", "", path.read_text("utf-8"), flags=re.DOTALL),
        )
    ]
    assert found == []


@for_each("page", [p for p in PAGES if p.path.startswith("docs/zh/")])
def test_a_page_in_chinese_has_the_blocks_of_the_english_one(page: Page) -> None:
    name = page.path.removeprefix("docs/zh/")
    (english,) = [p for p in PAGES if p.path in {f"docs/{name}", f"docs/guides/{name}"}]
    assert [key(block) for block in page.blocks] == [key(block) for block in english.blocks]
