"""Write `docs/images/panel.png`: the panel's page, as a browser shows it while an arm moves.

python docs/panel_picture.py [FOLDER]

With a folder, the page is also drawn there while its picture loads, and in the widths of a small
screen and of a phone, from its top and its end. It needs Chromium, and takes a while where that
draws in software.
"""

from __future__ import annotations

import shutil
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import anyio
from PIL import Image
from playwright.async_api import async_playwright

import aioduco
from aioduco.envelope import Envelope, Zone
from aioduco.integrations.panel import Panel
from aioduco.planning import Scene
from aioduco.sim import Simulator
from aioduco.sim.console import Console
from aioduco.sim.scene import Box, Table
from aioduco.sim.server.line_server import LineServer

if TYPE_CHECKING:
    from playwright.async_api import Page

PICTURE = Path(__file__).resolve().parent / "images" / "panel.png"
WIDTH, HEIGHT = 1440, 900
SMALLER = ((1020, 768), (390, 844))
SOFTWARE = [
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
]
HOME = (0.0, -0.3, 1.8, 0.0, -1.57, 0.0)
# patient: a busy machine is to give the same picture
PATIENCE: dict[str, Any] = {"heartbeat": 60.0, "call_timeout": 60.0, "loop_stall_limit": 60.0}
AROUND = [
    Table(at=(0.62, 0.0, 0.24), size=(0.5, 0.8), name="table"),
    Box(at=(0.6, 0.24, 0.29), size=(0.1, 0.1, 0.1), colour=(0.75, 0.55, 0.25), name="part"),
]


async def point(page: Page, angles: dict[int, int]) -> None:
    """Point by the sliders."""
    for joint, angle in angles.items():
        await page.fill(f"#targets .target:nth-child({joint}) input[type=number]", str(angle))


async def shown(page: Page) -> None:
    """Lead the arm about, until the page shows it in mid motion."""
    await page.click("#take")
    # By the key: the question lies over the scene, and Chromium gives the scene a click that comes
    # before the question has been drawn.
    await page.press("#ask-yes", "Enter")
    await page.wait_for_selector("body.commanding")
    await page.click("[data-tab=signals]")
    await page.click("#outputs .lamp:nth-child(3)")
    await page.click("[data-tab=move]")
    for first, sign in ((30, -1), (-20, 1)):
        await point(page, {1: first, 3: 95})
        await page.hover("#move")
        await page.mouse.down()
        way = f"{sign} * (state.sample.joints[0] * DEGREE - {first}) > -1"
        await page.wait_for_function(f"() => {way} && state.motion === null")
        await page.mouse.up()
    await point(page, {1: -68, 2: -40, 3: 112, 6: 45})
    await page.hover("#move")
    await page.mouse.down()
    await page.wait_for_function("() => state.sample.joints[0] * DEGREE < -32")


async def also(page: Page, folder: Path) -> None:
    """Draw the page in other widths, from its top and from its end."""
    for width, height in SMALLER:
        await page.set_viewport_size({"width": width, "height": height})
        await page.wait_for_timeout(1500)
        await page.screenshot(path=folder / f"panel-{width}.png")
        await page.evaluate("for (const each of [document.body, document.querySelector('main')]) "
                            "each.scrollTo(0, each.scrollHeight)")  # fmt: skip
        await page.screenshot(path=folder / f"panel-{width}-end.png")


async def drawn(sim: Simulator, lines: LineServer, folder: Path | None) -> None:
    """Draw the page."""
    scene = Scene("gcr5_910", AROUND)
    envelope = Envelope(
        "gcr5_910",
        Zone.box((0.0, 0.72, 0.55), (1.3, 0.04, 1.1), name="keep out: the aisle"),
        Zone.plane((0.0, 0.0, 0.02), (0.0, 0.0, 1.0), name="keep above the floor"),
    )
    async with aioduco.connect(sim.host, sim.port, **PATIENCE) as robot:
        await robot.bring_up()
    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    async with (
        Panel(
            sim.host, sim.port, listen=0, name="left", scene=scene, envelope=envelope,
            hold_limit=120.0, page_limit=120.0, simulator_port=lines.port, **PATIENCE,
        ) as panel,
        async_playwright() as driver,
    ):  # fmt: skip
        browser = await driver.chromium.launch(executable_path=chromium, args=SOFTWARE)
        page = await browser.new_page(
            viewport={"width": WIDTH, "height": HEIGHT}, device_scale_factor=1, bypass_csp=True
        )
        page.set_default_timeout(180_000)
        await page.goto(panel.link)
        await page.wait_for_function("() => state !== null && state.sample !== null")
        if folder is not None:
            await page.screenshot(path=folder / "panel-loading.png")
        await page.wait_for_selector("#scene-wait", state="hidden")
        await page.wait_for_timeout(1500)
        await shown(page)
        sim.lock_time()  # however long the browser draws, the arm is in mid motion
        await page.wait_for_timeout(3000)
        await page.screenshot(path=PICTURE if folder is None else folder / f"panel-{WIDTH}.png")
        if folder is not None:
            await also(page, folder)
        sim.unlock_time()
        await page.mouse.up()
        await browser.close()
    if folder is not None:
        return
    with Image.open(PICTURE) as image:
        image.convert("P", palette=Image.Palette.ADAPTIVE, colors=256).save(PICTURE, optimize=True)


def main() -> int:
    """Write the picture."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else None
    if folder is not None:
        folder.mkdir(parents=True, exist_ok=True)
    with Simulator(joints=HOME, scene=AROUND) as sim:
        lines = LineServer(Console(sim).answer, 0)
        try:
            anyio.run(drawn, sim, lines, folder)
        finally:
            lines.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
