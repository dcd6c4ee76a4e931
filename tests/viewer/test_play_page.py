"""The page of a person who plays: its first seconds, phones, languages, broken connections."""

from __future__ import annotations

import asyncio
import json
import re
from collections.abc import AsyncIterator
from importlib import resources
from typing import Any

import pytest
import pytest_asyncio
from aiohttp import ClientSession, WSMsgType, web

from rcss_hat.keepaway.report import OUT, Episode
from rcss_hat.viewer import protocol
from rcss_hat.viewer.controls import KeyChannel
from rcss_hat.viewer.demonstrator import Demonstrator, Terms
from rcss_hat.viewer.pagefiles import languages
from rcss_hat.viewer.room import Manner
from rcss_hat.viewer.server import Viewer, serve

from .audience import PATIENCE, Stage, end, nobody_decides
from .audience import until as until_here
from .conftest import OpenPage
from .test_page import until

pytestmark = pytest.mark.asyncio(loop_scope="module")

STATIC = resources.files("rcss_hat.viewer") / "static"
PHONE: dict[str, Any] = {"has_touch": True, "is_mobile": True}
JARGON = re.compile(r"seed|cycle|episode|PASS\d|keeper|taker|state|K1", re.IGNORECASE)
INSIDE = """(ids) => ids.map((id) => {
  const box = document.querySelector(id).getBoundingClientRect();
  return box.width > 0 && box.left >= 0 && box.top >= 0 && box.right < innerWidth + 1 && box.bottom < innerHeight + 1;
})"""


@pytest_asyncio.fixture(loop_scope="module")
async def stage() -> Stage:
    return Stage()


@pytest_asyncio.fixture(loop_scope="module")
async def demonstration() -> Demonstrator:
    return Demonstrator(KeyChannel(), None, Terms(20, start=True))


@pytest_asyncio.fixture(loop_scope="module")
async def viewer(stage: Stage, demonstration: Demonstrator) -> AsyncIterator[Viewer]:
    manner = Manner(plain=True)
    async with await serve(stage, demonstration, open_browser=False, manner=manner) as viewer:
        await until_here(lambda: stage.audience)
        yield viewer


async def started(page: Any, stage: Stage, cycle: int = 1) -> None:
    """Begin, and wait for a picture."""
    await until(page, "document.getElementById('intro').open")
    await page.keyboard.press("Enter")
    await until(page, "viewer.status.started && !viewer.status.standing")
    stage.show(cycle)
    await until(page, f"viewer.frame?.time === {cycle}")


# -- the first seconds ------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(("width", "height", "touch"), [(1280, 800, {}), (390, 844, PHONE)])
async def test_goal_colours_and_keys_come_first_and_a_key_starts(
    viewer: Viewer, stage: Stage, demonstration: Demonstrator, open_page: OpenPage, width: int, height: int, touch: Any
) -> None:
    page = await open_page(viewer.url, width, height, **touch)
    await until(page, "document.getElementById('intro').open")
    said = await page.inner_text("#intro")
    for part in ("You are blue", "orange", "1 or 2", "Start"):
        assert part in said
    assert ("Tap" if touch else "Press") in said
    colours = await page.evaluate(
        "['.keeper', '.taker'].map((k) => getComputedStyle(document.querySelector(`.who ${k}`)).backgroundColor)"
    )
    blue, orange = ([int(n) for n in re.findall(r"\d+", colour)] for colour in colours)
    assert blue[2] > blue[0] and orange[0] > orange[2]
    assert await page.evaluate("document.activeElement.id") == "start"
    assert demonstration.standing
    if touch:
        await page.tap("#start")
    else:
        await page.keyboard.press(" ")
    await until_here(lambda: demonstration.started and not demonstration.standing)
    stage.show(1)
    await until(page, "viewer.frame && !document.querySelector('dialog[open]')")
    assert not JARGON.search(await page.inner_text("body"))


async def test_what_the_game_must_not_show_is_not_on_the_page(
    viewer: Viewer, stage: Stage, open_page: OpenPage
) -> None:
    page = await open_page(viewer.url)
    await started(page, stage)
    assert await page.evaluate("viewer.frame.state === null && viewer.frame.values === null")
    assert not await page.is_visible("#details-button")
    assert await page.evaluate("viewer.pitch.numbers") is False  # who is no key wears no number


