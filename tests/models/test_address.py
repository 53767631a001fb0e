"""The parser of addresses: valid ones and refused ones."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest
from for_each import for_each
from hypothesis import given
from hypothesis import strategies as st

import aioduco
from aioduco import ConnectError, ParameterError
from aioduco.api.force_stream import ForceStream
from aioduco.api.status_port import StatusPort
from aioduco.models.address import host_alone, is_host, parse_address
from aioduco.models.host_port import host_port, is_loopback
from aioduco.recording.tap import Tap

ROOT = Path(__file__).parents[2] / "aioduco"


@for_each(
    "text, host, port",
    [
        ("192.168.1.10", "192.168.1.10", None),
        ("arm.lan:7003", "arm.lan", 7003),
        ("::1", "::1", None),
        ("[::1]", "::1", None),
        ("[::1]:7003", "::1", 7003),
        ("[fe80::1%eth0]:1", "fe80::1%eth0", 1),
        ("fe80::1%eth0", "fe80::1%eth0", None),
        ("host:65535", "host", 65535),
    ],
)
def test_an_address_is_taken_apart(text: str, host: str, port: int | None) -> None:
    assert parse_address(text) == (host, port)


WRONG = [
    *("", " ", "\t", ":", ":7003", "host:", "host:x", "host:0", "host:65536", "host:-1", "host: 1"),
    *(
        "host:７",
        "host:1:2",
        "[::1",
        "::1]",
        "[::1]7003",
        "[::1]:",
        "[::1]:x",
        "[]:7003",
        "[host]:1",
    ),
    *("[host]:1", "a b", "host\n", "http://host:7003", "host/1", "user@host", ":::", "1:2:3"),
    "[::1]:70030",
    *(".", "a..b", "x" * 64, "0" * 9 + ":1" * 9, "host:" + "9" * 5000),
]


@for_each("text", [*WRONG, None, 7003, b"host"])
def test_what_is_no_address_is_refused(text: object) -> None:
    with pytest.raises(ParameterError, match="must be"):
        parse_address(text)


def test_only_what_listens_may_have_port_0() -> None:
    assert parse_address("127.0.0.1:0", any_port=True) == ("127.0.0.1", 0)


@given(st.text(max_size=30))
def test_any_text_is_an_address_or_an_error(text: str) -> None:
    try:
        host, port = parse_address(text)
    except ParameterError:
        return
    assert is_host(host)
    assert port is None or 1 <= port <= 65535
    assert parse_address(f"[{host}]:1" if ":" in host else f"{host}:1") == (host, 1)


@for_each("make", [StatusPort, ForceStream, Tap])
def test_an_empty_host_is_no_host_of_this_computer(
    make: type[StatusPort | ForceStream | Tap],
) -> None:
    with pytest.raises(ParameterError, match="host"):
        make("")


#: by what it does, what it looks like in a source, and the modules that do it
ONCE = {
    # that splits at the last colon, or takes brackets off
    "parser of addresses": (
        r"""\.r?(partition|split)\(":"|strip\("\[\]"\)|prefix\("\["\)""",
        {
            *("models/address.py", "api/section.py", "devices/teleoperation/devices.py"),
            "integrations/panel/page_connection.py",  # the headers of HTTP
            "cli/preflight.py",  # a file and its line
            "sim/twin/recorded.py",  # the class of an error, before its text
        },
    ),
    "writer of addresses": (
        r"\{[\w.\[\]]*(host|\[0\])\}:\{[\w.\[\]]*(port|\[1\])\}",
        {"models/host_port.py"},
    ),
    "reader of TOML": (r"^\s*(import|from)\b.*\btomllib\b", {"models/toml_files.py"}),
}


def test_there_is_no_other_parser_or_writer() -> None:
    sources = {path: path.read_text(encoding="utf-8") for path in ROOT.rglob("*.py")}
    for what, (pattern, own) in ONCE.items():
        code = re.compile(pattern, re.MULTILINE)
        found = {str(path.relative_to(ROOT)) for path, text in sources.items() if code.search(text)}
        assert found <= own, what


def test_an_address_is_shown_as_it_is_written() -> None:
    assert host_port("arm.lan", 7003) == "arm.lan:7003"
    for host, port in (("::1", 7003), ("fe80::1", 1)):
        assert parse_address(host_port(host, port)) == (host, port)
    assert "[::1]:7003" in str(ConnectError("::1", 7003, "refused"))
    assert "[::1]:7003" in repr(aioduco.connect("::1"))


@pytest.mark.parametrize("make", [aioduco.connect, StatusPort, ForceStream, Tap])
@pytest.mark.parametrize(
    ("given", "said"),
    [("127.0.0.1:7004", "'127.0.0.1', 7004"), ("[::1]", "'::1', 7003"), ("[::1]:9", "'::1', 9")],
)
def test_a_port_in_the_host_is_said_to_be_another_argument(
    make: Callable[[str], object], given: str, said: str
) -> None:
    with pytest.raises(ParameterError, match=re.escape(f"as an argument of its own: {said};")):
        make(given)


@for_each(
    "host",
    [
        *("::1", "fe80::1%eth0", "arm.lan", "192.168.1.10", "robot", "robot.", "röbot.cell"),
        *("a_b-c.d", "r" * 63),
    ],
)
def test_a_host_alone_is_taken(host: str) -> None:
    assert host_alone(host) == host == aioduco.connect(host).host


def test_this_computer_is_known_by_its_numbers_and_its_name() -> None:
    assert all(map(is_loopback, ("127.0.0.1", "127.8.0.1", "::1", "localhost")))
    assert not any(map(is_loopback, ("0.0.0.0", "192.168.1.10", "::", "arm.lan", "")))
