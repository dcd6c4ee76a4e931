"""A person who looks away, comes late, changes browsers, and leaves: the demonstration's page in a real browser."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from pathlib import Path
from typing import Any

import pytest
import pytest_asyncio

from rcss_hat.hat.demonstration_writer import DemonstrationWriter
from rcss_hat.hat.demonstrations import DemonstrationInfo, DemonstrationSet
from rcss_hat.keepaway.report import OUT, Episode
from rcss_hat.viewer import room
from rcss_hat.viewer.controls import KeyChannel
from rcss_hat.viewer.demonstrator import Demonstrator
from rcss_hat.viewer.narrator import make_frame
from rcss_hat.viewer.server import Viewer, serve
from rcss_hat.viewer.stage_game import StageGame

from .audience import FIELD, SETUP, Stage, end, nobody_decides, played_by, snapshot
from .audience import until as until_here
from .conftest import OpenPage
from .test_page import until

pytestmark = pytest.mark.asyncio(loop_scope="module")

Play = Callable[..., Any]
# Headless pages all believe to be in front: hide one by saying so to it.
HIDE = """(hidden) => {
  Object.defineProperty(document, "hidden", { configurable: true, value: hidden });
  document.dispatchEvent(new Event("visibilitychange"));
}"""
FOCUS = """(focused) => {
  document.hasFocus = () => focused;
  window.dispatchEvent(new Event(focused ? "focus" : "blur"));
}"""


class Game:
    """A match of the arena that a person plays, at five times real time."""

    def __init__(self, path: Path, episodes: int | None = None) -> None:
        self.writer = DemonstrationWriter(path, DemonstrationInfo("person", "arena"))
        self.demonstration = Demonstrator(KeyChannel(), self.writer, episodes)
        self.source = StageGame(played_by(self.demonstration, 3), self.demonstration, 5.0)

    @property
    def cycle(self) -> int:
        return self.source.stage.cycle

    async def stands(self) -> None:
        """Wait until the game stands still, and see that it does."""
        async with asyncio.timeout(30.0):
            while True:
                before = self.cycle
                await asyncio.sleep(0.2)
                if self.cycle == before:
                    break

    async def runs(self) -> None:
        """Wait until the game goes on."""
        before = self.cycle
        await until_here(lambda: self.cycle > before, 60.0)


@pytest_asyncio.fixture(loop_scope="module")
async def game(tmp_path: Path) -> Game:
    return Game(tmp_path / "demo.csv")


@pytest_asyncio.fixture(loop_scope="module")
async def arena(game: Game) -> AsyncIterator[Viewer]:
    async with await serve(game.source, game.demonstration, open_browser=False) as viewer:
        yield viewer


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


async def ready(page: Any, stage: Stage | None = None, cycle: int = 1) -> None:
    """Wait until the page can be played on."""
    await until(
        page, "viewer.status && viewer.setup && document.querySelectorAll('#passes button').length === 3", 300.0
    )
    if stage is not None:
        stage.show(cycle)
        await until(page, f"viewer.frame?.time === {cycle}")


# -- nobody looks -----------------------------------------------------------------------------------------------------
async def test_the_game_stands_still_behind_a_dialog(arena: Viewer, game: Game, open_page: OpenPage) -> None:
    page = await open_page(arena.url)
    await ready(page)
    await game.runs()
    for key in ("?", "f"):
        await page.keyboard.press(key)
        await game.stands()
        await page.keyboard.press("Escape")
        await game.runs()
    assert not game.demonstration.finished


@pytest.mark.parametrize("way", [HIDE, FOCUS])
async def test_the_game_stands_still_when_the_page_is_not_seen(
    arena: Viewer, game: Game, open_page: OpenPage, way: str
) -> None:
    page = await open_page(arena.url)
    await ready(page)
    await game.runs()
    assert not await page.is_visible("#standstill")
    away, back = (True, False) if way is HIDE else (False, True)
    await page.evaluate(way, away)
    await game.stands()
    await until(page, "!document.getElementById('standstill').hidden")
    assert "The game stands still" in await page.inner_text("#standstill")
    await page.evaluate(way, back)
    await game.runs()
    await until(page, "document.getElementById('standstill').hidden")


async def test_a_page_behind_another_tab_stands_still(arena: Viewer, game: Game, open_page: OpenPage) -> None:
    """A real other tab, without Playwright's pretence that every page is in front."""
    page = await open_page(arena.url)
    await ready(page)
    await game.runs()
    session = await page.context.new_cdp_session(page)
    await session.send("Emulation.setFocusEmulationEnabled", {"enabled": False})
    other = await page.context.new_page()
    await other.bring_to_front()
    await game.stands()
    await page.bring_to_front()
    await session.send("Emulation.setFocusEmulationEnabled", {"enabled": True})
    await game.runs()
    await other.close()