# -- phones -----------------------------------------------------------------------------------------------------------
@pytest.mark.parametrize(
    ("width", "height", "touch"),
    [(1280, 720, {}), (360, 640, PHONE), (390, 844, PHONE), (844, 390, PHONE)],
)
async def test_score_progress_field_and_keys_are_in_sight_and_nothing_moves(
    viewer: Viewer, stage: Stage, open_page: OpenPage, width: int, height: int, touch: Any
) -> None:
    page = await open_page(viewer.url, width, height, **touch)
    await started(page, stage)
    ids = ["#score", "#progress-text", "#pitch", "#passes button[data-action='1']", "#passes button[data-action='2']",
           "#passes button[data-action='0']", "#finish", "#help-button"]  # fmt: skip
    assert await page.evaluate(INSIDE, ids) == [True] * len(ids)
    place = "JSON.stringify(document.getElementById('pitch').getBoundingClientRect())"
    before = await page.evaluate(place)
    viewer.room.notice("Goes on in 2 ...", "goes_on", seconds=2)
    end(viewer.room, Episode(1, 0, 123, OUT))
    viewer.room.notice("something went wrong")
    await until(page, "document.getElementById('last').textContent !== '\u2013'")
    assert await page.inner_text("#last") == "12.3 s"
    assert await page.evaluate(place) == before
    assert await page.evaluate(
        "[document.documentElement.scrollWidth <= innerWidth, document.documentElement.scrollHeight <= innerHeight]"
    ) == [True, True]
    if touch:
        small = await page.evaluate(
            """[...document.querySelectorAll("#play button, #tools button, #tools select")].filter((node) => {
              const box = node.getBoundingClientRect();
              return node.checkVisibility() && (box.height < 44 || box.width < 44);
            }).map((node) => node.id)"""
        )
        assert small == []
        caps = "[...document.querySelectorAll('button kbd')].filter((k) => k.checkVisibility()).length"
        assert await page.evaluate(caps) == 0


SWIPE = """([dx, dy]) => {
  const button = document.querySelector("#passes button[data-action='1']"), box = button.getBoundingClientRect();
  const x = box.left + box.width / 2, y = box.top + box.height / 2;
  const send = (type, x, y) => button.dispatchEvent(
    new PointerEvent(type, { pointerType: "touch", pointerId: 7, bubbles: true, clientX: x, clientY: y, button: 0 }));
  send("pointerdown", x, y);
  send("pointermove", x + dx, y + dy);
  setTimeout(() => send("pointerup", x + dx, y + dy), 120);
}"""


async def test_a_tap_passes_and_a_swipe_does_not(
    viewer: Viewer, stage: Stage, demonstration: Demonstrator, open_page: OpenPage
) -> None:
    page = await open_page(viewer.url, 390, 844, **PHONE)
    await started(page, stage)
    await page.evaluate(SWIPE, [0, -40])
    await asyncio.sleep(0.3)
    assert demonstration.keys.presses == 0
    await page.evaluate(SWIPE, [1, 2])  # a finger that lies still; it is counted once, while it is still down
    await until_here(lambda: demonstration.keys.presses == 1)
    await page.tap("#passes button[data-action='2']")
    await until_here(lambda: demonstration.keys.pending is not None and demonstration.keys.pending.action == 2)
    await asyncio.sleep(0.2)
    assert demonstration.keys.presses == 2


# -- idleness ---------------------------------------------------------------------------------------------------------
async def test_are_you_still_there(
    viewer: Viewer, stage: Stage, demonstration: Demonstrator, open_page: OpenPage
) -> None:
    page = await open_page(viewer.url)
    await started(page, stage)
    nobody_decides(demonstration, PATIENCE + 1)  # the first comes after the start key
    stage.show(2)
    await until(page, "document.getElementById('question').open")
    assert "Are you still there?" in await page.inner_text("#question") and demonstration.standing
    await page.keyboard.press("Enter")
    await until_here(lambda: not demonstration.standing)


# -- languages --------------------------------------------------------------------------------------------------------
def holes(text: Any) -> set[str]:
    """Names of what is put into a text."""
    forms = text.values() if isinstance(text, dict) else [text]
    return {name for form in forms for name in re.findall(r"\{(\w+)\}", form)}


