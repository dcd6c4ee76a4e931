"""The page in a real browser: what people see, and what they can do with a keyboard, a mouse and a finger."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from typing import Any

import pytest
import pytest_asyncio
from aiohttp import web

from rcss_hat.keepaway.report import OUT, Episode
from rcss_hat.viewer.playback import Playback
from rcss_hat.viewer.recording import read_recording
from rcss_hat.viewer.server import Viewer, serve

from .audience import DATA
from .conftest import OpenPage

pytestmark = pytest.mark.asyncio(loop_scope="module")

# Counts, in the page, how often the picture of the canvas changed within some seconds.
COUNT_PICTURES = """async (seconds) => {
  const pitch = document.getElementById("pitch"), small = new OffscreenCanvas(160, 160);
  const context = small.getContext("2d", { willReadFrequently: true });
  let last = "", changes = 0;
  const end = performance.now() + 1000 * seconds, frames = viewer.frames;
  while (performance.now() < end) {
    await new Promise(requestAnimationFrame);
    context.drawImage(pitch, 0, 0, 160, 160);
    const picture = context.getImageData(0, 0, 160, 160).data.join();
    if (picture !== last) changes += 1;
    last = picture;
  }
  return { changes, frames: viewer.frames - frames };
}"""


async def until(page: Any, condition: str, seconds: float = 8.0) -> Any:
    """Wait until something is so in the page, whose security policy forbids Playwright's own way of waiting."""
    async with asyncio.timeout(seconds):
        while not (value := await page.evaluate(condition)):
            await asyncio.sleep(0.02)
    return value


@pytest_asyncio.fixture(loop_scope="module")
async def playback() -> Playback:
    return Playback(read_recording(DATA / "sample-v5.rcg.gz"))


@pytest_asyncio.fixture(loop_scope="module")
async def viewer(playback: Playback) -> AsyncIterator[Viewer]:
    async with await serve(playback, open_browser=False) as viewer:
        yield viewer


async def test_the_picture_moves_with_the_match(viewer: Viewer, open_page: OpenPage) -> None:
    page = await open_page(viewer.url)
    await until(page, "viewer.frames > 5")
    counted = await page.evaluate(COUNT_PICTURES, 2.0)
    assert counted["frames"] in range(15, 24)
    assert counted["changes"] >= 20
    assert await page.title() == "sample-v5.rcg.gz \u2013 rcss-hat"
    assert await page.evaluate("location.search") == ""


async def test_without_the_token_there_is_no_page(viewer: Viewer, chromium: Any) -> None:
    page = await chromium.new_page()
    response = await page.goto(viewer.url.partition("?")[0])
    assert response.status == 403
    assert "Open the link that rcss-hat printed" in await page.inner_text("body")
    await page.close()


async def test_the_page_of_another_site_cannot_connect(viewer: Viewer, open_page: OpenPage, chromium: Any) -> None:
    """Its requests carry the cookie, for ports do not count there; its Origin gives it away."""

    async def foreign(request: web.Request) -> web.Response:
        return web.Response(text="<!doctype html><title>foreign</title>", content_type="text/html")

    app = web.Application()
    app.router.add_get("/", foreign)
    runner = web.AppRunner(app)
    await runner.setup()
    await web.TCPSite(runner, "127.0.0.1", 0).start()
    ours = await open_page(viewer.url)
    await until(ours, "viewer.frames > 0")
    page = await ours.context.new_page()
    await page.goto(f"http://127.0.0.1:{runner.addresses[0][1]}/")
    connect = """(url) => new Promise((done) => {
      const socket = new WebSocket(url);
      socket.onopen = () => done("open");
      socket.onerror = () => done("refused");
    })"""
    address = viewer.url.partition("?")[0].replace("http", "ws") + "socket"
    assert await page.evaluate(connect, address) == "refused"
    assert await ours.evaluate(connect, address) == "open"
    await page.close()
    await runner.cleanup()