async def test_standing_still_costs_no_episode(arena: Viewer, game: Game, open_page: OpenPage) -> None:
    page = await open_page(arena.url)
    await ready(page)
    await game.runs()
    await page.keyboard.press("?")
    await game.stands()
    await page.keyboard.press("Escape")
    await until_here(lambda: game.demonstration.kept > 0, 10.0)
    assert game.demonstration.dropped == 0 and arena.room._episodes[0]["number"] == 1


async def test_without_a_key_for_long_the_page_asks_and_waits(arena: Viewer, game: Game, open_page: OpenPage) -> None:
    page = await open_page(arena.url)
    await ready(page)
    await until(page, "document.getElementById('question').open", 30.0)
    await game.stands()
    idle = game.demonstration.kept
    assert idle > 1 and not game.writer.entries, "what nobody demonstrated waits"
    await page.keyboard.press("Enter")
    await until(page, "!document.getElementById('question').open")
    await game.runs()
    await page.keyboard.press("1")
    await until_here(lambda: len(game.writer.entries) >= idle, 20.0)
    game.demonstration.close()
    recorded = DemonstrationSet.load(game.writer.table)
    assert [d.idle for d in recorded][:idle] == [True] * idle
    assert all(d.actions.max() == 0 for d in recorded if d.idle)


async def test_escape_answers_the_question_too(
    viewer: Viewer, stage: Stage, open_page: OpenPage, demonstration: Demonstrator
) -> None:
    page = await open_page(viewer.url)
    await ready(page, stage)
    nobody_decides(demonstration)
    assert demonstration.asking and demonstration.standing
    stage.show(2)
    await until(page, "document.getElementById('question').open")
    await page.keyboard.press("Escape")
    await until_here(lambda: not demonstration.standing)


