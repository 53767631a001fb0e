"""Two network namespaces joined by a cable: the controller's and the program's."""

from __future__ import annotations

import functools
import itertools
import os
import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

#: address of the controller; each network is alone in its namespaces, so all have the same
CONTROLLER = "10.213.0.1"
_PROGRAM = "10.213.0.2"
#: name of the interface at either end
_CABLE = "cable"

_numbers = itertools.count()

#: the controller's packet filter, by the kind of outage
_FILTERS = {
    "dropped": f"""*filter
-A INPUT -i {_CABLE} -j DROP
-A OUTPUT -o {_CABLE} -j DROP
COMMIT
""",
    # Both sides are told, the controller's too. The resets that this makes must pass.
    "reset": f"""*filter
-A INPUT -i {_CABLE} -p tcp -j REJECT --reject-with tcp-reset
-A OUTPUT -o {_CABLE} -p tcp --tcp-flags RST RST -j ACCEPT
-A OUTPUT -o {_CABLE} -p tcp -j REJECT --reject-with tcp-reset
COMMIT
""",
}
_NO_FILTER = "*filter\nCOMMIT\n"

#: kinds of outage that the network makes
KINDS = (*_FILTERS, "down")


class NotPermitted(Exception):
    """This machine or user cannot make network namespaces; says why."""


def _run(*command: str, given: str = "") -> str:
    try:
        done = subprocess.run(command, input=given, capture_output=True, text=True, check=False)
    except OSError as exc:
        raise NotPermitted(f"{command[0]}: {exc.strerror}") from exc
    if done.returncode:
        raise NotPermitted(f"{' '.join(command)}: {done.stderr.strip() or done.returncode}")
    return done.stdout


@dataclass(frozen=True, slots=True)
class Network:
    """A cable with a namespace at each end."""

    controller: str
    program: str

    def interrupt(self, kind: str) -> None:
        """Begin an outage: one of `KINDS`."""
        if kind == "down":
            # The program's end loses its carrier, as that of a pulled cable does.
            _run("ip", "-n", self.controller, "link", "set", _CABLE, "down")
        else:
            self._filter(_FILTERS[kind])

    def restore(self, kind: str) -> None:
        """End it."""
        if kind == "down":
            _run("ip", "-n", self.controller, "link", "set", _CABLE, "up")
        else:
            self._filter(_NO_FILTER)

    def pids(self) -> list[int]:
        """The processes in the program's namespace."""
        return [int(pid) for pid in _run("ip", "netns", "pids", self.program).split()]

    def _filter(self, rules: str) -> None:
        _run("ip", "netns", "exec", self.controller, "iptables-restore", given=rules)


@contextmanager
def network() -> Iterator[Network]:
    """A new network; at the end, the program's processes are killed and the namespaces removed."""
    name = f"aioduco-{os.getpid()}-{next(_numbers)}"
    made = Network(f"{name}-controller", f"{name}-program")
    ends = ((made.controller, CONTROLLER), (made.program, _PROGRAM))
    try:
        for end, _ in ends:
            _run("ip", "netns", "add", end)
        pair = ("type", "veth", "peer", "name", _CABLE, "netns", made.program)
        _run("ip", "link", "add", "name", _CABLE, "netns", made.controller, *pair)
        for end, address in ends:
            steps = f"link set lo up\naddr add {address}/24 dev {_CABLE}\nlink set {_CABLE} up\n"
            _run("ip", "-n", end, "-batch", "-", given=steps)
        yield made
    finally:
        there = _run("ip", "netns", "list")
        for end, _ in ends:
            if end not in there:
                continue
            for pid in _run("ip", "netns", "pids", end).split():
                _kill(int(pid))
            _run("ip", "netns", "del", end)


def _kill(pid: int) -> None:
    try:
        os.kill(pid, 9)
    except ProcessLookupError:
        return


@functools.cache
def why_not() -> str:
    """Why no network can be made here; empty if it can."""
    try:
        with network() as made:
            for kind in KINDS:
                made.interrupt(kind)
                made.restore(kind)
    except NotPermitted as exc:
        return str(exc)
    return ""
