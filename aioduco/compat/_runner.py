"""Replacements of the vendor's modules for an unchanged program; they take precedence.

The vendor distributes a folder: `DucoCobot.py`, `gen_py` from Thrift's compiler, and a copy of
Thrift's library in `lib`. Programs put that folder, or parts of it, into packages of their own. So
a module is identified by the end of its name, in whatever package it is.
"""

from __future__ import annotations

import ast
import importlib.util
import itertools
import multiprocessing
import multiprocessing.spawn
import runpy
import sys
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec, PathFinder
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from aioduco import compat
from aioduco.compat._foreign import ENUMS
from aioduco.errors import Portable

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Sequence
    from types import ModuleType


_STRUCTS: Final = (
    *("EAxisParam", "EAxisSchemeParam", "EAxissInfo", "IOStatus", "MoveJogTaskParam", "Op"),
    *("PointOp", "ReachabilityParam", "RealTimeControlData", "RobotStatus"),
)


class TException(Portable):
    """Base of Thrift's errors, in place of the one in Thrift's library."""

    def __init__(self, message: str | None = None) -> None:
        super().__init__(message)
        self.message = message


class TApplicationException(TException):
    """An error that the controller reports, in place of the one in Thrift's library."""

    def __init__(self, type: int = 0, message: str | None = None) -> None:  # noqa: A002  # Thrift's
        super().__init__(message)
        self.type = type


class TTransportException(TException):
    """A connection that failed, in place of the one in Thrift's library."""

    UNKNOWN = 0
    NOT_OPEN = 1
    ALREADY_OPEN = 2
    TIMED_OUT = 3
    END_OF_FILE = 4

    def __init__(self, type: int = UNKNOWN, message: str | None = None) -> None:  # noqa: A002  # Thrift's
        super().__init__(message)
        self.type = type


def _class_module() -> dict[str, Any]:
    return {"DucoCobot": compat.DucoCobot, **_types_module()}


def _types_module() -> dict[str, Any]:
    return {**ENUMS, **{name: getattr(compat, name) for name in _STRUCTS}}


def _nothing() -> dict[str, Any]:
    return {}


#: contents of the vendor's modules, by the end of their names
_VENDOR: Final[dict[str, Callable[[], dict[str, Any]]]] = {
    "DucoCobot": _class_module,
    "gen_py": _nothing,
    "gen_py.robot": _nothing,
    "gen_py.robot.ttypes": _types_module,
    "gen_py.robot.constants": _nothing,
    "gen_py.robot.RPCRobot": _nothing,
}
#: the same for Thrift's library: the errors, which programs import; the other modules are empty
_THRIFT: Final[dict[str, Callable[[], dict[str, Any]]]] = {
    "thrift": _nothing,
    "thrift.Thrift": lambda: {
        "TException": TException,
        "TApplicationException": TApplicationException,
    },
    "thrift.transport": _nothing,
    "thrift.transport.TTransport": lambda: {"TTransportException": TTransportException},
    "thrift.transport.TSocket": _nothing,
    "thrift.protocol": _nothing,
    "thrift.protocol.TBinaryProtocol": _nothing,
}
_MODULES: Final = {**_VENDOR, **_THRIFT}


class VendorModules(MetaPathFinder, Loader):
    """Finds the vendor's modules, and the copy of Thrift's library in the vendor's folder.

    Args:
        thrift: whether it also finds Thrift's library by its own name, since it is not installed.
    """

    def __init__(self, thrift: bool) -> None:
        self._thrift = thrift

    def has(self, fullname: str) -> bool:
        """Whether it finds a module."""
        return self._vendor_name(fullname) is not None

    def find_spec(
        self,
        fullname: str,
        path: Sequence[str] | None = None,
        target: ModuleType | None = None,  # noqa: ARG002  # the import system hands it over
    ) -> ModuleSpec | None:
        """Return the spec of the module, if it is one of them.

        Where the vendor's folder exists, further modules in it are found there.
        """
        if self._vendor_name(fullname) is None:
            return None
        spec = ModuleSpec(fullname, self, origin=compat.__name__, is_package=True)
        there = PathFinder.find_spec(fullname, path)
        if there is not None and there.submodule_search_locations is not None:
            spec.submodule_search_locations = list(there.submodule_search_locations)
        return spec

    def exec_module(self, module: ModuleType) -> None:
        """Fill the module."""
        known = self._vendor_name(module.__name__)
        assert known is not None
        vars(module).update(_MODULES[known]())

    def _vendor_name(self, fullname: str) -> str | None:
        parts = fullname.split(".")
        for begin, first in enumerate(parts):
            # other libraries have a module `thrift`, too; the vendor's copy is in `lib`
            ours = self._thrift if begin == 0 else parts[begin - 1] == "lib"
            name = ".".join(parts[begin:])
            if name in _MODULES and (ours or first != "thrift"):
                return name
        return None


