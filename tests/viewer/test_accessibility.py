"""The page as axe-core sees it: names and contrasts, in light and dark, in every state that people meet.

The axe-core is that of axe-playwright-python, or the ``axe.min.js`` that ``$AXE`` names.
"""

from __future__ import annotations

import asyncio
import os
from collections.abc import AsyncIterator
from importlib import resources
from pathlib import Path
from typing import Any

import pytest
import pytest_asyncio

from rcss_hat.keepaway.report import OUT, Episode
from rcss_hat.viewer.controls import KeyChannel
from rcss_hat.viewer.demonstrator import Demonstrator
from rcss_hat.viewer.narrator import make_frame
from rcss_hat.viewer.playback import Playback
from rcss_hat.viewer.recording import read_recording
from rcss_hat.viewer.server import Viewer, serve

from .audience import DATA, FIELD, SETUP, Stage, end, nobody_decides, snapshot
from .audience import until as until_here
from .conftest import OpenPage
from .test_page import until

pytestmark = pytest.mark.asyncio(loop_scope="module")

RUN = """async () => {
  const found = await axe.run(document, { resultTypes: ["violations"] });
  const node = (n) => `${n.target.join(" ")} (${[...n.any, ...n.all, ...n.none].map((a) => a.message).join(", ")})`;
  return found.violations.map((v) => `${v.id}, ${v.impact}: ${v.nodes.map(node).join("; ")}`);
}"""


@pytest.fixture(scope="module")
def axe() -> str:
    if named := os.environ.get("AXE"):
        return Path(named).read_text()
    package = pytest.importorskip("axe_playwright_python", reason="names and contrasts are checked by axe-core")
    return (resources.files(package) / "axe.min.js").read_text()


@pytest_asyncio.fixture(loop_scope="module")
async def stage() -> Stage:
    return Stage()


@pytest_asyncio.fixture(loop_scope="module")
async def demonstration() -> Demonstrator:
    return Demonstrator(KeyChannel(), None, 20)


@pytest_asyncio.fixture(loop_scope="module")
async def viewer(stage: Stage, demonstration: Demonstrator) -> AsyncIterator[Viewer]:
    async with await serve(stage, demonstration, open_browser=False) as viewer:
        await until_here(lambda: stage.audience)
        yield viewer


async def violations(page: Any) -> list[str]:
    """What axe finds in both colour schemes."""
    found: list[str] = []
    for scheme in ("light", "dark"):
        await page.emulate_media(color_scheme=scheme, reduced_motion="reduce")
        await until(page, f"document.documentElement.dataset.theme === '{scheme}'")
        await asyncio.sleep(0.1)  # colours are set; let the page paint
        found += [f"{scheme}: {violation}" for violation in await page.evaluate(RUN)]
    return found


@pytest.mark.parametrize("width", [390, 1280])
async def test_playing_has_names_and_contrasts(
    viewer: Viewer, stage: Stage, demonstration: Demonstrator, open_page: OpenPage, axe: str, width: int
) -> None:
    page = await open_page(viewer.url, width, 844)
    await page.evaluate(axe)
    await until(page, "document.querySelectorAll('#passes button').length === 3")
    stage.show(1)
    await until(page, "viewer.frame")
    assert await violations(page) == []
    await page.click("#details-button")
    end(viewer.room, Episode(1, 0, 30, OUT))
    viewer.room.notice("Begins in 3 ...")
    viewer.room.frame(make_frame(snapshot(2, (2.0, 1.0), **FIELD), SETUP, 2, 30))
    await until(page, "document.getElementById('mind').classList.contains('loose')")
    for command in ("pause", "drop", "drop_last"):
        await page.evaluate(f"viewer.record('{command}')")
    await until(page, "document.querySelectorAll('[aria-pressed=true]').length === 3")
    assert await violations(page) == []
    demonstration.keys.press(1)
    for cycle in (3, 40):
        viewer.room.frame(make_frame(snapshot(cycle, (2.0, 1.0), **FIELD), SETUP, 2, 30))
    await until(page, "document.querySelector('#passes .lapsed')")
    assert await violations(page) == []


async def test_dialogs_have_names_and_contrasts(
    stage: Stage, demonstration: Demonstrator, open_page: OpenPage, axe: str
) -> None:
    viewer = await serve(stage, demonstration, open_browser=False)
    page = await open_page(viewer.url)
    await page.evaluate(axe)
    await until(page, "document.querySelectorAll('#passes button').length === 3")
    stage.show(1)
    for key in ("?", "f"):
        await page.keyboard.press(key)
        assert await violations(page) == []
        await page.keyboard.press("Escape")
    await until_here(lambda: not demonstration.standing)
    nobody_decides(demonstration)
    stage.show(2)
    await until(page, "document.getElementById('question').open")
    assert await violations(page) == []
    await viewer.close()
    await until(page, "document.getElementById('farewell').open")
    await page.evaluate("document.getElementById('farewell-next').hidden = false")
    assert await violations(page) == []


async def test_watching_has_names_and_contrasts(viewer: Viewer, stage: Stage, open_page: OpenPage, axe: str) -> None:
    first, page = await open_page(viewer.url), await open_page(viewer.url)
    await page.evaluate(axe)
    stage.show(1)
    await until(page, "viewer.frame && !document.getElementById('seat').hidden")
    assert await violations(page) == []
    await first.close()
    await until(page, "!document.getElementById('take-seat').hidden && !document.getElementById('standstill').hidden")
    assert await violations(page) == []


async def test_playback_has_names_and_contrasts(open_page: OpenPage, axe: str) -> None:
    async with await serve(Playback(read_recording(DATA / "sample-v5.rcg.gz")), open_browser=False) as viewer:
        page = await open_page(viewer.url)
        await page.evaluate(axe)
        await until(page, "viewer.history.bars.length === 8")
        assert await violations(page) == []
        await page.close()
