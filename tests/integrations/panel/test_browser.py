"""The panel's page in a browser, on a simulated arm."""

from __future__ import annotations

import shutil
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any

import pytest
import pytest_asyncio
from test_cli_robot import HOME

import aioduco
from aioduco.integrations.panel import Panel
from aioduco.sim import Simulator
from aioduco.sim.console import Console
from aioduco.sim.server.line_server import LineServer
from aioduco.testing import eventually_async

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from playwright.async_api import Browser, BrowserContext, Page

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
pytestmark = [
    pytest.mark.slow,
    pytest.mark.browser,
    pytest.mark.timeout(600),
    pytest.mark.skipif(CHROMIUM is None, reason="there is no Chromium"),
    pytest.mark.asyncio(loop_scope="module"),  # that of the browser
]

#: nothing of these tests is about how long a page takes, on a machine that is busy with others
PATIENT: dict[str, Any] = {"listen": 0, "hold_limit": 60.0, "page_limit": 60.0}
SOFTWARE = [
    "--no-sandbox",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
]


@pytest_asyncio.fixture(scope="module", loop_scope="module")
async def browser() -> AsyncIterator[Browser]:
    playwright = pytest.importorskip("playwright.async_api")
    async with playwright.async_playwright() as driver:
        chromium = await driver.chromium.launch(executable_path=CHROMIUM, args=SOFTWARE)
        yield chromium
        await chromium.close()


@pytest_asyncio.fixture(loop_scope="module")
async def chromium(browser: Browser) -> AsyncIterator[BrowserContext]:
    """The browser, without what other tests left in it."""
    context = await browser.new_context(
        viewport={"width": 1200, "height": 800},
        bypass_csp=True,  # for the functions that the tests wait for
    )
    yield context
    await context.close()


async def opened(chromium: BrowserContext, url: str, *, scene: bool = False) -> Page:
    page = await chromium.new_page()
    page.set_default_timeout(120_000)
    if not scene:  # drawn in software, it takes most of what the computer has
        await page.route("**/scene*", lambda route: route.abort())
    await page.goto(url)
    await page.wait_for_function("state !== null && state.sample !== null")
    return page


async def commanding(chromium: BrowserContext, panel: Panel) -> Page:
    page = await opened(chromium, panel.link)
    assert "token" not in page.url, "the page takes the token out of sight"
    await page.click("#take")
    await page.click("#ask-yes")
    await page.wait_for_selector("body.commanding")
    return page


async def press(page: Page, selector: str) -> None:
    """Press a button, and keep it down until the page was told that its motion goes on."""
    await page.wait_for_selector(f"{selector}:enabled")
    await page.hover(selector)
    await page.mouse.down()
    await page.wait_for_function("state.motion !== null")


@asynccontextmanager
async def arm_and_panel(**options: Any) -> AsyncIterator[tuple[Simulator, Panel]]:
    with Simulator(joints=HOME) as sim:
        async with aioduco.connect(sim.host, sim.port, heartbeat=None) as robot:
            await robot.bring_up()
        async with Panel(sim.host, sim.port, clock=sim.clock, **(PATIENT | options)) as panel:
            yield sim, panel


async def test_jog_by_press_and_hold_then_move_and_switch(chromium: BrowserContext) -> None:
    """A jog lasts as long as its button; so does a motion to where the sliders point."""
    async with arm_and_panel() as (sim, panel):
        page = await commanding(chromium, panel)
        await press(page, '[data-jog="1+"]')
        await eventually_async(lambda: sim.joints[0] > HOME[0] + 0.02, timeout=120)
        assert sim.moving
        await page.mouse.up()
        await eventually_async(lambda: not sim.moving, timeout=120)
        await page.wait_for_function("state.motion === null")
        stood = sim.joints[0]
        await page.click("[data-tab=move]")
        await page.fill("#targets .target:nth-child(6) input[type=number]", "20")
        await press(page, "#move")
        await eventually_async(lambda: sim.moving, timeout=120)
        await eventually_async(lambda: abs(sim.joints[5] - 0.349) < 0.01, timeout=120)
        await page.mouse.up()
        assert sim.joints[0] == pytest.approx(stood, abs=1e-3)
        await page.click("[data-tab=measure]")
        await page.click("[data-step=touch]")
        await page.wait_for_function("$('measured-tool').textContent.startsWith('1 touches')")
        await page.click("[data-tab=signals]")
        await page.click("#outputs .lamp:nth-child(3)")
        await eventually_async(lambda: sim.get_digital_output(3), timeout=120)
        await page.wait_for_selector("#outputs .lamp.on:nth-child(3)")


