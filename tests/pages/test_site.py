"""The built pages as a reader opens them: as files, in a browser that reaches no network."""

from __future__ import annotations

import importlib.util
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from playwright.sync_api import Route

ROOT = Path(__file__).parents[2]
CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")


#: of the pages, those that are opened: to build all of them takes ten seconds of a processor more
OPENED = ("index", "reference/errors", "reference/settings")
#: words, and where each is found: the second stands in brackets there
WORDS = {"HeartbeatLost": "reference/errors.html", "碰撞检测等级": "reference/settings.html"}


@pytest.fixture
def site(tmp_path: Path) -> Path:
    """The pages: those that the gate has built, or some that are built now."""
    built = os.environ.get("AIODUCO_SITE")
    if built:
        return Path(built)
    if importlib.util.find_spec("mkdocs") is None:
        pytest.skip("needs the extra docs")
    (tmp_path / "docs/reference").mkdir(parents=True)
    shutil.copytree(ROOT / "docs/assets", tmp_path / "docs/assets")
    for name in ("units.py", *(f"{page}.md" for page in OPENED)):
        shutil.copy(ROOT / "docs" / name, tmp_path / "docs" / name)
    (tmp_path / "aioduco").symlink_to(ROOT / "aioduco")
    # What it links to is not there.
    (tmp_path / "mkdocs.yml").write_text(f"INHERIT: {ROOT / 'mkdocs.yml'}\nstrict: false\n")
    command = [sys.executable, "-m", "mkdocs", "build", "-q"]
    subprocess.run(
        command, cwd=tmp_path, check=True, env={**os.environ, "NO_MKDOCS_2_WARNING": "1"}
    )
    return tmp_path / "site"


@pytest.mark.slow
@pytest.mark.skipif(CHROMIUM is None, reason="needs chromium")
def test_the_search_finds_words_and_asks_the_network_for_nothing(site: Path) -> None:
    from playwright.sync_api import sync_playwright  # noqa: PLC0415 - slow to load

    asked: list[str] = []
    errors: list[str] = []

    def refused(route: Route) -> None:
        if route.request.url.startswith(("file:", "data:")):
            route.continue_()
        else:
            asked.append(route.request.url)
            route.abort()

    with sync_playwright() as driver:
        chromium = driver.chromium.launch(executable_path=CHROMIUM, args=["--no-sandbox"])
        for page in OPENED:
            opened = chromium.new_page()
            opened.on("pageerror", lambda error: errors.append(str(error)))
            opened.route("**/*", refused)
            opened.goto((site / f"{page}.html").as_uri())
            for word, place in WORDS.items():
                opened.locator("input[name=query]").fill(word)
                # the page takes in what is there when a key is released
                opened.locator("input[name=query]").press("Shift")
                found = opened.locator(f".md-search-result__link[href*='{place}']").first
                found.wait_for(state="attached")
        chromium.close()
    assert (asked, errors) == ([], [])