async def test_figures_beside_the_picture(viewer: Viewer, open_page: OpenPage, playback: Playback) -> None:
    playback.command("pause", 0)
    playback.command("cycle", 70)
    page = await open_page(viewer.url)
    await until(page, "viewer.frame?.time === 70")
    text = await page.inner_text("#facts")
    for part in (
        "Episode 4",
        "0.7",
        "play on",
        "70",
        "8 ended, mean 2.25 s; last 1.1 s, ball out",
        "From true positions",
    ):
        assert part in text
    rows = await page.evaluate("[...document.querySelectorAll('#state tr')].map((row) => row.innerText)")
    assert len(rows) == 13 and rows[0].startswith("0\tK1 to centre\t") and rows[12].endswith("\u00b0")
    label = await page.get_attribute("#history", "aria-label")
    assert label is not None and "mean 2.25 s" in label
    label = await page.get_attribute("#pitch", "aria-label")
    assert label is not None and label.startswith("Episode 4, ")


async def test_the_keyboard_alone_plays_a_recording(viewer: Viewer, open_page: OpenPage, playback: Playback) -> None:
    page = await open_page(viewer.url)
    await until(page, "viewer.frames > 3")
    press = page.keyboard.press

    async def at(cycle: int) -> None:
        await until(page, f"viewer.frame.time === {cycle} && !viewer.play.playing")

    await press(" ")
    await until(page, "document.getElementById('play-pause').textContent === 'Play'")
    assert not playback.playing
    await press("Home")
    await at(1)
    await press("ArrowRight")
    await at(2)
    await press("Shift+ArrowRight")
    await at(12)
    await press("ArrowLeft")
    await at(11)
    await press("]")
    await at(32)
    await press("]")
    await at(52)
    await press("[")
    await at(32)
    await press("End")
    await at(200)
    await press("+")
    await until(page, "document.getElementById('speed').value === '2'")
    await press("-")
    await press("-")
    await until(page, "viewer.play.speed === 0.5")
    await press("Home")
    await press(" ")
    await until(page, "viewer.play.playing && viewer.frame.time > 1")
    # Keys of the browser stay the browser's.
    position = playback.position
    await press("Control+ArrowLeft")
    assert playback.playing and playback.position >= position


async def test_every_control_is_reached_by_tab(viewer: Viewer, open_page: OpenPage, playback: Playback) -> None:
    playback.command("pause", 0)
    page = await open_page(viewer.url)
    await until(page, "viewer.frames > 0 && !document.getElementById('transport').hidden")
    reached = []
    for _ in range(14):
        await page.keyboard.press("Tab")
        reached.append(await page.evaluate("document.activeElement.id"))
    wanted = ["theme", "help-button", "pitch", "position", "previous-episode", "step-back", "play-pause", "step-on",
              "next-episode", "speed"]  # fmt: skip
    assert [name for name in reached if name in wanted][: len(wanted)] == wanted
    await page.focus("#step-on")
    await page.keyboard.press("Enter")
    await until(page, "viewer.play.position > 0")
    await page.focus("#position")
    await page.keyboard.press("ArrowRight")
    await page.keyboard.press("ArrowRight")
    await until(page, "viewer.play.position > 2")


async def test_help_opens_and_closes_with_the_keyboard(viewer: Viewer, open_page: OpenPage) -> None:
    page = await open_page(viewer.url)
    await until(page, "viewer.frames > 0 && !document.getElementById('transport').hidden")
    await page.keyboard.press("?")
    assert await page.is_visible("#help") and await page.is_visible("#help-playback")
    assert not await page.is_visible("#help-demonstrate")
    assert await page.evaluate("document.activeElement.textContent") == "Close"
    await page.keyboard.press("Escape")
    assert not await page.is_visible("#help")


async def test_the_mouse_plays_a_recording_too(viewer: Viewer, open_page: OpenPage, playback: Playback) -> None:
    page = await open_page(viewer.url)
    await until(page, "viewer.history.bars.length === 8")
    await page.click("#play-pause")
    await until(page, "!viewer.play.playing")
    await page.click("#next-episode")
    await page.select_option("#speed", "5")
    await until(page, "viewer.play.speed === 5")
    bar = await page.evaluate("viewer.history.bars[3]")
    await page.click("#history", position={"x": (bar["from"] + bar["to"]) / 2, "y": 60})
    await until(page, "viewer.frame.time === 63")
    assert await page.evaluate("viewer.history.current") == 4


