"""The panel: from a click on its stop to the controller, and what those who watch cost.

    python benchmarks/panel.py [--quick] [--save]

`aioduco panel` in a process of its own, on a controller with trivial handlers whose arm swings on.
Its page is driven in headless Chromium; a click counts from the time that the browser stamps on it,
until the controller's handler is reached. Beside it, by turns, stands `robot.stop()` of a program:
what it takes is the machine's own, and both are of one run. The picture in 3D is drawn in software
here, which takes most of the machine: the clicks are counted without it, too. Those who watch are
pages without a browser, with both of a page's connections, for the state and for the 3D picture.
"""

from __future__ import annotations

import contextlib
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import anyio
from _common import HERE, ServerProcess, arguments, percentile, print_table, spread, write_results
from playwright.async_api import async_playwright

import aioduco
from aioduco._wire.lane import WireLane

if TYPE_CHECKING:
    from collections.abc import Iterator

HOST = "127.0.0.1"
RATE = 20.0
SOFTWARE = [
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
]
#: keeps when the browser stamped each press, by the wall's clock [s]
STAMP = """() => {
  window.stamps = [];
  document.addEventListener("pointerdown", (event) => {
    const ahead = Date.now() - (performance.timeOrigin + performance.now());
    window.stamps.push((performance.timeOrigin + event.timeStamp + ahead) / 1000);
  }, true);
}"""


@contextlib.contextmanager
def panel(port: int) -> Iterator[tuple[subprocess.Popen[str], int]]:
    """`aioduco panel`, and the port of its page."""
    command = [sys.executable, "-m", "aioduco.cli", "panel", HOST, "--port", str(port)]
    with subprocess.Popen(
        [*command, "--listen", "0", "--rate", f"{RATE:g}", "--watch-only"],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    ) as program:
        assert program.stdout is not None
        found = re.search(r"http://[\d.]+:(\d+)/", program.stdout.readline())
        assert found
        try:
            yield program, int(found[1])
        finally:
            program.send_signal(signal.SIGINT)


CLICK, PLAIN, PROGRAM = "click on STOP", "without the picture", "robot.stop() of a program"


async def stops(
    port: int, page_port: int, count: int, *, picture: bool = True
) -> dict[str, list[float]]:
    """Seconds from the click, and from `robot.stop()`, to the controller's handler."""
    click = CLICK if picture else PLAIN
    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    lane = WireLane("read", HOST, port)
    await lane.open()
    robot = aioduco.connect(HOST, port, heartbeat=None, lag_limit=None)
    times: dict[str, list[float]] = {click: [], PROGRAM: []}
    async with async_playwright() as driver, robot:
        browser = await driver.chromium.launch(executable_path=chromium, args=SOFTWARE)
        page = await browser.new_page(viewport={"width": 1400, "height": 900}, bypass_csp=True)
        if not picture:
            await page.route("**/scene*", lambda route: route.abort())
        await page.goto(f"http://{HOST}:{page_port}/")
        await page.wait_for_function("() => state !== null && state.sample !== null")
        await page.wait_for_timeout(3000)  # the 3D picture is there
        await page.evaluate(STAMP)
        await page.hover("#stop")
        for number in range(count + 5):
            await lane.rpc.get_system_value_list("stops")
            await page.mouse.down()
            await page.mouse.up()
            stamp = (await page.evaluate("() => window.stamps"))[-1]
            reached: list[float] = []
            with anyio.fail_after(10):
                while not reached:
                    await anyio.sleep(0.02)
                    reached = await lane.rpc.get_system_value_list("stops")
            await page.wait_for_function("() => !state.busy.includes('stop')")
            begin = time.time()
            await robot.stop()
            other = await lane.rpc.get_system_value_list("stops")
            if number >= 5:
                times[click].append(reached[0] - stamp)
                times[PROGRAM].append(other[0] - begin)
            await anyio.sleep(0.05 + 0.01 * (number % 7))  # at no moment of the state's period
        await browser.close()
    await lane.aclose()
    return times


def cpu(pid: int) -> float:
    """Seconds of a core that a process has used."""
    fields = Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def watched(pid: int, page_port: int, number: int, seconds: float) -> dict[str, float]:
    """What a panel takes while so many watch, and the states that each is told."""
    with subprocess.Popen(
        [
            sys.executable, str(HERE / "panel_watchers.py"),
            str(page_port), str(page_port + 1), str(number),
        ],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
    ) as program:  # fmt: skip
        assert program.stdin is not None
        assert program.stdout is not None
        program.stdout.readline()
        time.sleep(2.0)

        def counted() -> list[int]:
            assert program.stdin is not None
            assert program.stdout is not None
            program.stdin.write("\n")
            program.stdin.flush()
            counts: list[int] = json.loads(program.stdout.readline())
            return counts

        counted()
        used, begin = cpu(pid), time.monotonic()
        time.sleep(seconds)
        counts = counted()
        took = time.monotonic() - begin
        percent = 100 * (cpu(pid) - used) / took
        program.stdin.close()
    told = min(counts) / took if counts else 0.0
    return {"core_percent": round(percent, 1), "states_hz": round(told, 1)}


def main() -> None:
    options = arguments(__doc__, "panel")
    count, seconds = (20, 5.0) if options.quick else (300, 20.0)
    with ServerProcess("panel_server.py") as server:
        port = server.endpoints["rpc"]
        with panel(port) as (_, page_port):
            times = anyio.run(stops, port, page_port, count)
            plain = anyio.run(partial(stops, picture=False), port, page_port, count)
            times = {CLICK: times[CLICK], PLAIN: plain[PLAIN], PROGRAM: times[PROGRAM]}
        watchers: dict[str, dict[str, float]] = {}
        with panel(port) as (program, page_port):
            for number in (0, 1, 20, 0):
                name = f"{number} watching"
                name += ", once more" if name in watchers else ""
                watchers[name] = watched(program.pid, page_port, number, seconds)
    rows = {name: spread(each) for name, each in times.items()}
    print_table(
        f"{count} stops each, to the controller's handler [µs]",
        ["", "p50", "p99", "p99.9", "max"],
        [[name, *row.values()] for name, row in rows.items()],
    )
    print_table(
        "the panel's process, with all that it asks the controller",
        ["", "of a core [%]", "states each [Hz]"],
        [[name, *row.values()] for name, row in watchers.items()],
    )
    base = watchers["0 watching"]["core_percent"]
    ratio = {
        f"click_to_program_p{percent}": round(
            percentile(sorted(times[CLICK]), percent) / percentile(sorted(times[PROGRAM]), percent),
            1,
        )
        for percent in (50, 99)
    }
    cost = round(watchers["20 watching"]["core_percent"] - base, 1)
    noise = round(abs(watchers["0 watching, once more"]["core_percent"] - base), 1)
    print(f"20 who watch add {cost} % of a core; the two runs without any differ by {noise} %")
    results = {
        "stops": count,
        "durations": rows,
        "ratios": ratio,
        "watching": watchers,
        "added_by_20_percent": cost,
        "noise_percent": noise,
    }
    if options.save:
        print(f"written: {write_results('panel', results)}")


if __name__ == "__main__":
    main()
