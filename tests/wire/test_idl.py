"""The IDL as the package reads it."""

from __future__ import annotations

from typing import Any

import thriftpy2

from aioduco._wire import idl, rpc

PLAIN = thriftpy2.load(str(idl.path()), module_name="test_idl_thrift")


def plain(part: Any) -> Any:
    """A spec with the name and the fields of each struct in the place of its class."""
    if isinstance(part, type):
        return part.__name__, plain(vars(part)["thrift_spec"])
    if isinstance(part, dict):
        return [(key, plain(entry)) for key, entry in part.items()]
    return tuple(map(plain, part)) if isinstance(part, tuple) else part


def test_it_has_the_same_functions_in_the_same_order() -> None:
    assert list(idl.functions()) == list(PLAIN.RPCRobot.thrift_services)


def test_arguments_and_results_have_the_same_fields_of_the_same_types() -> None:
    for name, function in idl.functions().items():
        for ours, part in ((function.args, "args"), (function.result, "result")):
            theirs = getattr(PLAIN.RPCRobot, f"{name}_{part}")
            assert plain(ours.thrift_spec) == plain(theirs.thrift_spec), name


def test_structs_have_the_same_fields_of_the_same_types() -> None:
    idl.functions()
    structs = PLAIN.__thrift_meta__["structs"]
    assert len(structs) == 10
    for theirs in structs:
        assert plain(getattr(rpc, theirs.__name__)) == plain(theirs)