async def test_what_the_sliders_do_not_show_is_no_target(chromium: BrowserContext) -> None:
    """A number that was deleted counted as 0, joints as millimetres, an old place as the tool's."""
    async with (
        arm_and_panel() as (sim, panel),
        aioduco.connect(sim.host, sim.port, clock=sim.clock) as robot,
    ):
        page = await commanding(chromium, panel)
        await page.click("[data-tab=move]")
        first = "#targets .target:nth-child(1) input[type=number]"
        await page.fill(first, "20")
        await page.wait_for_selector("#move:enabled")
        await page.fill(first, "")
        await page.wait_for_selector("#move:disabled")
        await page.fill(first, "20")
        moving = await robot.motion.movej2((3.0, *HOME[1:]), v=0.05, a=1.0).start()
        await page.wait_for_function("state.sample.moving")
        await page.click("input[value=line]")
        assert not await page.input_value(first)
        await page.wait_for_selector("#move:disabled")
        await moving.cancel()
        await page.wait_for_function("!state.sample.moving && seldom.work_pose")
        await page.click("#from-here")
        here = (await robot.state.get_tcp_pose_coord()).x
        assert float(await page.input_value(first)) == pytest.approx(1e3 * here, abs=0.1)


async def test_a_target_of_before_the_connection_was_lost_is_none(
    chromium: BrowserContext,
) -> None:
    """The arm may be elsewhere by then, or another one; the picture showed no such target."""
    async with arm_and_panel() as (_, panel):
        page = await commanding(chromium, panel)
        await page.click("[data-tab=move]")
        first = "#targets .target:nth-child(1) input[type=number]"
        await page.fill(first, "20")
        await page.wait_for_selector("#move:enabled")
        await page.evaluate("socket.close()")
        await page.wait_for_function("hello.page === 2 && state !== null")
        assert not await page.input_value(first)
        assert await page.evaluate("aimed") is False


async def test_stop_by_a_click_that_no_pointer_made(chromium: BrowserContext) -> None:
    """As of a screen reader, or of voice control: nothing was sent."""
    async with arm_and_panel() as (_, panel):
        page = await opened(chromium, panel.url)
        await page.evaluate("$('stop').click()")
        await page.wait_for_function("document.body.innerText.includes('stopped: the arm stands')")


async def test_a_token_that_is_no_part_of_an_address_takes_no_stop_from_the_page(
    chromium: BrowserContext,
) -> None:
    """A script that ended there would leave a page whose STOP does nothing."""
    token = "100%-sure & safe"
    async with arm_and_panel(token=token) as (_, panel):
        await commanding(chromium, panel)
        page = await opened(chromium, f"{panel.url}#token={token}")
        assert await page.evaluate("token") == token.replace(" ", "%20")
        await page.click("#stop")
        await page.wait_for_function("document.body.textContent.includes('the arm stands')")


#: texts whose contrast to what is behind them is too low to be read, as in WCAG 2
UNREADABLE = """() => {
  const rgba = (text) => text.match(/[\\d.]+/g).map(Number);
  const light = ([r, g, b]) => [r, g, b].map((v) => v / 255)
    .map((v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4))
    .reduce((sum, v, i) => sum + v * [0.2126, 0.7152, 0.0722][i], 0);
  const behind = (element) => {
    for (let each = element; each; each = each.parentElement) {
      const colour = rgba(getComputedStyle(each).backgroundColor);
      if (colour.length < 4 || colour[3] > 0.5) return colour;
    }
    return [255, 255, 255];
  };
  const found = [];
  for (const element of document.querySelectorAll("body *:not(option)")) {
    const own = [...element.childNodes].filter((n) => n.nodeType === 3).map((n) => n.data).join("");
    if (!own.trim() || !element.checkVisibility({opacityProperty: true})) continue;
    const style = getComputedStyle(element);
    const [low, high] = [light(rgba(style.color)), light(behind(element))].sort((a, b) => a - b);
    const ratio = (high + 0.05) / (low + 0.05), large = parseFloat(style.fontSize) >= 18;
    if (ratio < (large ? 3 : 4.5) || +style.opacity < 1) found.push(`${own.trim()}: ${ratio}`);
  }
  return found;
}"""

