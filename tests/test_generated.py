"""The generated wire is up to date, and the IDL agrees with the facts."""

from __future__ import annotations

import ast
import dataclasses
import importlib
import inspect
import json
import sys
from pathlib import Path
from typing import Any, assert_type

import pytest
from for_each import for_each
from thriftpy2.thrift import TType

from aioduco._wire import idl, rpc

ROOT = Path(__file__).parents[1]

#: functions and structs with field ids and types; its note says where they come from
FACTS = json.loads((Path(__file__).parent / "data" / "wire.json").read_text(encoding="utf-8"))

NAMES = {
    TType.BOOL: "bool",
    TType.BYTE: "i8",
    TType.I16: "i16",
    TType.I32: "i32",
    TType.I64: "i64",
    TType.DOUBLE: "double",
    TType.STRING: "string",
}

PYTHON = {"bool": "bool", "double": "float", "string": "str"} | dict.fromkeys(
    ("i8", "i16", "i32", "i64"), "int"
)


def wire_type(kind: int, shape: Any) -> str:
    """A type as the facts write it, from thriftpy2's spec."""
    if kind == TType.LIST:
        return f"list<{part_type(shape)}>"
    if kind == TType.MAP:
        return f"map<{part_type(shape[0])},{part_type(shape[1])}>"
    if kind == TType.STRUCT:
        return str(shape.__name__)
    return NAMES[kind]


def part_type(part: Any) -> str:
    return wire_type(*part) if isinstance(part, tuple) else wire_type(part, None)


def fields(spec: dict[int, Any]) -> list[list[Any]]:
    """Ids, types and names, as the facts write them."""
    return [
        [fid, wire_type(entry[0], entry[2] if len(entry) > 3 else None), entry[1]]
        for fid, entry in spec.items()
    ]


def python_type(wire: str, container: str = "list") -> str:
    """The annotation for a type of the wire."""
    if wire.startswith("list<"):
        return f"{container}[{python_type(wire[5:-1], container)}]"
    if wire.startswith("map<"):
        key, value = wire[4:-1].split(",")
        return f"dict[{python_type(key, container)}, {python_type(value, container)}]"
    return PYTHON.get(wire, wire)


def test_the_facts_name_their_source_and_are_complete() -> None:
    assert "vendor client" in FACTS["note"]
    assert len(FACTS["methods"]) == 226
    assert len(FACTS["structs"]) == 10


