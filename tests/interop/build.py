"""Clients by the Apache Thrift compiler: the C++ one is compiled to a program that calls for us."""

from __future__ import annotations

import fcntl
import os
import shutil
import subprocess
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from aioduco._wire import idl

from . import layouts

HERE = Path(__file__).parent
#: services by their names in a call, and the member of the driver's `Robot` that is their client
SERVICES = {
    "RPCRobot": "full",
    "Short": "brief",
    "Older": "older",
    "Oldest": "oldest",
    "First": "first",
}
_OPTIONS = "cpp:no_skeleton,no_ostream_operators,no_default_operators,moveable_types"
#: a busy machine takes many times the twenty seconds of a quiet one [s]
_PATIENCE = 600
_PROGRAMS = (HERE / "driver.cpp", HERE.parent / "programs" / "hardware_interface.cpp")
_UNITS = ("RPCRobot", "Short", "Older", "Oldest", "First", "robot_types", "clients_types")


def generate(out: Path, language: str) -> None:
    """Let the compiler write the clients for a language."""
    (out / "robot.thrift").write_text(idl.path().read_text("utf-8"), "utf-8")
    (out / "clients.thrift").write_text(layouts.text(), "utf-8")
    for name in ("robot.thrift", "clients.thrift"):
        subprocess.run(
            ["thrift", "--gen", language, "-out", str(out), str(out / name)],
            check=True,
            capture_output=True,
            timeout=_PATIENCE,
        )


def driver(out: Path) -> Path:
    """Compile the program of the generated C++ clients."""
    return _program(out, "driver", _UNITS)


def hardware_interface(out: Path) -> Path:
    """Compile the program in the manner of ROS 2 drivers."""
    return _program(out, "hardware_interface", ("RPCRobot", "robot_types"))


def folder(temporary: pytest.TempPathFactory) -> Path:
    """Where the processes of a run compile: what one has made, the others find."""
    base = temporary.getbasetemp()
    out = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / "cpp"
    out.mkdir(exist_ok=True)
    return out


def _made(path: Path, make: Callable[[Path], object]) -> Path:
    """Make a file, unless another process has made it or does so now."""
    with path.with_name(f"{path.name}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not path.exists():
            part = path.with_name(f"{path.name}.part")
            make(part)
            part.rename(path)
    return path


def _program(out: Path, name: str, units: tuple[str, ...]) -> Path:
    _made(out / "calls.inc", lambda part: _write(out, part))
    with ThreadPoolExecutor() as pool:
        objects = list(pool.map(lambda each: _object(out, each), (name, *units)))
    given = [*map(str, objects), "-lthrift", "-pthread"]
    return _made(
        out / name,
        lambda part: subprocess.run(
            ["g++", "-o", str(part), *given], check=True, timeout=_PATIENCE
        ),
    )


def _write(out: Path, calls: Path) -> None:
    generate(out, _OPTIONS)
    for source in _PROGRAMS:
        shutil.copy(source, out)
    calls.write_text("".join(_calls()), "utf-8")


def _object(out: Path, unit: str) -> Path:
    return _made(out / f"{unit}.o", lambda part: _compile(out, f"{unit}.cpp", part))


def _compile(out: Path, source: str, into: Path) -> None:
    command = ["g++", "-std=c++17", "-O0", "-g0", "-c", source, "-o", str(into)]
    done = subprocess.run(
        command, cwd=out, capture_output=True, text=True, timeout=_PATIENCE, check=False
    )
    if done.returncode:
        raise RuntimeError(f"{source} does not compile:\n{done.stderr[:4000]}")


def _calls() -> list[str]:
    """A line of the driver's table for each function of each service."""
    sent = {
        "RPCRobot": {name: list(f.parameters) for name, f in idl.functions().items()},
        **{
            service: {name: [field for _, _, field in fields] for name, fields in functions.items()}
            for service, functions in layouts.layouts().items()
        },
    }
    return [
        _call(service, name, parameters)
        for service, functions in sent.items()
        for name, parameters in functions.items()
    ]


def _call(service: str, name: str, parameters: list[str]) -> str:
    client = SERVICES[service]
    space = "" if service == "RPCRobot" else "clients::"
    args = ", ".join(f"a.{parameter}" for parameter in parameters)
    function = idl.functions()[name]
    if function.void:
        work = f"r; robot.{client}.{name}({args});"
    elif layouts.scalar(name):
        work = f"r; r.success = robot.{client}.{name}({args}); r.__isset.success = true;"
    else:
        into = f"r.success{', ' if args else ''}{args}"
        work = f"r; robot.{client}.{name}({into}); r.__isset.success = true;"
    return (
        f'{{"{service} {name}", [&robot](TProtocol& in, TProtocol& out) {{ '
        f"auto a = read<{space}{service}_{name}_args>(in); (void)a; "
        f"{space}{service}_{name}_result {work} r.write(&out); }}}},\n"
    )