#: pairs of controls of which one lies over the other
OVERLAPS = """() => {
  const seen = [...document.querySelectorAll("button, select, input, footer, #events")]
    .filter((each) => each.checkVisibility() && !each.closest("dialog, #lost"));
  const found = [];
  for (const one of seen) for (const other of seen) {
    if (one === other || one.contains(other) || other.contains(one)) continue;
    const a = one.getBoundingClientRect(), b = other.getBoundingClientRect();
    const main = document.querySelector("main").getBoundingClientRect();
    const clip = (each, box) => each.closest("main") ? [Math.max(box.top, main.top),
      Math.min(box.bottom, main.bottom)] : [box.top, box.bottom];
    const [top, bottom] = clip(one, a), [top2, bottom2] = clip(other, b);
    if (Math.min(a.right, b.right) - Math.max(a.left, b.left) > 1
        && Math.min(bottom, bottom2) - Math.max(top, top2) > 1)
      found.push(`${one.id || one.textContent} over ${other.id || other.textContent}`);
  }
  return found;
}"""


async def test_every_text_can_be_read_also_of_what_is_pressed_or_off(
    chromium: BrowserContext,
) -> None:
    async with arm_and_panel() as (_, panel):
        watching = await opened(chromium, panel.url)
        assert await watching.evaluate(UNREADABLE) == []
        await watching.close()
        page = await commanding(chromium, panel)
        assert await page.evaluate(UNREADABLE) == []
        await press(page, '[data-jog="1+"]')
        await page.wait_for_selector("button.hold.down")
        assert await page.evaluate(UNREADABLE) == []
        await page.mouse.up()
        await page.wait_for_function("state.motion === null")
        await page.click("[data-tab=move]")
        assert "target" in await page.inner_text("#move")
        await page.fill("#targets .target:nth-child(6) input[type=number]", "20")
        await page.wait_for_selector("#move:enabled")
        assert await page.evaluate(UNREADABLE) == []
        await press(page, "#move")
        await page.wait_for_selector("#move.down")
        assert await page.evaluate(UNREADABLE) == []
        await page.mouse.up()


async def test_nothing_lies_over_anything_and_the_head_is_small(chromium: BrowserContext) -> None:
    async with arm_and_panel() as (_, panel):
        page = await opened(chromium, panel.url)
        await page.evaluate("document.querySelector('[data-tab=simulator]').hidden = false")
        tabs = await page.eval_on_selector_all("#tabs button", "all => all.map(t => t.dataset.tab)")
        assert {"jog", "move", "simulator"} <= set(tabs)
        wide = "document.scrollingElement.scrollWidth - innerWidth"
        for width, height in ((1440, 900), (1020, 768), (390, 844)):
            await page.set_viewport_size({"width": width, "height": height})
            for tab in tabs:
                place = f"{tab} at {width} pixels"
                await page.click(f"[data-tab={tab}]")
                assert await page.evaluate(UNREADABLE) == [], place
                for end in (0, 100_000):
                    await page.evaluate(f"document.querySelector('main').scrollTo(0, {end})")
                    assert await page.evaluate(OVERLAPS) == [], (place, end)
                    assert await page.evaluate(wide) <= 0, (place, end)
            head = await page.locator("header").bounding_box()
            stop = await page.locator("#stop").bounding_box()
            assert head is not None
            assert head["height"] < 0.16 * height
            assert stop is not None
            assert stop["y"] + stop["height"] <= height
            assert stop["height"] >= 60


