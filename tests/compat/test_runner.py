"""`python -m aioduco.compat`: unchanged programs, and where their imports lead."""

from __future__ import annotations

from pathlib import Path

import pytest
from interpreter import python

from aioduco.compat._runner import VendorModules
from aioduco.sim import Simulator

#: a program of the vendor's users; {lib} is where its imports put Thrift's library
PROGRAM = """
import os, sys, threading
sys.path.append("gen_py")
sys.path.append("lib")
from DucoCobot import DucoCobot
from gen_py.robot.ttypes import StateRobot, StateProgram, OperationMode, TaskState, Op, PointOp
from {lib} import Thrift
from {lib}.transport import TSocket, TTransport
from {lib}.protocol import TBinaryProtocol
from gen_py.robot import RPCRobot
from vendor.DucoCobot import DucoCobot as Same
from vendor.gen_py.robot.ttypes import TaskState as SameState

assert Same is DucoCobot and SameState.ST_Finished == 4 == TaskState.ST_Finished
assert TaskState._VALUES_TO_NAMES[5] == "ST_Interrupt" and StateRobot.SR_Enable == 6
ip, port = sys.argv[1], int(sys.argv[2])
beats = DucoCobot(ip, port)
robot = DucoCobot(ip, port)
print("open", robot.open(), beats.open())
print("power", robot.power_on(True), robot.enable(True))
op = Op(0, 1, False, 0, 0, "", 0, 1, False, 0, 0, "", 0, 1, False, 0, 0, "")
print("move", robot.movej2([0.1, 0, 1.5, 0, 1.5, 0], 2, 4, 0, True, op=op))
beats.rpc_heartbeat()
beats.close()
robot.close()
try:
    robot.get_tcp_pose()
except Thrift.TException as tx:
    print("lost", type(tx).__name__, tx.message)
    print(isinstance(tx, TTransport.TTransportException), tx.type == 1)
print(os.path.basename(__file__), sys.argv[0] == __file__, __name__)
"""


#: the runner where Thrift's library is not installed
WITHOUT_THRIFT = """
import importlib.util
import sys
find = importlib.util.find_spec
importlib.util.find_spec = lambda name: None if name == "thrift" else find(name)
from aioduco.compat.__main__ import main
main(sys.argv[1:])
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("lib", "runner"),
    [
        ("thrift", ["-m", "aioduco.compat"]),
        ("lib.thrift", ["-m", "aioduco.compat"]),
        ("thrift", ["-c", WITHOUT_THRIFT]),
    ],
    ids=["installed", "the vendor's copy", "not installed"],
)
def test_a_program_for_the_vendors_class_runs_unchanged(
    lib: str, runner: list[str], tmp_path: Path
) -> None:
    program = tmp_path / "program.py"
    program.write_text(PROGRAM.format(lib=lib), encoding="utf-8")
    (tmp_path / "lib").mkdir()
    (tmp_path / "vendor").mkdir()
    with Simulator(speed=10.0) as sim:
        done = python(*runner, str(program), sim.host, str(sim.port), cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert lines[:3] == ["open 0 0", "power 4 4", "move 4"]
    assert lines[3].startswith("lost ConnectionLost get_tcp_pose was not sent")
    assert lines[4:] == ["True True", "program.py True __main__"]


def test_thrifts_library_is_replaced_only_where_it_is_missing() -> None:
    with_it, without = VendorModules(thrift=False), VendorModules(thrift=True)
    assert with_it.find_spec("thrift.Thrift") is None
    assert with_it.find_spec("vendor.lib.thrift.Thrift") is not None
    for name in ("thrift", "thrift.Thrift", "vendor.lib.thrift.transport.TTransport"):
        assert without.find_spec(name) is not None
    for name in ("thriftpy2.thrift", "other.thrift", "thrift.server", "my.ducocobot", "gen"):
        assert without.find_spec(name) is None


#: how programs load a module whose name they are told
LOAD = "import importlib, sys\ndef load(name):\n    return importlib.import_module(name).DucoCobot"


#: ways to name a package of which there is nothing, `{}`
NAMED = [
    "from {}.DucoCobot import DucoCobot",
    "from {}.DucoCobot import *",
    "from {} import DucoCobot as m; DucoCobot = m.DucoCobot",
    "import {}.deeper.DucoCobot as m; DucoCobot = m.DucoCobot",
    "from {}.gen_py.robot.ttypes import Op; DucoCobot = Op",
    "from {0}.lib.thrift import Thrift; from {0}.DucoCobot import DucoCobot",
    "import importlib; DucoCobot = importlib.import_module('{}.DucoCobot').DucoCobot",
    "def sdk(name='{}.DucoCobot'):\n    return load(name)\nDucoCobot = sdk()",
    "SDK = {{'module': '{}.DucoCobot'}}\nDucoCobot = load(SDK['module'])",
]


@pytest.mark.slow
def test_packages_without_the_vendors_files(tmp_path: Path) -> None:
    """Each is named in one way alone."""
    lines = [LOAD]
    for number, way in enumerate(NAMED):
        lines += [way.format(f"vendor_{number}"), "print(DucoCobot.__module__)", "del DucoCobot"]
    lines += ["try:\n    import vendor_x\nexcept ImportError:\n    print('others are missing')", ""]
    program = tmp_path / "program.py"
    program.write_text("\n".join(lines), encoding="utf-8")
    done = python("-m", "aioduco.compat", str(program))
    wanted = ["aioduco.compat"] * len(NAMED)
    wanted[4] = "aioduco._wire.rpc"
    assert done.stdout.splitlines() == [*wanted, "others are missing"], done.stderr


@pytest.mark.slow
@pytest.mark.parametrize(
    "arguments", [["--sdk-module", "vendor_api.DucoCobot"], ["--sdk-module=vendor_api.DucoCobot"]]
)
def test_packages_that_only_the_arguments_of_a_program_name(
    arguments: list[str], tmp_path: Path
) -> None:
    program = tmp_path / "program.py"
    program.write_text(
        f"{LOAD}\nprint(load(sys.argv[-1].rpartition('=')[2]).__module__)\n", encoding="utf-8"
    )
    done = python("-m", "aioduco.compat", str(program), *arguments)
    assert done.stdout.strip() == "aioduco.compat", done.stderr


@pytest.mark.cases(1)
@pytest.mark.parametrize("name", ["cell.node", "cell.deeper", "cell"])
def test_a_program_that_is_a_module_of_a_package(name: str, tmp_path: Path) -> None:
    """As nodes of ROS are: such a program imports the vendor's class from its own package."""
    own = tmp_path / "cell" / "deeper"
    own.mkdir(parents=True)
    (own.parent / "__init__.py").touch()
    (own / "__init__.py").touch()
    for file, dots in (("node.py", "."), ("__main__.py", "."), ("deeper/__main__.py", "..")):
        (own.parent / file).write_text(
            "import sys\n"
            f"from {dots}DucoCobot import DucoCobot\n"
            f"from {dots}gen_py.robot.ttypes import Op\n"
            "from vendor_api.DucoCobot import DucoCobot as Same\n"
            "print(DucoCobot.__module__, Same is DucoCobot, __name__, sys.argv[1:])\n",
            encoding="utf-8",
        )
    done = python("-m", "aioduco.compat", "-m", name, "-m", "more", cwd=tmp_path)
    assert done.stdout == "aioduco.compat True __main__ ['-m', 'more']\n", done.stderr


