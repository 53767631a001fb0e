"""Draw pages of the site, and check that no line of their code is cut off on a usual screen.

    python docs/site_pictures.py FOLDER       needs the extra docs, playwright and Chromium

The site is built into the folder. Ends with 1 if a block of code is wider than its place at 1440
pixels.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

from playwright.sync_api import sync_playwright

ROOT = Path(__file__).resolve().parents[1]
PAGES = {
    "front": "index.html",
    "guide": "guides/production.html",
    "reference": "reference/motion.html",
    "chinese": "zh/tutorial.html",
}
WIDTHS = (1440, 390)
CUT_OFF = """() => [...document.querySelectorAll("pre > code")]
    .filter((code) => code.scrollWidth > code.clientWidth + 1)
    .map((code) => code.textContent.split("\\n").sort((a, b) => b.length - a.length)[0])"""


def main() -> int:
    """Build, draw, check."""
    folder = Path(sys.argv[1])
    site = folder / "site"
    subprocess.run(
        ["mkdocs", "build", "--quiet", "--strict", "-f", str(ROOT / "mkdocs.yml"), "-d", str(site)],
        check=True,
    )
    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    wrong = 0
    with sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        for width in WIDTHS:
            page = browser.new_page(viewport={"width": width, "height": 900})
            for name, path in PAGES.items():
                page.goto((site / path).as_uri())
                page.screenshot(path=folder / f"site-{name}-{width}.png")
                cut = page.evaluate(CUT_OFF) if width == WIDTHS[0] else []
                for line in cut:
                    sys.stdout.write(f"{path}: cut off: {line}\n")
                wrong += len(cut)
        browser.close()
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
