"""A tap between a client and a controller: how much later the answers are.

    python benchmarks/tap.py [--quick] [--save]

Calls of thriftpy2's own client to one server whose handlers do nothing, straight and through
`aioduco tap`, which decodes and writes each of them, 500 a second as a program makes that streams,
by turns of short rounds: what else the machine does meets both. A second connection straight to the
server is measured beside them: what it differs by from the first one is the machine's noise.
"""

from __future__ import annotations

import contextlib
import re
import signal
import subprocess
import sys
import time
from typing import TYPE_CHECKING

from _common import in_turns, parser, report, spread
from _processes import HOST, ServerProcess
from rpc import thriftpy2_client

if TYPE_CHECKING:
    from collections.abc import Iterator

CALLS = 20  # in a round
RATE = 500  # calls a second, as of a program that streams by servoj


@contextlib.contextmanager
def tap(port: int) -> Iterator[int]:
    """`aioduco tap`; the port that it listens on."""
    command = [sys.executable, "-m", "aioduco.cli", "tap", HOST, "--port", str(port), "--json"]
    with subprocess.Popen(
        [*command, "--listen", f"{HOST}:0"],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    ) as program:
        assert program.stderr is not None
        found = re.match(r"between [\d.]+:(\d+) ", program.stderr.readline())
        assert found
        yield int(found[1])
        program.send_signal(signal.SIGINT)


def main() -> None:
    options = parser(__doc__).parse_args()
    rounds = 20 if options.quick else 400
    names = ("straight", "straight, once more", "through a tap")
    times: dict[str, list[float]] = {name: [] for name in names}
    with contextlib.ExitStack() as stack:
        [port] = stack.enter_context(ServerProcess("controller.py")).ports
        ports = (port, port, stack.enter_context(tap(port)))
        clients = {
            name: thriftpy2_client(each, stack) for name, each in zip(names, ports, strict=True)
        }
        for name, client in in_turns(rounds + 5, clients):
            start = time.perf_counter()
            for call in range(CALLS):
                time.sleep(max(0.0, start + call / RATE - time.perf_counter()))
                begin = time.perf_counter()
                client.get_noneblock_taskstate(1063)
                times[name].append(time.perf_counter() - begin)
    # the first rounds are left out
    rows = {name: spread(each[5 * CALLS :]) for name, each in times.items()}
    straight, tapped = rows["straight"], rows["through a tap"]
    added = {key: round(tapped[key] - straight[key], 1) for key in ("p50_us", "p99_us")}
    report(options, "tap", {"calls": rounds * CALLS, "durations": rows, "added": added})


if __name__ == "__main__":
    main()