# -- the seat ---------------------------------------------------------------------------------------------------------
async def test_a_second_browser_takes_over_when_the_first_is_gone(
    viewer: Viewer, stage: Stage, open_page: OpenPage, demonstration: Demonstrator, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(room, "SEAT_KEPT", 0.3)
    first, second = await open_page(viewer.url), None
    await ready(first, stage)
    second = await open_page(viewer.url)
    await until(second, "!document.getElementById('seat').hidden")
    assert "Another page plays" in await second.inner_text("#seat")
    assert not await second.is_visible("#take-seat") and not await second.is_visible("#play")
    await second.evaluate("viewer.send({ type: 'seat' })")  # not even when its page is tampered with
    await until(second, "document.getElementById('banner').textContent.includes('Another page plays')")
    await first.close()
    await until(second, "document.getElementById('seat-text').textContent.startsWith('Nobody plays')")
    assert demonstration.standing
    await second.click("#take-seat")
    await until(second, "!document.getElementById('play').hidden")
    assert await second.inner_text("#connection") == "connected" and not await second.is_visible("#seat")
    assert not demonstration.standing
    await second.keyboard.press("2")
    await until_here(lambda: demonstration.keys.pending)


async def test_a_browser_that_is_left_in_the_background_can_be_replaced(
    viewer: Viewer, stage: Stage, open_page: OpenPage, demonstration: Demonstrator
) -> None:
    first = await open_page(viewer.url)
    await ready(first, stage)
    second = await open_page(viewer.url)
    await first.evaluate(HIDE, True)
    await until(second, "!document.getElementById('take-seat').hidden")
    assert "nobody looks at it" in await second.inner_text("#seat")
    await second.click("#take-seat")
    await until(first, "viewer.role === 'watcher'")
    assert await first.is_visible("#seat") and not await first.is_visible("#play")
    await first.keyboard.press("1")
    await second.keyboard.press("2")
    await until_here(lambda: demonstration.keys.pending)
    assert demonstration.keys.pending is not None and demonstration.keys.pending.action == 2


async def test_loading_the_page_again_keeps_the_seat(viewer: Viewer, stage: Stage, open_page: OpenPage) -> None:
    first = await open_page(viewer.url)
    await ready(first, stage)
    second = await open_page(viewer.url)
    await until(second, "viewer.seat === 'taken'")
    await first.reload()
    await until(first, "typeof viewer !== 'undefined' && viewer.role === 'player'")
    assert await second.evaluate("viewer.role") == "watcher"


# -- the end ----------------------------------------------------------------------------------------------------------
async def test_the_end_is_quiet_and_says_what_to_do_next(stage: Stage, open_page: OpenPage, tmp_path: Path) -> None:
    path = tmp_path / "my demo.csv"
    demonstration = Demonstrator(KeyChannel(), DemonstrationWriter(path, DemonstrationInfo("person", "arena")), 1)
    viewer = await serve(stage, demonstration, open_browser=False)
    page = await open_page(viewer.url)
    watcher = await open_page(viewer.url)
    await ready(page, stage)
    end(viewer.room, Episode(1, 0, 40, OUT))
    assert demonstration.finished
    await viewer.close()
    demonstration.close()
    await until(page, "document.getElementById('farewell').open")
    text = await page.inner_text("#farewell")
    for part in ("Thank you!", "1 game is recorded", str(path), f"rcss-hat summarize '{path}' --out rules.json"):
        assert part in text
    await until(watcher, "document.getElementById('farewell').open")
    await page.keyboard.press("Enter")
    assert not await page.is_visible("#farewell")
    await asyncio.sleep(1.2)  # longer than a page that lost its viewer waits before it tries again
    for one in (page, watcher):
        assert await one.inner_text("#connection") == "finished"
        assert await one.get_attribute("#connection", "data-state") == "over"
    assert len(DemonstrationSet.load(path)) == 1


async def test_stopping_early_says_so(stage: Stage, open_page: OpenPage, demonstration: Demonstrator) -> None:
    viewer = await serve(stage, demonstration, open_browser=False)
    page = await open_page(viewer.url)
    await ready(page, stage)
    await viewer.close()
    await until(page, "document.getElementById('farewell').open")
    text = await page.inner_text("#farewell")
    assert "The games are over" in text and "Nothing was recorded" in text and "summarize" not in text


# -- keys -------------------------------------------------------------------------------------------------------------
async def test_a_key_that_means_nothing_here_is_answered_in_words(
    viewer: Viewer, stage: Stage, open_page: OpenPage, demonstration: Demonstrator
) -> None:
    page = await open_page(viewer.url)
    await ready(page, stage)
    await page.keyboard.press("3")
    assert await page.inner_text("#banner") == "There is no 3 here: 1 or 2 passes, 0 holds."
    await page.evaluate("viewer.send({ type: 'press', value: 9 })")
    await until(page, "document.getElementById('banner').textContent.startsWith('There is no ? here: 1 or 2')")
    assert demonstration.keys.presses == 0


async def test_a_key_that_came_too_late_is_shown_as_lapsed(
    viewer: Viewer, stage: Stage, open_page: OpenPage, demonstration: Demonstrator
) -> None:
    page = await open_page(viewer.url)
    await ready(page, stage)
    await page.keyboard.press("1")
    await until_here(lambda: demonstration.keys.pending)
    stage.show(2)
    await until(page, "document.querySelector('#passes .pending')?.dataset.action === '1'")
    taker_has_it = snapshot(3, (-5.2, 0.0), **FIELD)
    stage.audience.frame(make_frame(taker_has_it, SETUP, 1, 0))  # type: ignore[union-attr]
    await until(page, "document.querySelector('#passes .lapsed')?.dataset.action === '1'")
    assert await page.inner_text("#banner") == "Too late: the pass to 1 was not played."
    assert await page.evaluate("document.querySelectorAll('#passes .pending, #passes .done').length") == 0
    stage.show(20)
    await until(page, "document.querySelectorAll('#passes .lapsed').length === 0")


async def test_space_presses_the_button_that_was_reached_by_tab(
    viewer: Viewer, stage: Stage, open_page: OpenPage, demonstration: Demonstrator
) -> None:
    page = await open_page(viewer.url)
    await ready(page, stage)
    await page.focus("#finish")
    await page.keyboard.press(" ")
    assert await page.is_visible("#confirm")
    await page.keyboard.press("Escape")
    await page.focus("#passes button[data-action='2']")
    await page.keyboard.press(" ")
    await until_here(lambda: demonstration.keys.pending)
    assert demonstration.keys.pending is not None and demonstration.keys.pending.action == 2
    # After a click, Space is the game's again: it takes back what was asked for.
    await page.click("#drop")
    await until_here(lambda: demonstration.status()["dropping"])
    await page.keyboard.press(" ")
    await until_here(lambda: demonstration.keys.pending is None)
    assert demonstration.status()["dropping"]
