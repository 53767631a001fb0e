"""`aioduco tap`: show the calls between a client and a controller, as a proxy."""

from __future__ import annotations

import contextlib
import json as json_module
import threading
import time
from pathlib import Path  # noqa: TC003 - typer evaluates the annotations
from typing import TYPE_CHECKING, Annotated, Any

import typer

from aioduco._process.platform import private
from aioduco._wire import idl
from aioduco.cli import extras
from aioduco.cli.addresses import CellFile, Host, Port, robot_at
from aioduco.cli.exit_codes import failing, writing
from aioduco.cli.options import require_writable, wrong_option
from aioduco.cli.output import say
from aioduco.cli.signals import end_signals, handled
from aioduco.models.address import parse_address
from aioduco.models.host_port import host_port
from aioduco.models.numpy_on_use import json_value
from aioduco.models.similar import unknown

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from aioduco.recording.tap import TapNote, TappedCall


def tap(
    host: Host = None,
    port: Port = None,
    cell: CellFile = None,
    listen: str = "127.0.0.1:7004",
    output: Annotated[Path | None, typer.Option("--output", "-o")] = None,
    only: str | None = None,
    json: bool = False,
) -> None:
    """Show each call of any client to any controller, with its answer and time. Ctrl-C ends it.

    The client connects to this command instead of to the controller. When this command ends, its
    connections break, as if the cable had been cut.

    aioduco tap 192.168.1.10 --listen 127.0.0.1:7003 -o calls.jsonl

    Args:
        listen: Address and port for clients. Port 0: a free one.
        output: Also write the calls to this .jsonl or .mcap file.
        only: Show only these functions, with commas between them.
        json: Print a line of JSON for each call.
    """
    from aioduco.errors import DucoError  # noqa: PLC0415 - for this command alone
    from aioduco.recording.tap import Tap, TapNote  # noqa: PLC0415

    require_writable("--output", output)
    address = robot_at(host, port, cell)
    with wrong_option("--listen"):
        where, number = parse_address(listen, any_port=True)
    if number is None:
        raise typer.BadParameter("address:port is needed", param_hint="--listen")
    names = None if only is None else {name.strip() for name in only.split(",")}
    known = idl.names()
    for strange in sorted((names or set()) - known):
        raise typer.BadParameter(f"function {unknown(strange, known)}", param_hint="--only")
    line = _line_maker()
    with (
        failing(DucoError, OSError, RuntimeError),
        Tap(address.host, address.port, listen=(where, number)) as between,
        _file(output, address.host, address.port, line) as write,
        # Not raised, so that files are complete.
        handled(end_signals(), lambda *_: between.end()),
    ):
        said = f"between {host_port(between.host, between.port)} and {address}; Ctrl-C ends it"
        say(said, error=json)
        begin = time.monotonic()
        for item in between:
            if not isinstance(item, TapNote):
                write(item)
                if names is not None and item.function not in names:
                    continue
            if json:
                say(line(item))
            else:
                say(f"{item.at - begin:10.3f} {item}")


@contextlib.contextmanager
def _file(
    path: Path | None, host: str, port: int, line: Callable[[TappedCall], str]
) -> Iterator[Callable[[TappedCall], None]]:
    """A function that writes calls to a file; the file's suffix selects the format."""
    if path is None:
        yield _thrown_away
    elif path.suffix == ".mcap":
        extras.need("record")
        with _recording(path, host, port) as (kept, record):
            say(f"recording to {kept}", error=True)
            yield record
    else:
        ended = False
        with writing(path):
            opened = open(path, "ab", buffering=0, opener=private)  # noqa: SIM115 - closed below
        with opened as file:

            def write(call: TappedCall) -> None:
                nonlocal ended
                if ended:
                    return
                data = f"{line(call)}\n".encode()
                try:
                    while data:  # a disk that is nearly full takes a part
                        data = data[file.write(data) :]
                except OSError as error:
                    # The tap goes on: its end would cut off the client, and so stop the arm.
                    ended = True
                    say(f"{path} ended early: {error.strerror}; the tap goes on", error=True)

            yield write


def _thrown_away(_: TappedCall) -> None:
    """Write nothing."""


@contextlib.contextmanager
def _recording(
    path: Path, host: str, port: int
) -> Iterator[tuple[Path, Callable[[TappedCall], None]]]:
    from aioduco import __version__  # noqa: PLC0415 - for this command alone
    from aioduco.recording.writer import RecordingWriter  # noqa: PLC0415

    writer = RecordingWriter(
        path, lambda: {"written": str(writer.written), "dropped": str(writer.dropped)}
    )
    wall, monotonic = time.time_ns(), time.monotonic_ns()
    about = {
        "library": f"aioduco {__version__}",
        "address": host_port(host, port),
        "started": str(wall),
        "clock_offset": str(wall - monotonic),
    }
    opened = threading.Event()
    writer.begin(about, opened.set, lambda: None)
    opened.wait()
    if writer.error is not None:
        raise OSError(f"{path} cannot be written: {writer.error}")

    def write(call: TappedCall) -> None:
        took = call.duration or 0.0
        lane = f"#{call.connection}"
        arguments = (call.arguments,)
        writer.put(
            "command",
            *(call.at + took, lane, call.function, arguments, call.answer, call.error, took),
        )

    try:
        yield writer.path, write
    finally:
        writer.finish()
        writer.join(10.0)


def _line_maker() -> Callable[[TappedCall | TapNote], str]:
    """A function that makes a line of JSON of an item; `at` in seconds since 1970.

    The difference of the clocks is taken once: a wall clock that is set meanwhile would part the
    calls, or change their order.
    """
    ahead = time.time() - time.monotonic()

    def line(item: TappedCall | TapNote) -> str:
        found: dict[str, Any] = item._asdict()
        found["at"] += ahead
        return json_module.dumps(json_value(found), ensure_ascii=False)

    return line