class MissingPackages(MetaPathFinder, Loader):
    """Finds packages that a program imports the vendor's modules from, where they do not exist.

    It is asked last, so that a package which exists is imported as it is.

    Args:
        names: the packages.
    """

    def __init__(self, names: frozenset[str]) -> None:
        self._names = names

    def find_spec(
        self,
        fullname: str,
        path: Sequence[str] | None = None,  # noqa: ARG002  # the import system hands it over
        target: ModuleType | None = None,  # noqa: ARG002
    ) -> ModuleSpec | None:
        """Return the spec of an empty package, if it is one of them."""
        if fullname not in self._names:
            return None
        return ModuleSpec(fullname, self, origin=compat.__name__, is_package=True)

    def exec_module(self, module: ModuleType) -> None:
        """Leave the package empty."""


def packages_around(
    sources: Iterable[str], arguments: Iterable[str], vendor: VendorModules
) -> frozenset[str]:
    """Return the packages from which programs import the vendor's modules.

    Args:
        sources: the texts of the programs; one that cannot be parsed is passed over.
        arguments: the arguments of the program, which may name a module, too.
        vendor: tells the vendor's modules.
    """
    found: set[str] = set()
    for name in itertools.chain(_named(sources), (each.rpartition("=")[2] for each in arguments)):
        parts = name.split(".")
        if not all(map(str.isidentifier, parts)):
            continue  # a text that names no module
        prefixes = [".".join(parts[: end + 1]) for end in range(len(parts))]
        first = next((at for at, each in enumerate(prefixes) if vendor.has(each)), 0)
        found.update(prefixes[:first])
    return frozenset(found)


def _named(sources: Iterable[str]) -> Iterator[str]:
    """The modules that programs import, and their texts, which may name one for `import_module`."""
    for source in sources:
        try:
            tree = ast.parse(source)
        except (SyntaxError, ValueError):
            continue
        for node in ast.walk(tree):
            match node:
                case ast.Import(names=names):
                    yield from (each.name for each in names)
                case ast.ImportFrom(module=str(module), names=names, level=0):
                    yield from (module, *(f"{module}.{each.name}" for each in names))
                case ast.Constant(value=str(text)):
                    yield text


def _sources(file: Path) -> Iterator[str]:
    """The texts of a program and of the modules beside it."""
    for path in (file, *file.parent.glob("*.py"), *file.parent.glob("*/*.py")):
        try:
            yield path.read_text(encoding="utf-8-sig")
        except (OSError, UnicodeDecodeError):
            continue


def module_exists(name: str) -> bool:
    """Return whether a module is in the working directory, or is installed; imports nothing."""
    first, *inner = name.split(".")
    try:
        spec = PathFinder.find_spec(first, [str(Path.cwd())]) or importlib.util.find_spec(first)
    except ValueError:  # an empty name
        return False
    for part in inner:
        if spec is None or spec.submodule_search_locations is None:
            return False
        spec = PathFinder.find_spec(f"{spec.name}.{part}", spec.submodule_search_locations)
    return spec is not None


def place(thrift: bool, packages: frozenset[str]) -> None:
    """Let this process, and those that multiprocessing starts from it, find the vendor's modules.

    Args:
        thrift: as for `VendorModules`.
        packages: as for `MissingPackages`.
    """
    sys.meta_path.insert(0, VendorModules(thrift))
    sys.meta_path.append(MissingPackages(packages))
    prepared = multiprocessing.spawn.get_preparation_data

    def with_modules(name: str) -> dict[str, Any]:
        return {"vendor": _Placed(thrift, packages), **prepared(name)}

    multiprocessing.spawn.get_preparation_data = with_modules
    # the server of `forkserver` gets no such data, and could not import the program
    multiprocessing.set_forkserver_preload([])


class _Placed:
    """Unpickled in a new process, before that imports the program, it places the modules there."""

    def __init__(self, *given: Any) -> None:
        self._given = given

    def __reduce__(self) -> tuple[Any, ...]:
        return place, self._given


def run(program: str, arguments: Sequence[str], *, module: bool = False) -> None:
    """Run a program as Python would, with the vendor's modules in place of its own.

    Args:
        program: the program's file, or the name of its module.
        arguments: the program's arguments, put into `sys.argv` behind its name.
        module: whether it is the name of a module, which is looked for in the working directory
            first.
    """
    file = Path.cwd().joinpath(*program.split(".")) if module else Path(program).resolve()
    installed = importlib.util.find_spec("thrift") is not None
    vendor = VendorModules(thrift=not installed)
    place(not installed, packages_around(_sources(file), arguments, vendor))
    sys.argv = [program, *arguments]
    sys.path.insert(0, str(Path.cwd() if module else file.parent))
    if module:
        runpy.run_module(program, run_name="__main__", alter_sys=True)
    else:
        runpy.run_path(program, run_name="__main__")