async def test_all_languages_say_the_same_and_pages_say_nothing_else() -> None:
    assert languages() == ["en", "de"]
    texts = {name: json.loads((STATIC / f"text.{name}.json").read_text()) for name in languages()}
    english = texts.pop("en")
    for name, other in texts.items():
        assert other.keys() == english.keys(), name
        for key, text in english.items():
            assert holes(other[key]) == holes(text) and type(other[key]) is type(text), (name, key)
    page = (STATIC / "play.html").read_text()
    used = set(re.findall(r'data-(?:text|label|title)="(\w+)"', page))
    used |= {name for file in ("play.js", "scores.js", "replay.js", "ending.js", "situation.js")
             for name in re.findall(r'say\("(\w+)"', (STATIC / file).read_text())}  # fmt: skip
    assert used <= english.keys()
    # Words between tags are those of the figures for researchers, marked as English.
    spoken = page
    for part in ('<aside id="facts" lang="en".*?</aside>', "<kbd>.*?</kbd>", "<noscript>.*?</noscript>", "<title>.*?<"):
        spoken = re.sub(part, "", spoken, flags=re.DOTALL)
    words = [w for w in re.findall(r">([^<>]+)<", spoken) if re.search(r"[A-Za-z]{2}", re.sub(r"&#?\w+;", "", w))]
    assert words == []


async def test_the_page_speaks_the_language_of_the_browser_or_the_study(
    viewer: Viewer, stage: Stage, open_page: OpenPage
) -> None:
    page = await open_page(viewer.url, locale="de-AT")
    await until(page, "document.getElementById('intro').open")
    assert "Sie sind blau" in await page.inner_text("#intro")
    assert await page.evaluate("document.documentElement.lang") == "de"
    await started(page, stage)
    end(viewer.room, Episode(1, 0, 123, OUT))
    await until(page, "document.getElementById('last').textContent === '12,3 s'")
    await page.select_option("#language", "en")
    await until(page, "document.getElementById('last').textContent === '12.3 s'")
    await page.keyboard.press("7")
    await until(page, "document.getElementById('banner').textContent === 'There is no 7 here: 1 or 2 passes, 0 holds.'")
    fixed = Demonstrator(KeyChannel(), None, Terms(start=True))
    async with await serve(Stage(), fixed, open_browser=False, manner=Manner(language="de")) as other:
        told = await open_page(other.url, locale="en-GB")
        await until(told, "document.getElementById('intro').open")
        assert "Sie sind blau" in await told.inner_text("#intro") and not await told.is_visible("#language")
        await told.close()


# -- screen readers ---------------------------------------------------------------------------------------------------
async def test_what_happens_is_said(viewer: Viewer, stage: Stage, open_page: OpenPage) -> None:
    page = await open_page(viewer.url)
    await started(page, stage)
    end(viewer.room, Episode(1, 0, 123, OUT))
    await until(page, "document.getElementById('announcer').textContent.startsWith('Game 1. The ball went out after')")
    await page.keyboard.press("s")
    said = await page.text_content("#announcer")
    assert said == (
        "You have the ball. Player 1: 5 metres right. Player 2: 6 metres down. Nearest orange player: 5 metres left."
    )
    await page.focus("#passes button[data-action='1']")
    assert await page.evaluate("document.activeElement.getAttribute('aria-label')") == "Pass 1"


# -- connections ------------------------------------------------------------------------------------------------------
class Proxy:
    """A reverse proxy under a path that can be cut off."""

    def __init__(self, target: str) -> None:
        self.target, self.cut = target, False
        self.sockets: set[web.WebSocketResponse] = set()
        self.runner: web.AppRunner | None = None
        self.url = ""

    async def open(self, prefix: str) -> Proxy:
        app = web.Application()
        app.router.add_get(prefix + "{name:.*}", self._pass)
        self.runner = web.AppRunner(app, shutdown_timeout=0.5)
        await self.runner.setup()
        await web.TCPSite(self.runner, "127.0.0.1", 0).start()
        self.url = f"http://127.0.0.1:{self.runner.addresses[0][1]}{prefix}"
        return self

    async def _pass(self, request: web.Request) -> web.StreamResponse:
        if self.cut:
            assert request.transport is not None
            request.transport.abort()
            return web.Response()
        address = self.target + request.match_info["name"]
        headers = {k: v for k, v in request.headers.items() if k in ("Host", "Cookie", "Origin")}
        async with ClientSession() as http:
            if request.headers.get("Upgrade") == "websocket":
                return await self._tunnel(request, http, address, headers)
            async with http.get(address, headers=headers, params=request.query) as answer:
                kept = {k: v for k, v in answer.headers.items() if k not in ("Content-Length", "Transfer-Encoding")}
                return web.Response(status=answer.status, headers=kept, body=await answer.read())

    async def _tunnel(
        self, request: web.Request, http: ClientSession, address: str, headers: dict[str, str]
    ) -> web.StreamResponse:
        near = web.WebSocketResponse()
        async with http.ws_connect(address, headers=headers) as far:
            await near.prepare(request)
            self.sockets.add(near)

            async def down() -> None:
                async for message in far:
                    await near.send_str(message.data)

            downward = asyncio.create_task(down())
            async for message in near:
                if message.type is WSMsgType.TEXT:
                    await far.send_str(message.data)
            downward.cancel()
        return near

    async def break_off(self) -> None:
        self.cut = True
        for near in list(self.sockets):
            await near.close(code=1012)