@pytest.mark.parametrize("package", ["DucoCobot", "cell.DucoCobot"])
def test_own_modules_in_the_vendors_folder(package: str, tmp_path: Path) -> None:
    """They are imported as they are, wherever that folder is."""
    folder = tmp_path.joinpath(*package.split("."))
    folder.mkdir(parents=True)
    (folder / "DucoCobot.py").write_text("raise ImportError", encoding="utf-8")
    (folder / "points.py").write_text("HOME = 'home'", encoding="utf-8")
    program = tmp_path / "program.py"
    program.write_text(
        f"from {package}.DucoCobot import DucoCobot\n"
        f"from {package}.points import HOME\n"
        "print(DucoCobot.__module__, HOME)\n",
        encoding="utf-8",
    )
    done = python("-m", "aioduco.compat", str(program))
    assert done.stdout == "aioduco.compat home\n", done.stderr


def test_processes_of_the_program_import_it_too(tmp_path: Path) -> None:
    """Those that are not forked, as by spawn, begin with an import of the program."""
    program = tmp_path / "program.py"
    program.write_text(
        "import multiprocessing\n"
        "from DucoCobot import DucoCobot\n"
        "from vendor_api.DucoCobot import DucoCobot as Same\n"
        "def there():\n"
        "    return DucoCobot.__module__, Same is DucoCobot\n"
        "if __name__ == '__main__':\n"
        "    for method in ('spawn', 'forkserver'):\n"
        "        with multiprocessing.get_context(method).Pool(1) as pool:\n"
        "            print(*pool.apply_async(there).get(20.0))\n",
        encoding="utf-8",
    )
    done = python("-m", "aioduco.compat", str(program))
    assert done.stdout == "aioduco.compat True\n" * 2, done.stderr


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", ["nothing", "nothing.here", "there.not", "json.decoder.not", "..here"]
)
def test_a_module_that_is_not_there(name: str, tmp_path: Path) -> None:
    (tmp_path / "there").mkdir()
    (tmp_path / "there/__init__.py").touch()
    done = python("-m", "aioduco.compat", "-m", name, cwd=tmp_path)
    assert done.returncode == 2
    assert f" {name} is no module in " in done.stderr
