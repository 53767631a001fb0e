"""What gateways read: the file, and whatever comes over the network."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

import pytest
from for_each import for_each
from hypothesis import given
from hypothesis import strategies as st

from aioduco.integrations.fleet import FleetClient, FleetGateway
from aioduco.integrations.fleet.gateway_state import GatewayState
from aioduco.integrations.fleet.reports import (
    LONGEST,
    ArmReport,
    ArmStopped,
    GatewayReport,
    MessageRefused,
    StopReport,
    StopRequest,
)
from aioduco.integrations.fleet.settings import ArmSettings, FleetFileError, FleetSettings

ARM = {"name": "left", "host": "127.0.0.1"}
READERS = (StopRequest, StopReport, GatewayReport)

values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
    max_leaves=4,
)
FIELDS = ("name", "link", "error", "robot", "program", "safety", "mode", "joints", "seconds")
arms = st.fixed_dictionaries({}, optional=dict.fromkeys(FIELDS, values))
#: messages that are nearly right: the keys are those that are read
tables = st.fixed_dictionaries(
    {"version": st.just(1) | values},
    optional={
        "arms": values | st.lists(arms),
        **dict.fromkeys(("gateway", "note", "number"), values),
    },
)
payloads = st.binary(max_size=300) | tables.map(lambda table: json.dumps(table).encode())


@given(payloads)
def test_whatever_comes_is_read_or_refused(data: bytes) -> None:
    for reader in READERS:
        try:
            read = reader.decode(data)
        except MessageRefused:
            continue
        assert reader.decode(read.encode()) == read


@given(payloads)
def test_whatever_comes_as_a_stop_stops_nothing_less_than_it_names(data: bytes) -> None:
    state = GatewayState("cell", ["left", "right"])
    for arm in ("left", "right"):
        state.opened(arm)
    order = state.stop(data)
    try:
        named = StopRequest.decode(data).arms
    except MessageRefused:
        named = None
    wanted = {"left", "right"} & (named if named is not None else {"left", "right"})
    assert {*order.arms} == wanted
    report = order.report(dict.fromkeys(order.arms, ""))
    assert StopReport.decode(report.encode()) == report


@for_each(
    "data",
    [
        b"[" * 100_000,
        b" " * (LONGEST + 1),
        b'{"version": 1, "arms": [' + b'"a",' * 2000 + b'"a"]}',
        b'{"version": 2}',
        b'{"version": 1, "arms": ["../*"]}',
        b"\xff\xfe",
    ],
)
def test_what_is_too_long_too_deep_or_of_another_version_is_refused(data: bytes) -> None:
    with pytest.raises(MessageRefused):
        StopRequest.decode(data)


def test_numbers_and_control_characters_are_not_passed_on() -> None:
    def report(**changed: Any) -> bytes:
        sent = GatewayReport("cell", 1, (ArmReport("left", "up"),)).encode()
        table = json.loads(sent)
        table["arms"][0].update(changed)
        return json.dumps(table).encode()

    for changed in ({"joints": [float("nan")]}, {"seconds": 10**400}, {"link": "on"}):
        with pytest.raises(MessageRefused):
            GatewayReport.decode(report(**changed))
    read = GatewayReport.decode(report(error="\x1b[2Jgone"))
    assert read.arms[0].error == "�[2Jgone"  # a terminal would obey it


def test_an_error_with_a_file_name_that_is_no_text_is_passed_on() -> None:
    error = "not read: " + os.fsdecode(b"cell-\xe9.toml")
    sent = GatewayReport("cell", 1, (ArmReport("left", "lost", error),)).encode()
    assert "cell-" in GatewayReport.decode(sent).arms[0].error


def test_a_stop_is_never_taken_for_done_by_another_one() -> None:
    state = GatewayState("cell", ["left", "right", "away"])
    for arm in ("left", "right"):
        state.opened(arm)
    state.closed("away", "no route")
    # Its robot is open: it is told all the same.
    state.connection_lost("right", "it does not answer")
    first, second = state.stop(b""), state.stop(StopRequest(frozenset(["left"])).encode())
    assert first.arms == ("left", "right")
    assert second.arms == ("left",)
    report = first.report({"left": "", "right": ""})
    assert [arm.name for arm in report.arms if not arm.error] == ["left", "right"]
    assert report.arms[0] == ArmStopped("away", "not connected: no route")
    assert second.report({"left": "StopUnconfirmed: it moves"}) == StopReport(
        "cell", (ArmStopped("left", "StopUnconfirmed: it moves"),)
    )


def test_a_report_says_how_old_it_is() -> None:
    state = GatewayState("cell", ["left"])
    assert state.report(5.0).arms[0] == ArmReport("left", "opening")
    state.opened("left")
    state.sampled("left", ArmReport("left", robot="ENABLED"), 5.0)
    state.connection_lost("left", "gone")
    report = state.report(7.5)
    assert report.arms[0] == ArmReport("left", "lost", "gone", robot="ENABLED", seconds=2.5)
    assert report.number == 2


def test_a_report_says_that_the_heartbeat_is_withheld() -> None:
    state = GatewayState("cell", ["left"])
    state.opened("left")
    state.heartbeat_withheld("left", withheld=True)
    state.connection_lost("left", "gone")
    assert state.report(0.0).arms[0].error == "gone"
    state.connection_restored("left")
    arm = state.report(0.0).arms[0]
    assert arm.link == "lost"
    assert "does not supervise the arm" in arm.error
    state.heartbeat_withheld("left", withheld=False)
    assert state.report(0.0).arms[0] == ArmReport("left", "up")


@for_each(
    "table, said",
    [
        ({}, "lacks name"),
        ({"fleet": {"name": "a/b"}}, "letters, digits"),
        ({"fleet": {"name": "f", "lisen": []}}, "takes no lisen; .*: did you mean 'listen'"),
        ({"fleet": {"name": "f", "listen": "tcp/1"}}, "list of texts"),
        ({"fleet": {"name": "f", "connect": [1]}}, "must be a string"),
        ({"fleet": {"name": "f", "rate": 0}}, "0.1 to 100"),
        ({"fleet": {"name": "f", "gateway": 0}}, "name of the gateway is 0"),
        ({"fleet": {"name": "f", "discover": 1}}, "wrong type"),
        ({"fleet": {"name": "f"}, "arm": [{"name": "left"}]}, "lacks host"),
        ({"fleet": {"name": "f"}, "arm": [ARM, ARM]}, "same name"),
        ({"fleet": {"name": "f"}, "arm": [{**ARM, "port": 0}]}, "port"),
        ({"fleet": {"name": "f"}, "arm": [{**ARM, "host": "10.0.0.1:7003"}]}, "alone"),
        ({"fleet": {"name": "f"}, "arm": [{**ARM, "host": " "}]}, "name or an address"),
        ({"fleet": {"name": "f"}, "arm": [{**ARM, "guard": "yes"}]}, "wrong type"),
        ({"fleet": {"name": "f"}, "arm": [{**ARM, "heartbeat": 0.1}]}, "0.2 to 60, or 0 for none"),
        ({"fleet": {"name": "f"}, "arm": [{**ARM, "heartbeat": float("nan")}]}, "0.2 to 60"),
        ({"fleet": {"name": "f"}, "arm": "left"}, "list of tables"),
    ],
)
def test_a_wrong_file_is_refused_with_what_is_wrong(table: dict[str, Any], said: str) -> None:
    with pytest.raises(FleetFileError, match=said):
        FleetSettings.of(table)


def test_files_that_a_file_names_are_found_from_its_folder(tmp_path: Path) -> None:
    file, zenoh = tmp_path / "fleet.toml", tmp_path / "elsewhere" / "zenoh.json5"
    file.write_text(
        f"[fleet]\nname = 'hall'\nkeys = 'keys.toml'\nzenoh = {json.dumps(str(zenoh))}\n"
    )
    settings = FleetSettings.read(file)
    assert (settings.keys, settings.zenoh) == (str(tmp_path / "keys.toml"), str(zenoh))
    file.write_text("[fleet]\nname = 'hall'\n")
    assert FleetSettings.read(file) == FleetSettings("hall")


def test_a_file_says_nothing_of_the_network_it_listens_on_loopback() -> None:
    settings = FleetSettings.of({"fleet": {"name": "plant", "gateway": "cell"}, "arm": [ARM]})
    assert settings.listen == ("tcp/127.0.0.1:7447",)
    assert not settings.discover
    assert settings.arms[0].heartbeat == 1.0


@for_each(
    "given",
    [
        *({"listen": "tcp/127.0.0.1:7447"}, {"connect": "tcp/router:7447"}, {"expect": "left"}),
        *({"listen": None}, {"expect": 5}, {"arms": None}, {"arms": "left"}, {"arms": ["left"]}),
    ],
)
def test_one_text_in_the_place_of_a_list_is_refused(given: dict[str, Any]) -> None:
    with pytest.raises(FleetFileError):
        FleetSettings("hall", **given)


def test_settings_made_of_lists_are_those_of_tuples() -> None:
    arm = ArmSettings("left", "192.0.2.1")
    settings = FleetSettings("hall", expect=["cell"], arms=[arm])  # type: ignore[arg-type]
    assert hash(settings) == hash(FleetSettings("hall", expect=("cell",), arms=(arm,)))


@for_each("make", [FleetClient, FleetGateway])
def test_the_name_of_a_file_is_no_settings(make: Any) -> None:
    with pytest.raises(FleetFileError, match=r"FleetSettings\.read"):
        make("fleet.toml")