#: where the controls are while the page tells of an alarm and of long states, and after it
PLACES = """() => {
  const places = () => [...document.querySelectorAll("main button, main input")]
    .filter((each) => each.checkVisibility()).map((each) => each.getBoundingClientRect().y);
  const told = structuredClone(state);
  Object.assign(state, {age: 10, holder: 99, alarm: "NO ANSWER FROM THE CONTROLLER FOR 10 s: OLD"});
  Object.assign(state.sample, {robot: "INITIALIZE", program: "TASK_RUNNING", safety: "POWER_OFF"});
  showState();
  document.querySelector("main").scrollTo(0, 100_000);
  const before = places();
  state = told;
  showState();
  return [before, places()];
}"""


async def test_no_control_moves_under_the_pointer(chromium: BrowserContext) -> None:
    """An alarm that came as a button was pressed had the one above it pressed: another joint's."""
    async with arm_and_panel() as (_, panel):
        page = await opened(chromium, panel.url)
        for width, height in ((1440, 900), (1200, 800), (1020, 768), (390, 844)):
            await page.set_viewport_size({"width": width, "height": height})
            before, after = await page.evaluate(PLACES)
            assert after == before, f"at {width} pixels"


async def test_the_place_of_the_picture_says_that_it_is_loading(chromium: BrowserContext) -> None:
    async with arm_and_panel() as (_, panel):
        page = await opened(chromium, panel.url)  # its picture never comes
        assert "is loading" in await page.inner_text("#scene-wait")
        covered = "document.elementFromPoint(...['x', 'y'].map((side, i) => {"
        covered += "const box = document.getElementById('scene').getBoundingClientRect();"
        covered += "return box[side] + [box.width, box.height][i] / 2; })).id"
        assert await page.evaluate(covered) == "scene-wait"


async def test_stop_in_mid_motion_needs_no_lease(chromium: BrowserContext) -> None:
    """Whoever moves the arm, and from a page that only watches."""
    async with (
        arm_and_panel() as (sim, panel),
        aioduco.connect(sim.host, sim.port, clock=sim.clock) as robot,
    ):
        page = await opened(chromium, panel.url)
        task = await robot.motion.movej2((3.0, *HOME[1:]), v=0.05, a=1.0).start()
        await page.wait_for_function("state.sample.moving")
        await page.click("#stop")
        with pytest.raises(aioduco.TaskStopped):
            await task
        await eventually_async(lambda: not sim.moving, timeout=120)
        await page.wait_for_function("document.body.innerText.includes('stopped: the arm stands')")
        assert sim.joints[0] < 2.9


@pytest.mark.parametrize("how", ["closed", "silent"])
async def test_the_arm_stands_when_its_page_is_lost_in_mid_jog(
    chromium: BrowserContext, how: str
) -> None:
    options = {"hold_limit": 20.0} if how == "silent" else {}
    async with arm_and_panel(**options) as (sim, panel):
        page = await commanding(chromium, panel)
        await press(page, '[data-jog="1+"]')
        await eventually_async(lambda: sim.joints[0] > HOME[0] + 0.02, timeout=120)
        if how == "closed":
            await page.close()
        else:  # its script hangs, as in a page whose computer swaps; the connection is there
            debugger = await chromium.new_cdp_session(page)
            await debugger.send("Debugger.enable")
            await page.evaluate("window.setTimeout(() => { debugger; }, 0)")
        await eventually_async(lambda: not sim.moving, timeout=120)
        if how == "closed":
            await eventually_async(lambda: "free" in repr(panel), timeout=120)
        stood = sim.joints[0]
        began = sim.time
        await eventually_async(lambda: sim.time > began + 0.5, timeout=120)
        assert sim.joints[0] == pytest.approx(stood, abs=1e-3)


