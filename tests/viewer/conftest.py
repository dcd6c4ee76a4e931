"""A real browser for the tests of the page: headless Chromium, driven by Playwright."""

from __future__ import annotations

import asyncio
import os
import shutil
from collections.abc import AsyncIterator, Awaitable, Callable
from typing import TYPE_CHECKING, Any

import pytest
import pytest_asyncio

if TYPE_CHECKING:
    from playwright.async_api import Browser, Page

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
FLAGS = [
    "--no-sandbox",
    "--disable-gpu",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]
# Headless pages of several windows must not be slowed down because another one is in front.
FLAGS += ["--disable-renderer-backgrounding", "--disable-background-timer-throttling"]

OpenPage = Callable[..., Awaitable["Page"]]


def find_chromium() -> str | None:
    """Path of a Chromium: ``$CHROMIUM``, or the first one on the PATH."""
    named = os.environ.get("CHROMIUM")
    return shutil.which(named) if named else next(filter(None, map(shutil.which, NAMES)), None)


@pytest_asyncio.fixture(loop_scope="module", scope="module")
async def chromium() -> AsyncIterator[Browser]:
    """One browser for all tests of a module; skips them where there is none."""
    playwright = pytest.importorskip("playwright.async_api", reason="the page is tested through playwright")
    executable = find_chromium()
    if executable is None:
        pytest.skip("found no Chromium to test the page in: install chromium, or set CHROMIUM to its path")
    async with playwright.async_playwright() as driver:
        browser = await driver.chromium.launch(executable_path=executable, args=FLAGS)
        yield browser
        await browser.close()


@pytest_asyncio.fixture(loop_scope="module")
async def open_page(chromium: Browser) -> AsyncIterator[OpenPage]:
    """Open pages in windows of their own; whatever a page complains of fails the test."""
    contexts: list[Any] = []
    complaints: list[str] = []

    async def open_page(url: str, width: int = 1280, height: int = 860, **options: Any) -> Page:
        context = await chromium.new_context(viewport={"width": width, "height": height}, **options)
        contexts.append(context)
        page = await context.new_page()
        page.on("pageerror", lambda error: complaints.append(str(error)))
        page.on(
            "console", lambda message: complaints.append(message.text) if message.type in ("error", "warning") else None
        )
        page.on("request", lambda request: complaints.append(f"foreign request: {request.url}")
                if not request.url.startswith(url.partition("?")[0]) else None)  # fmt: skip
        await page.goto(url)
        async with asyncio.timeout(20.0):  # a page that plays has texts to load first
            while await page.evaluate("typeof viewer === 'undefined'"):
                await asyncio.sleep(0.01)
        return page

    yield open_page
    for context in contexts:
        await context.close()
    assert complaints == []
