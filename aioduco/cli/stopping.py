"""`aioduco stop` without what it does not need: an operator waits for it.

`aioduco.cli.main` comes here first for this command. Whatever is not a plain stop, such as `--help`
or a wrong option, is left to the command line proper, whose command `stop` ends here, too.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import anyio

from aioduco.cli.exit_codes import ended_by_errors
from aioduco.cli.output import print_json, say
from aioduco.cli.robots_file import RobotAddress, WrongAddress, find
from aioduco.supervision.operator_stop import stop_arm

if TYPE_CHECKING:
    from collections.abc import Sequence


class PlainStop(NamedTuple):
    """A stop that was asked for.

    Attributes:
        address: the robot.
        json: whether the states are printed as JSON.
    """

    address: RobotAddress
    json: bool


def plain_stop(words: Sequence[str]) -> PlainStop | None:
    """Understand the words after `aioduco stop`; None if they are anything but a plain stop."""
    host: str | None = None
    port: int | None = None
    json = False
    rest = iter(words)
    for word in rest:
        name, equals, value = word.partition("=")
        if word == "--json":
            json = True
        elif name == "--port":
            number = value if equals else next(rest, "")
            if not (number.isascii() and number.isdigit() and 1 <= int(number) <= 65535):
                return None
            port = int(number)
        elif name == "--host" and host is None:
            host = value if equals else next(rest, "")
            if not host or host.startswith("-"):
                return None
        elif word.startswith("-") or host is not None:
            return None
        else:
            host = word
    try:
        return PlainStop(find(host, port), json)
    except WrongAddress:
        return None


def stop_at(address: RobotAddress, *, as_json: bool) -> None:
    """Stop the arm, wait until it stands, and print the states after that.

    Errors and signals end the command.
    """
    with ended_by_errors(at=address.where):
        states = anyio.run(stop_arm, address.host, address.port)
    if as_json:
        print_json(states)
    else:
        say(f"{address}: stopped: the arm stands; {states}")