async def test_the_second_page_only_watches_and_a_wrong_token_moves_nothing(
    chromium: BrowserContext, caplog: pytest.LogCaptureFixture
) -> None:
    async with arm_and_panel() as (sim, panel):
        second = await opened(chromium, panel.url)
        await second.click("#take")
        await second.fill("#token", "a guess")
        await second.click("#ask-yes")
        await second.wait_for_function("!document.getElementById('notice').hidden")
        assert "wrong token" in await second.inner_text("#notice")
        await eventually_async(lambda: "wrong token" in caplog.text)
        assert "a guess" not in caplog.text
        assert panel.token not in caplog.text
        first = await commanding(chromium, panel)
        await second.wait_for_function(
            "document.getElementById('control-state').textContent === 'Another page commands'"
        )
        for selector in ('[data-jog="1+"]', "[data-verb=bring_up]", "#take"):
            assert await second.is_disabled(selector), selector
        assert await second.is_enabled("#stop")
        # and what its script is made to send is refused
        await second.evaluate(
            "send({ask: 'press', seen, motion: {kind: 'jog', axis: 1, direction: 1, percent: 50}})"
        )
        await second.wait_for_function(
            "document.getElementById('notice').textContent.includes('does not command')"
        )
        assert not sim.moving
        assert sim.joints == pytest.approx(HOME, abs=1e-3)
        await first.click("#give-back")
        await second.wait_for_selector("#take:enabled")


async def test_a_page_says_at_once_that_it_lost_its_server(chromium: BrowserContext) -> None:
    async with arm_and_panel() as (_, panel):
        page = await opened(chromium, panel.url)
        assert not await page.is_visible("#lost")
    await page.wait_for_selector("#lost", state="visible")
    assert "THIS PAGE CANNOT STOP THE ARM" in await page.inner_text("#lost")
    box = await page.locator("#lost").bounding_box()
    assert box == {"x": 0, "y": 0, "width": 1200, "height": 800}


async def test_a_page_that_its_server_never_answered_says_that_it_cannot_stop(
    chromium: BrowserContext,
) -> None:
    async with arm_and_panel() as (_, panel):
        page = await chromium.new_page()
        await page.route_web_socket("**/socket", lambda _: None)  # open, and silent
        await page.goto(panel.url)
        await page.wait_for_selector("#lost:visible", timeout=120_000)


async def test_the_picture_shows_the_arm_where_it_is(chromium: BrowserContext) -> None:
    """By viser's page, in a frame of ours and without its controls."""
    async with arm_and_panel() as (_, panel):
        page = await opened(chromium, panel.url, scene=True)
        frame = page.frame_locator("#scene")
        await frame.locator("canvas").first.wait_for(state="visible")
        await page.wait_for_selector("#scene-wait", state="hidden")  # a body of the arm is drawn
        await frame.locator("[data-floating-window]").first.wait_for(state="hidden")
        # Below 768 pixels another box, at the lower end, would cover most of it.
        await page.set_viewport_size({"width": 390, "height": 844})
        await frame.locator("[data-floating-window]").first.wait_for(state="detached")
        box = frame.locator(".mantine-Paper-root").first
        await box.wait_for(state="attached")
        assert not await box.is_visible()
        # To the browser it is another site's, and so drawn in a process of its own.
        (picture,) = (each for each in page.frames if each != page.main_frame)
        assert picture.url.startswith("http://localhost:")
        # It takes the keys once it was clicked: the stop's works there, too.
        await page.click("#scene")
        await page.keyboard.press("Escape")
        await page.wait_for_function("document.body.innerText.includes('stopped: the arm stands')")


async def test_the_simulator_is_pushed_and_faulted_and_led_out_of_it(
    chromium: BrowserContext,
) -> None:
    with Simulator(joints=HOME) as sim:
        with_lines = LineServer(Console(sim).answer, 0)
        try:
            async with Panel(
                sim.host, sim.port, simulator_port=with_lines.port, clock=sim.clock, **PATIENT
            ) as panel:
                page = await commanding(chromium, panel)
                await page.click("[data-tab=simulator]")
                await page.click("[data-line=estop]")
                await page.wait_for_function(
                    "document.getElementById('alarm').textContent === 'EMERGENCY STOP PRESSED'"
                )
                await page.click("[data-line=release]")
                await page.click("[data-line='speed 3']")
                await eventually_async(lambda: sim.speed == 3.0, timeout=120)
                await page.click("[data-verb=bring_up]")
                await page.click("#ask-yes")
                await page.wait_for_function("state.sample.robot === 'ENABLE'")
                await page.click("[data-push='0 0 -1']")
                await page.wait_for_function(
                    "document.getElementById('events').innerText.includes('push 0 0 -40: ok')"
                )
        finally:
            with_lines.close()
