"""Make the picture of `docs/preflight.md`: a report of a planted fault, in headless Chromium.

    python docs/preflight_page.py
    python docs/preflight_page.py --check    only open the page, at full width and at 400 pixels

Either way the page is looked at first: it must load nothing, show its pictures, and be no wider
than the window. Needs Debian's chromium, and the extras sim and plot.
"""

from __future__ import annotations

import argparse
import json
import re
import subprocess
import sys
import tempfile
from html import escape, unescape
from pathlib import Path
from typing import Any

from PIL import Image

from aioduco.sim.scene import Box
from aioduco.testing.preflight import PreflightSettings, preflight
from aioduco.testing.preflight.html import page

HERE = Path(__file__).resolve().parent
PROGRAM = HERE.parent / "tests/testing/preflight/programs/scene_collision.py"
CELL = [Box(at=(0.35, 0.35, 0.4), size=(0.2, 0.2, 0.8), colour=(0.8, 0.3, 0.2), name="box")]


WIDTHS = (1020, 400)
#: tells the document around it what the page has become
PROBE = """<script>addEventListener("load", () => {
  parent.document.documentElement.dataset.seen = JSON.stringify({
    width: innerWidth, page: document.documentElement.scrollWidth,
    loaded: performance.getEntriesByType("resource").map(each => each.name),
    pictures: [...document.images].map(each => [each.naturalWidth, each.clientWidth])
  })
})</script>"""


def chromium(folder: Path, *options: str) -> str:
    """Run it without a window and without the network, and return what it prints."""
    return subprocess.run(
        [
            *("chromium", "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars"),
            *("--disable-background-networking", f"--user-data-dir={folder}/profile", *options),
        ],
        check=True,
        capture_output=True,
        text=True,
        timeout=120,
    ).stdout


def opened(text: str, width: int) -> dict[str, Any]:
    """What a page has become in a frame that is so wide [pixels].

    Returns:
        `width` of the frame; `page`, that of the page; what it `loaded`; `pictures`, each with its
        own width and the one shown.
    """
    inside = escape(text.replace("</head>", f"{PROBE}</head>"))
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "page.html"
        # No window is as narrow as a telephone: a frame is.
        frame = f'<iframe width="{width}" height="900" style="border:0" srcdoc="{inside}"></iframe>'
        file.write_text(f"<!doctype html><html><body>{frame}</body></html>", encoding="utf-8")
        shown = chromium(Path(folder), "--window-size=1100,1000", "--dump-dom", file.as_uri())
    found = re.search(r'data-seen="([^"]*)"', shown)
    if found is None:
        raise RuntimeError("the page was not loaded")
    seen: dict[str, Any] = json.loads(unescape(found[1]))
    return seen


def check(text: str) -> None:
    """Look at a page at each width.

    Raises:
        RuntimeError: it loads something, is too wide, or lacks its pictures.
    """
    for width in WIDTHS:
        seen = opened(text, width)
        sys.stdout.write(f"{width} pixels: {json.dumps(seen)}\n")
        small = any(not own or not 0 < shown <= width for own, shown in seen["pictures"])
        wide = seen["width"] != width or seen["page"] > width
        if seen["loaded"] or wide or small or not seen["pictures"]:
            raise RuntimeError(f"the page is not right at {width} pixels: {seen}")


def report() -> str:
    """The page of a planted fault."""
    found = preflight(PROGRAM, (), PreflightSettings(scene=CELL), quiet=True)
    return page(found).replace(str(PROGRAM), PROGRAM.name)


def main() -> None:
    """Look at the page, and write `docs/images/preflight.png`."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--check", action="store_true", help="write nothing")
    only_check: bool = parser.parse_args().check
    text = report()
    check(text)
    if only_check:
        return
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        html, shot = folder / "page.html", folder / "page.png"
        html.write_text(text, encoding="utf-8")
        chromium(folder, "--window-size=1020,1240", f"--screenshot={shot}", html.as_uri())
        picture = Image.open(shot).resize((765, 930)).quantize(128)
        picture.save(HERE / "images/preflight.png", optimize=True)


if __name__ == "__main__":
    main()