@pytest.mark.cases(1)
@pytest.mark.parametrize(
    ("script", "target", "right", "wrong"),
    [
        ("generate", "_wire/rpc.py", '_call("stop", (block,))', '_call("pause", (block,))'),
        ("generate_blocking", "api/blocking.py", "r=r", "r=0.0"),
        ("generate_compat", "compat/_generated.py", "kp: float = 200.0", "kp: float = 201.0"),
    ],
)
def test_a_generated_module_is_up_to_date_and_the_check_can_fail(
    script: str,
    target: str,
    right: str,
    wrong: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.syspath_prepend(str(ROOT / "idl"))
    monkeypatch.setattr(sys, "argv", [script, "--check"])
    generator = importlib.import_module(script)
    assert generator.main() == 0, capsys.readouterr().out
    changed = (ROOT / "aioduco" / target).read_text("utf-8").replace(right, wrong)
    (tmp_path / "changed.py").write_text(changed, "utf-8")
    monkeypatch.setattr(generator, "TARGET", tmp_path / "changed.py")
    assert generator.main() == 1
    assert wrong in capsys.readouterr().out


def test_functions_are_those_of_the_facts() -> None:
    assert set(idl.functions()) == set(FACTS["methods"])


@for_each("name", sorted(FACTS["methods"]))
def test_each_function_is_as_the_facts_say(name: str) -> None:
    function = idl.functions()[name]
    facts = FACTS["methods"][name]
    assert fields(function.args.thrift_spec) == facts["args"]
    assert function.parameters == tuple(arg[2] for arg in facts["args"])
    assert function.void is (facts["returns"] == "void")
    if not function.void:
        (result,) = fields(function.result.thrift_spec)
        assert result == [0, facts["returns"], "success"]


@for_each("name", sorted(FACTS["structs"]))
def test_each_struct_is_as_the_facts_say(name: str) -> None:
    idl.functions()
    struct = getattr(rpc, name)
    assert fields(struct.thrift_spec) == FACTS["structs"][name]
    assert [field.name for field in dataclasses.fields(struct)] == [
        field[2] for field in FACTS["structs"][name]
    ]
    # a field that is left out has its zero value
    made = struct()
    for _, kind, field in FACTS["structs"][name]:
        value = getattr(made, field)
        assert not value or dataclasses.is_dataclass(value), (field, kind)


@for_each("name", sorted(FACTS["methods"]))
def test_each_method_has_the_types_of_the_wire(name: str) -> None:
    facts = FACTS["methods"][name]
    method = getattr(rpc.Functions, name)
    annotations = {
        parameter.name: parameter.annotation
        for parameter in inspect.signature(method).parameters.values()
        if parameter.name != "self"
    }
    assert annotations == {arg[2]: python_type(arg[1], "Sequence") for arg in facts["args"]}
    returns = "None" if facts["returns"] == "void" else python_type(facts["returns"])
    assert inspect.signature(method).return_annotation == returns


@for_each("name", sorted(FACTS["methods"]))
def test_each_method_calls_its_own_function_with_its_arguments_in_order(name: str) -> None:
    seen: list[tuple[str, tuple[Any, ...]]] = []

    def call(function: str, args: tuple[Any, ...]) -> Any:
        seen.append((function, args))
        return "an answer"

    async def awaited(function: str, args: tuple[Any, ...]) -> Any:
        return call(function, args)

    args = tuple(f"argument {number}" for number in range(len(FACTS["methods"][name]["args"])))
    assert getattr(rpc.RpcClient(call), name)(*args) == "an answer"
    coroutine = getattr(rpc.AsyncRpc(awaited), name)(*args)
    with pytest.raises(StopIteration, match="an answer"):
        coroutine.send(None)
    value = getattr(rpc.calls, name)(*args)
    assert (value.name, value.args) == (name, args)
    assert seen == [(name, args)] * 2
    with pytest.raises(StopIteration, match="an answer"):
        rpc.AsyncRpc(awaited).send(value).send(None)
    assert seen == [(name, args)] * 3


@for_each("face", [rpc.Functions, rpc.AsyncRpc, rpc.WireCalls])
def test_every_function_of_the_wire_can_be_called(face: type) -> None:
    names = {name for name in dir(face) if not name.startswith("_")}
    assert names - {"send"} == (idl.functions().keys() if face is rpc.Functions else idl.names())


async def what_a_type_checker_says(waiting: rpc.RpcClient, awaited: rpc.AsyncRpc) -> None:
    """Never run. `mypy` checks it: to it, an ignored error that is none is an error, too."""
    joints, op = [0.0] * 6, rpc.Op()
    assert_type(waiting.stop(True), int)
    assert_type(waiting.get_files_list(path="/"), dict[str, int])
    assert_type(await awaited.stop(block=True), int)
    assert_type(await awaited.get_files_list("/"), dict[str, int])
    assert_type(await awaited.getRobotStatus(), rpc.RobotStatus)
    assert_type(await awaited.log_info("on"), None)
    await awaited.movej2(joints, 1.0, 1.0, 0.0, True, op=op, def_acc=False)
    await awaited.movej2(joints, 1.0, 1.0, 0.0, True, op)  # type: ignore[call-arg]
    await awaited.stop("now")  # type: ignore[arg-type]
    await awaited.stop(blocks=True)  # type: ignore[call-arg]
    await awaited.stops(True)  # type: ignore[attr-defined]
    assert_type(rpc.calls.stop(True), rpc.WireCall[int])
    assert_type(await awaited.send(rpc.calls.get_files_list("/")), dict[str, int])
    rpc.calls.movej2(joints, 1.0, 1.0, 0.0, True, op)  # type: ignore[call-arg]
    rpc.calls.stop("now")  # type: ignore[arg-type]
    rpc.calls.stops(True)  # type: ignore[attr-defined]
    waiting.movej2(joints, 1.0, 1.0, 0.0, True, op)  # type: ignore[call-arg]
    waiting.stop("now")  # type: ignore[arg-type]
    waiting.stop(blocks=True)  # type: ignore[call-arg]
    waiting.stops(True)  # type: ignore[attr-defined]


def test_the_generated_module_knows_nothing_of_thrift() -> None:
    tree = ast.parse((ROOT / "aioduco/_wire/rpc.py").read_text(encoding="utf-8"))
    modules = {
        node.module if isinstance(node, ast.ImportFrom) else node.names[0].name
        for node in ast.walk(tree)
        if isinstance(node, ast.Import | ast.ImportFrom)
    }
    assert modules == {"__future__", "abc", "collections.abc", "dataclasses", "typing"}
