"""Clients by the Apache Thrift compiler: the C++ one is compiled to a program that calls for us."""

from __future__ import annotations

import shutil
import subprocess
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

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
    generate(out, _OPTIONS)
    (out / "calls.inc").write_text("".join(_calls()), "utf-8")
    return _program(out, HERE / "driver.cpp", _UNITS)


def hardware_interface(out: Path) -> Path:
    """Compile the program in the manner of ROS 2 drivers."""
    generate(out, _OPTIONS)
    return _program(
        out, HERE.parent / "programs" / "hardware_interface.cpp", ("RPCRobot", "robot_types")
    )


def _program(out: Path, source: Path, units: tuple[str, ...]) -> Path:
    shutil.copy(source, out)
    with ThreadPoolExecutor() as pool:
        list(pool.map(lambda unit: _compile(out, f"{unit}.cpp"), (source.stem, *units)))
    program = out / source.stem
    objects = [str(path) for path in out.glob("*.o")]
    libraries = ["-lthrift", "-pthread"]
    subprocess.run(["g++", "-o", str(program), *objects, *libraries], check=True, timeout=_PATIENCE)
    return program


def _compile(out: Path, source: str) -> None:
    command = ["g++", "-std=c++17", "-O0", "-g0", "-c", source]
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
