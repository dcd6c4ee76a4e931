"""Taking turns with a learner, and correcting, in a real browser and a real game."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

import pytest
import pytest_asyncio

from rcss_hat.hat.demonstration_writer import DemonstrationWriter
from rcss_hat.hat.demonstrations import DemonstrationInfo, DemonstrationSet
from rcss_hat.hat.policy import load_policy
from rcss_hat.viewer.controls import KeyChannel
from rcss_hat.viewer.demonstrator import Demonstrator, Terms
from rcss_hat.viewer.room import Manner
from rcss_hat.viewer.server import Viewer, serve
from rcss_hat.viewer.stage_game import PEEK, StageGame
from rcss_hat.viewer.turns import Companion

from .audience import played_by
from .audience import until as until_here
from .conftest import OpenPage
from .test_accessibility import axe as axe
from .test_accessibility import violations
from .test_page import until

pytestmark = pytest.mark.asyncio(loop_scope="module")


@pytest_asyncio.fixture(loop_scope="module")
async def demonstration(tmp_path: Path) -> Demonstrator:
    writer = DemonstrationWriter(tmp_path / "x.csv", DemonstrationInfo("person", "arena", marked=True))
    learner = Companion(load_policy("hold", 3, 2, 1))
    return Demonstrator(KeyChannel(), writer, Terms(2, start=True, speed=5.0, correct=True), learner)


@pytest_asyncio.fixture(loop_scope="module")
async def viewer(demonstration: Demonstrator) -> AsyncIterator[Viewer]:
    game = StageGame(played_by(demonstration, 3), demonstration, 5.0)
    async with await serve(game, demonstration, open_browser=False, manner=Manner(plain=True)) as viewer:
        yield viewer


async def test_a_person_takes_over_gives_back_and_corrects(
    viewer: Viewer, demonstration: Demonstrator, open_page: OpenPage, axe: str
) -> None:
    game: Any = viewer.room.source
    game.countdown = 10_000  # until whose turn it is has been tried
    page: Any = await open_page(viewer.url, 1280, 800)
    await page.evaluate(axe)
    await until(page, "document.getElementById('intro').open", 120.0)
    assert "The computer plays. Any key of yours takes over" in await page.inner_text("#intro")
    await page.keyboard.press("Enter")
    await until(page, "viewer.frame && viewer.status.started")
    assert "The computer plays." in await page.inner_text("#turns")
    await page.keyboard.press("Enter")
    await until(page, "viewer.status.by === 'person'")
    assert "You play." in await page.inner_text("#turns")
    await page.keyboard.press("Enter")
    await until(page, "viewer.status.by === 'learner'")
    await page.keyboard.press("1")
    await until(page, "viewer.status.by === 'person'")
    await page.keyboard.press("Enter")
    await until(page, "viewer.status.by === 'learner'")
    game.countdown = 0
    await page.keyboard.press("?")
    await until_here(lambda: not demonstration.looking)
    await asyncio.sleep(2 * PEEK)  # by then the game has seen it, too, and counts anew
    await page.keyboard.press("Escape")
    await until(page, "viewer.replay.shown", 30.0)
    assert await page.is_visible("#replay") and not await page.is_visible("#play")
    assert demonstration.standing
    assert await violations(page) == []
    # To the first decision, by keys: what was chosen is told, another is called right.
    await page.keyboard.press("Home")
    await page.keyboard.press("ArrowRight")
    await until(page, "viewer.replay.decision")
    first = await page.evaluate("viewer.replay.decision.cycle")
    await page.keyboard.press("2")
    await until_here(lambda: demonstration._looked_at[first]["right"] == 2)
    assert "Right would have been Pass 2. 1 moment corrected." in await page.inner_text("#moment-text")
    await page.reload()
    await until(page, "typeof viewer !== 'undefined' && viewer.replay.shown")
    await until(page, f"viewer.replay.decisions.get({first}).right === 2")
    # Taken back, and said of the next decision, by the mouse.
    await page.keyboard.press("Home")
    await page.click("#moment-after")
    await page.click("#rights button[data-action='2']")
    await until_here(lambda: demonstration._looked_at[first]["right"] is None)
    await page.click("#moment-after")
    second = await page.evaluate("viewer.replay.decision.cycle")
    assert second > first
    await page.click("#rights button[data-action='1']")
    # "It was right" is no correction where it is what was played.
    await page.click("#moment-play")
    await until(page, "viewer.replay.position > 3")
    await page.click("#replay-done")
    await until(page, "!viewer.replay.shown && !viewer.status.standing")
    assert await page.is_visible("#play") and not await page.is_visible("#replay")
    await until(page, "viewer.replay.shown", 30.0)
    await page.keyboard.press("Enter")
    await until_here(lambda: demonstration.finished)
    await asyncio.sleep(0)
    demonstration.close()
    assert demonstration.recorder is not None
    taught = DemonstrationSet.load(demonstration.recorder.table)
    assert len(taught) == 2 and set(taught.episodes[0].by) == {"learner"}
    said = {d.cycle: d.right for d in taught.episodes[0].decisions if d.right is not None}
    own = dict(zip(taught.episodes[0].cycles.tolist(), taught.episodes[0].actions.tolist(), strict=True))
    assert said == {second: 1} and own[second] == 0


async def test_looking_again_fits_a_phone(viewer: Viewer, open_page: OpenPage, axe: str) -> None:
    page: Any = await open_page(viewer.url, 390, 844, has_touch=True, is_mobile=True, locale="de")
    await page.evaluate(axe)
    await until(page, "document.getElementById('intro').open", 120.0)
    await page.tap("#start")
    await until(page, "viewer.replay.shown", 60.0)
    assert (
        await page.evaluate(
            """["#moment", "#moment-before", "#rights button", "#replay-done"].map((id) => {
          const box = document.querySelector(id).getBoundingClientRect();
          return box.bottom <= innerHeight && box.right <= innerWidth && box.width > 0;
        })"""
        )
        == [True] * 4
    )
    assert "Der Computer wählte".lower() in (await page.inner_text("#moment-text")).lower()
    assert await violations(page) == []
