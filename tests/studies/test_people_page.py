"""Three participants at once in real browsers: one loads the page again, one loses the network, one has a phone."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
import pytest_asyncio

from rcss_hat.studies.address import Address
from rcss_hat.studies.folder import StudyFolder
from rcss_hat.studies.people_file import load_people
from rcss_hat.studies.server import StudyServer

from .conftest import SMALL
from .serving import people_of, whole

if TYPE_CHECKING:
    from playwright.async_api import Browser, Page

Error = pytest.importorskip("playwright.async_api", reason="the page is tested through playwright").Error
pytestmark = [pytest.mark.asyncio(loop_scope="module"), pytest.mark.compiled, pytest.mark.slow]
PATIENCE = 90_000
"""Milliseconds for anything to appear."""
PHONE = {"viewport": {"width": 375, "height": 667}, "has_touch": True, "is_mobile": True}


@pytest_asyncio.fixture(loop_scope="module", scope="module")
async def server(tmp_path_factory: pytest.TempPathFactory) -> AsyncIterator[StudyServer]:
    folder = StudyFolder.begin(tmp_path_factory.mktemp("people") / "small", load_people(str(SMALL)), rehearsal=True)
    async with StudyServer(folder, Address(), 1, print, hurry=4.0) as server:
        yield server


async def opened(chromium: Browser, url: str, complaints: list[str], **options: Any) -> Page:
    context = await chromium.new_context(**options)
    context.set_default_timeout(PATIENCE)
    page = await context.new_page()
    page.on("pageerror", lambda error: complaints.append(str(error)))
    await page.goto(url)
    return page


async def seen(page: Page, expression: str) -> None:
    """Wait until something is so on a page, whose policy forbids to look for it by itself."""
    async with asyncio.timeout(PATIENCE / 1000):
        while not await page.evaluate(expression):
            await asyncio.sleep(0.1)


async def free_of_faults(page: Page) -> None:
    """Check that axe finds nothing."""
    from axe_playwright_python.async_playwright import Axe

    found = await Axe().run(page)
    assert found.violations_count == 0, found.generate_report()


async def consent(page: Page, language: str | None = None) -> None:
    if language:
        await page.get_by_role("button", name=language).click()
        await page.wait_for_selector("html[lang=de]")
    await free_of_faults(page)
    await page.get_by_role("checkbox").check()
    await page.locator("button.go").click()


async def begin_game(page: Page) -> None:
    """Press the start key of a game's page."""
    await page.wait_for_selector("#start:visible")
    await page.locator("#start").click()


async def play(page: Page, key: str | None = "1") -> None:
    """Press a key, or tap, until the games of this step are over and another page is there."""
    while await playing(page):
        with suppress(Error):  # the page goes away when the last game is over
            if await page.locator("#question[open]").count():  # games this fast can be over before a key comes
                await page.locator("#question button").click(timeout=1000)
            elif key is None:
                await page.locator("#passes button").nth(1).tap(timeout=1000)
            else:
                await page.keyboard.press(key)
        await asyncio.sleep(0.15)


async def playing(page: Page) -> bool:
    """Whether this is a game's page, and the game has begun."""
    try:
        return bool(
            await page.evaluate(
                "document.getElementById('game') !== null && !document.querySelector('#start')?.offsetParent"
            )
        )
    except Error:
        return True  # between two pages


async def answer(page: Page) -> None:
    """Answer all questions of a page: the last option of every choice."""
    await page.wait_for_selector("#step")
    await free_of_faults(page)
    for field in await page.locator("fieldset").all():
        await field.locator("input").last.check()
    await page.locator("button.go").click()


async def to_the_end(page: Page, key: str | None = "1") -> str:
    """Go from the first game to the end; returns the code."""
    while not await page.locator(".code strong").count():
        await page.wait_for_selector("#start:visible, #step, .code strong, #game:visible")
        if await page.locator("#start:visible").count():
            await begin_game(page)
            await play(page, key)
        elif await page.locator("#step").count():
            await answer(page)
            await page.wait_for_load_state()
        elif await page.locator("#game:visible").count():  # it has begun before the page was loaded again
            await play(page, key)
    return str(await page.locator(".code strong").inner_text())


async def test_three_participants_at_once(server: StudyServer, chromium: Browser) -> None:
    complaints: list[str] = []

    async def with_a_reload() -> str:
        page = await opened(chromium, server.link(1), complaints)
        await consent(page)
        await begin_game(page)
        await page.keyboard.press("1")
        await seen(page, "document.getElementById('duration').textContent > '1.0'")
        await page.reload()
        return await to_the_end(page)

    async def with_a_break() -> str:
        page = await opened(chromium, server.link(2), complaints)
        await consent(page, "Deutsch")
        await begin_game(page)
        await page.context.set_offline(True)
        for open_page in list(server._sockets.values()):  # the machine's own network does not break: cut it here
            if open_page.number in server.participants[2]._pages:
                await open_page.close(1011)
        await asyncio.sleep(1.0)
        await page.context.set_offline(False)
        return await to_the_end(page, "2")

    async def on_a_phone() -> str:
        page = await opened(chromium, server.link(3), complaints, **PHONE)
        assert await page.evaluate("document.documentElement.scrollWidth <= innerWidth")
        await consent(page)
        return await to_the_end(page, None)

    codes = await asyncio.gather(with_a_reload(), with_a_break(), on_a_phone())
    assert complaints == []
    kept = people_of(server.folder.path)
    for place, code in enumerate(codes, 1):
        mine = kept[f"p00{place}"]
        whole(mine)
        assert mine.about["code"] == code
        assert mine.progress.answers["about"]["often"] == "often"
        assert sum(e["event"] == "match" for e in mine.events) == 2  # none was played anew
    assert len({k.about["conditions"][0] for k in kept.values()}) == 3
    assert kept["p002"].progress.language == "de"
    opened_pages = [e for e in kept["p001"].events if e["event"] == "page" and e["state"] == "opened"]
    assert len(opened_pages) == 3  # practice twice, for the reload


async def test_the_other_pages_have_no_faults(server: StudyServer, chromium: Browser) -> None:
    for url in (server.lab_link, server.open_link, server.url + "p/nobody/"):
        for scheme in ("light", "dark"):
            page = await opened(chromium, url, [], color_scheme=scheme)
            if url == server.lab_link:
                await seen(page, "document.querySelectorAll('#places tbody tr').length === 12")
            await free_of_faults(page)
            await page.context.close()


async def test_answers_survive_a_reload_and_a_server_that_is_away(
    server: StudyServer,
    chromium: Browser,
    tmp_path: Path,
) -> None:
    page = await opened(chromium, server.link(4), [])
    await page.get_by_role("checkbox").check()
    await page.reload()
    assert await page.get_by_role("checkbox").is_checked()
    await page.context.set_offline(True)
    await page.locator("button.go").click()
    await seen(page, "document.getElementById('connection').textContent.length > 0")
    assert server.participants[4].progress.current.name == "consent"
    await page.context.set_offline(False)
    await page.wait_for_selector("#start:visible")
    assert server.participants[4].progress.current.name == "practice"