async def test_behind_a_proxy_and_after_a_break_one_is_where_one_was(
    stage: Stage, demonstration: Demonstrator, chromium: Any
) -> None:
    public = await Proxy("").open("/keepaway/")
    async with await serve(stage, demonstration, open_browser=False, public_url=public.url) as viewer:
        assert viewer.url.startswith(public.url + "?token=")
        port = viewer._door._listener.sockets[0].getsockname()[1]  # type: ignore[union-attr]
        public.target = f"http://127.0.0.1:{port}/"
        page = await chromium.new_page()
        await page.goto(viewer.url)
        await until(page, "typeof viewer !== 'undefined'")
        await started(page, stage)
        end(viewer.room, Episode(1, 0, 123, OUT))
        await until(page, "viewer.status.kept === 1")
        await public.break_off()
        await until(page, "!document.getElementById('standstill').hidden")
        assert "The connection is lost" in await page.inner_text("#standstill")
        await until_here(lambda: demonstration.standing)
        stage.show(50)
        public.cut = False
        await until(page, "viewer.connected === 'on' && viewer.frame.time === 50", 15.0)
        await until_here(lambda: not demonstration.standing)
        assert await page.inner_text("#progress-text") == "Practice game 2 of 20"
        assert await page.inner_text("#best") == "12.3 s" and not await page.is_visible("#standstill")
        await page.keyboard.press("1")
        await until_here(lambda: demonstration.keys.pending)
        await page.reload()
        await until(page, "typeof viewer !== 'undefined' && viewer.frame?.time === 50")
        assert await page.inner_text("#progress-text") == "Practice game 2 of 20"
        assert not await page.is_visible("#intro")
        await page.close()
    assert public.runner is not None
    await public.runner.cleanup()


async def test_a_link_that_is_no_longer_valid_says_so(stage: Stage, demonstration: Demonstrator, chromium: Any) -> None:
    """The program was started again, and gave another link."""
    viewer = await serve(stage, demonstration, open_browser=False)
    port = viewer._door._listener.sockets[0].getsockname()[1]  # type: ignore[union-attr]
    page = await chromium.new_page()
    await page.goto(viewer.url)
    await until(page, "typeof viewer !== 'undefined' && viewer.setup")
    await page.evaluate("viewer.takeFarewell = () => {}")  # it was killed, and said nothing
    await viewer.close()
    async with await serve(Stage(), Demonstrator(KeyChannel()), port=port, open_browser=False):
        await until(page, "viewer.connected === 'gone'", 15.0)
        assert "no longer valid" in await page.inner_text("#standstill")
    await page.close()


async def test_the_page_goes_where_the_next_step_is(
    viewer: Viewer, stage: Stage, demonstration: Demonstrator, open_page: OpenPage
) -> None:
    page = await open_page(viewer.url)
    await started(page, stage)
    viewer.room.close("index.html")
    await page.wait_for_url("**/index.html")


async def test_the_page_tells_how_long_it_waited_for_pictures(
    viewer: Viewer, stage: Stage, open_page: OpenPage
) -> None:
    said = list[protocol.Message]()
    viewer.room.on_message = lambda page, message: said.append(message)
    page = await open_page(viewer.url)
    await started(page, stage)
    for cycle in range(2, 8):
        stage.show(cycle)
        await asyncio.sleep(0.1)
    await page.evaluate("viewer.pace.flush()")
    await until_here(lambda: any(isinstance(m, protocol.Pace) for m in said))
    (told,) = (m for m in said if isinstance(m, protocol.Pace))
    assert len(told.intervals) in range(4, 8) and 0.4 < sum(told.intervals) / 1000 < 6.0
    assert protocol.Command("start") in said
