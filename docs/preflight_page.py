"""Make the picture of `docs/preflight.md`: a report of a planted fault, in headless Chromium.

    python docs/preflight_page.py

Needs Debian's chromium, and the extras sim and plot.
"""

from __future__ import annotations

import subprocess
import tempfile
from pathlib import Path

from PIL import Image

from aioduco.preflight import PreflightSettings, preflight
from aioduco.preflight.html import page
from aioduco.sim.scene import Box

HERE = Path(__file__).resolve().parent
PROGRAM = HERE.parent / "tests/preflight/programs/scene_collision.py"
CELL = [Box(at=(0.35, 0.35, 0.4), size=(0.2, 0.2, 0.8), colour=(0.8, 0.3, 0.2), name="box")]


def main() -> None:
    """Write `docs/images/preflight.png`."""
    report = preflight(PROGRAM, (), PreflightSettings(scene=CELL), quiet=True)
    with tempfile.TemporaryDirectory() as folder:
        html, shot = Path(folder) / "page.html", Path(folder) / "page.png"
        text = page(report).replace(str(PROGRAM), PROGRAM.name)
        html.write_text(text, encoding="utf-8")
        subprocess.run(
            [
                *("chromium", "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars"),
                *("--disable-background-networking", f"--user-data-dir={folder}/profile"),
                *("--window-size=1020,1240", f"--screenshot={shot}", html.as_uri()),
            ],
            check=True,
            capture_output=True,
            timeout=120,
        )
        picture = Image.open(shot).resize((765, 930)).quantize(128)
        picture.save(HERE / "images/preflight.png", optimize=True)


if __name__ == "__main__":
    main()