async def test_a_second_browser_watches_and_steers_nothing(
    viewer: Viewer, open_page: OpenPage, playback: Playback
) -> None:
    first = await open_page(viewer.url)
    await until(first, "viewer.frames > 0")
    second = await open_page(viewer.url)
    await until(second, "viewer.frames > 2")
    assert await second.inner_text("#connection") == "watching"
    assert not await second.is_visible("#transport")
    await first.keyboard.press(" ")
    await until(first, "!viewer.play.playing")
    where = playback.position
    await second.keyboard.press(" ")
    await second.keyboard.press("End")
    await asyncio.sleep(0.2)
    assert not playback.playing and playback.position == where


@pytest.mark.parametrize("width", [360, 768, 1280])
async def test_it_fits_phones_tablets_and_desktops(viewer: Viewer, open_page: OpenPage, width: int) -> None:
    page = await open_page(viewer.url, width, 740)
    await until(page, "viewer.frames > 2 && !document.getElementById('transport').hidden")
    assert await page.evaluate("document.documentElement.scrollWidth") <= width
    sizes = await page.evaluate(
        """[...document.querySelectorAll("#transport button, #transport select")].map((node) => {
          const box = node.getBoundingClientRect();
          return [box.width, box.height, box.left, box.right];
        })"""
    )
    for wide, high, left, right in sizes:
        assert wide >= 36 and high >= 32 and left >= 0 and right <= width
    canvas = await page.locator("#pitch").bounding_box()
    assert canvas is not None and canvas["width"] >= 300 and abs(canvas["width"] / canvas["height"] - 1) < 0.02
    # On the first screen of a phone: the whole pitch and the button that stops.
    button = await page.locator("#play-pause").bounding_box()
    assert button is not None and button["y"] + button["height"] < 740


async def test_the_canvas_is_as_fine_as_the_screen(viewer: Viewer, open_page: OpenPage) -> None:
    page = await open_page(viewer.url, 360, 740, device_scale_factor=3)
    await until(page, "viewer.frames > 0")
    ratio = await page.evaluate("viewer.pitch.canvas.width / viewer.pitch.canvas.getBoundingClientRect().width")
    assert 2.98 < ratio < 3.02


async def test_colours_follow_the_system_and_the_switch(viewer: Viewer, open_page: OpenPage) -> None:
    async def brightness() -> int:
        """Of the picture's upper left corner."""
        value: int = await page.evaluate(
            """async () => {
              const small = new OffscreenCanvas(1, 1).getContext("2d", { willReadFrequently: true });
              for (let k = 0; k < 2; k += 1) await new Promise(requestAnimationFrame);
              small.drawImage(viewer.pitch.canvas, 4, 4, 1, 1, 0, 0, 1, 1);
              return small.getImageData(0, 0, 1, 1).data[1];
            }"""
        )
        return value

    page = await open_page(viewer.url, color_scheme="dark")
    await until(page, "viewer.frames > 0")
    assert await brightness() < 80
    await page.keyboard.press("t")
    assert await page.inner_text("#theme") == "Theme: light" and await brightness() > 180
    await page.keyboard.press("t")
    assert await page.inner_text("#theme") == "Theme: dark" and await brightness() < 80
    await page.reload()
    await until(page, "viewer.frames > 0")
    assert await page.inner_text("#theme") == "Theme: dark"
    await page.keyboard.press("t")
    assert await brightness() < 80
    await page.emulate_media(color_scheme="light")
    assert await brightness() > 180


async def test_the_end_of_an_episode_is_announced(viewer: Viewer, open_page: OpenPage) -> None:
    page = await open_page(viewer.url)
    await until(page, "viewer.frames > 0")
    viewer.room.episode(Episode(9, 100, 223, OUT))
    await until(page, "document.getElementById('announcer').textContent !== ''")
    assert await page.inner_text("#announcer") == "Episode 9: Ball out after 12.3 s."
    assert await page.inner_text("#banner") == "Ball out after 12.3 s"
    viewer.room.notice("The server has gone.")
    await until(page, "!document.getElementById('notice').hidden")
    assert await page.inner_text("#notice") == "The server has gone."


async def test_a_page_that_lost_the_viewer_says_so(open_page: OpenPage) -> None:
    viewer = await serve(Playback(read_recording(DATA / "sample-v5.rcg.gz")), open_browser=False)
    page = await open_page(viewer.url)
    await until(page, "viewer.frames > 0")
    await viewer.close()
    await until(page, "document.getElementById('connection').dataset.state === 'off'")
    assert await page.inner_text("#connection") == "closed"
    await page.close()
