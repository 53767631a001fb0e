"""A loop that only sleeps to each tick, in C: what the machine does to anybody's schedule."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from types import TracebackType

C = r"""
#include <stdio.h>
#include <stdint.h>
#include <stdlib.h>
#include <poll.h>
#include <sys/prctl.h>
#include <time.h>

static int64_t now(void) {
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return t.tv_sec * 1000000000LL + t.tv_nsec;
}

int main(int argc, char **argv) {
    int64_t period = atoll(argv[1]), due = now() + period, missed = 0;
    struct pollfd in = {0, POLLIN, 0};
    prctl(PR_SET_TIMERSLACK, 1);
    printf("[");
    for (int64_t tick = 0;; tick++) {
        struct timespec t = {due / 1000000000LL, due % 1000000000LL};
        clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, NULL);
        int64_t late = now() - due;
        printf("%lld,", (long long)late);
        for (due += period; now() - due >= period; due += period, missed++)
            printf("%lld,", (long long)(now() - due));
        if (tick % 64 == 0 && poll(&in, 1, 0) > 0) break;
    }
    printf("%lld]\n", (long long)missed);
    return 0;
}
"""

PYTHON = """
import json, select, sys, time
period = int(sys.argv[1])
due, late, missed = time.monotonic_ns() + period, [], 0
while True:
    time.sleep(max(0, due - time.monotonic_ns()) * 1e-9)
    late.append(time.monotonic_ns() - due)
    due += period
    while time.monotonic_ns() - due >= period:
        late.append(time.monotonic_ns() - due)
        due += period
        missed += 1
    if len(late) % 64 == 0 and select.select([sys.stdin], [], [], 0)[0]:
        break
print(json.dumps([*late, missed]))
"""


class BareLoop:
    """The loop, in a process of its own on one processor, or any for None, while the block runs."""

    def __init__(self, rate: float, core: int | None) -> None:
        self._core = core
        self._period = round(1e9 / rate)
        self._late: list[int] = []
        self.missed = 0

    def __enter__(self) -> BareLoop:
        self._folder = tempfile.TemporaryDirectory()
        self._output = (Path(self._folder.name) / "late").open("w+")
        self._process = subprocess.Popen(
            [*self._command(), str(self._period)], stdin=subprocess.PIPE, stdout=self._output
        )
        if self._core is not None:
            os.sched_setaffinity(self._process.pid, {self._core})
        return self

    def _command(self) -> list[str]:
        compiler = shutil.which("cc") or shutil.which("gcc")
        if compiler is None:
            return [sys.executable, "-c", PYTHON]
        source, program = Path(self._folder.name) / "bare.c", Path(self._folder.name) / "bare"
        source.write_text(C)
        subprocess.run([compiler, "-O2", "-o", str(program), str(source)], check=True)
        return [str(program)]

    def __exit__(
        self,
        kind: type[BaseException] | None,
        value: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._process.communicate(timeout=10)
        self._output.seek(0)
        *self._late, self.missed = json.load(self._output)
        self._output.close()
        self._folder.cleanup()

    @property
    def ticks(self) -> int:
        return len(self._late) - self.missed

    def buckets(self) -> list[tuple[int, int, int]]:
        """Lateness as histograms give it [ns]."""
        from aioduco.streaming.shared.histogram import Histogram  # noqa: PLC0415  # only for this

        histogram = Histogram()
        for late in self._late:
            histogram.record(late)
        found: Any = histogram.buckets()
        return list(found)
