from __future__ import annotations

import asyncio
import json
import socket
from collections.abc import AsyncIterator
from typing import Any

import aiohttp
import pytest

from rcss_hat.keepaway.report import OUT, Episode
from rcss_hat.viewer.audience import WatchError
from rcss_hat.viewer.controls import KeyChannel
from rcss_hat.viewer.demonstrator import Demonstrator
from rcss_hat.viewer.server import Viewer, serve, static_files

from .audience import Stage, end, until


class Page:
    """A browser, as far as the server can tell."""

    def __init__(self, url: str) -> None:
        self.address, _, query = url.partition("?")
        self.query = f"?{query}"
        self.http = aiohttp.ClientSession(cookie_jar=aiohttp.CookieJar(unsafe=True))
        self.heard: list[dict[str, Any]] = []
        self.socket: aiohttp.ClientWebSocketResponse | None = None
        self._reading: asyncio.Task[None] | None = None

    async def open(self) -> Page:
        async with self.http.get(self.address + self.query) as response:
            assert response.status == 200
        self.socket = await self.http.ws_connect(self.address + "socket", origin=self.address.rstrip("/"))
        self._reading = asyncio.create_task(self._read(self.socket))
        await until(lambda: any(m["type"] == "hello" for m in self.heard))
        return self

    async def _read(self, ws: aiohttp.ClientWebSocketResponse) -> None:
        async for message in ws:
            self.heard.append(json.loads(message.data))

    def last(self, kind: str) -> dict[str, Any] | None:
        return next((m for m in reversed(self.heard) if m["type"] == kind), None)

    async def say(self, **message: Any) -> None:
        assert self.socket is not None
        await self.socket.send_json(message)

    async def close(self) -> None:
        if self._reading is not None:
            self._reading.cancel()
        await self.http.close()


@pytest.fixture
async def stage() -> Stage:
    return Stage()


@pytest.fixture
async def controls() -> Demonstrator:
    return Demonstrator(KeyChannel(), None, 3)


@pytest.fixture
async def viewer(stage: Stage, controls: Demonstrator) -> AsyncIterator[Viewer]:
    async with await serve(stage, controls, open_browser=False) as viewer:
        await until(lambda: stage.audience)
        yield viewer


@pytest.fixture
async def pages(viewer: Viewer) -> AsyncIterator[list[Page]]:
    pages = [Page(viewer.url), Page(viewer.url)]
    yield pages
    for page in pages:
        await page.close()


async def get(url: str, **headers: str) -> tuple[int, str, Any]:
    async with aiohttp.ClientSession() as http, http.get(url, headers=headers, allow_redirects=False) as response:
        return response.status, await response.text(), response.headers


async def test_without_the_token_there_is_nothing(viewer: Viewer) -> None:
    address = viewer.url.partition("?")[0]
    for path in ("", "?token=", "?token=wrong", "app.js", "socket", "style.css?token=" + viewer.url[-32:]):
        status, text, _ = await get(address + path)
        assert status == 403 and "token" in text, path


async def test_foreign_host_names_are_refused(viewer: Viewer) -> None:
    port = viewer.url.split(":")[2].split("/")[0]
    for host in (f"evil.example:{port}", f"localhost.evil.example:{port}", "127.0.0.1", f"192.168.1.1:{port}", ":80"):
        status, text, _ = await get(viewer.url, Host=host)
        assert status == 403 and "localhost" in text, host
    status, _, _ = await get(viewer.url, Host=f"localhost:{port}")
    assert status == 200


async def test_a_foreign_or_missing_origin_cannot_connect(viewer: Viewer, pages: list[Page]) -> None:
    page = pages[0]
    async with page.http.get(viewer.url) as response:
        assert response.status == 200
    for origin in ("http://evil.example", "http://127.0.0.1:1", "null", None):
        with pytest.raises(aiohttp.WSServerHandshakeError) as error:
            await page.http.ws_connect(page.address + "socket", origin=origin)
        assert error.value.status == 403


async def test_only_get_is_answered(viewer: Viewer) -> None:
    async with aiohttp.ClientSession() as http, http.post(viewer.url, data=b"x") as response:
        assert response.status == 405


async def test_the_page_and_its_files_forbid_everything_foreign(viewer: Viewer, pages: list[Page]) -> None:
    http, address = pages[0].http, pages[0].address
    async with http.get(viewer.url) as response:
        policy = response.headers["Content-Security-Policy"]
        assert "default-src 'none'" in policy and "unsafe" not in policy
        assert response.headers["X-Content-Type-Options"] == "nosniff"
        cookie = response.headers["Set-Cookie"]
        assert "HttpOnly" in cookie and "SameSite=Strict" in cookie
    for name, (content, content_type) in static_files().items():
        async with http.get(address + name) as response:
            assert (await response.read(), response.content_type) == (content, content_type)
            for foreign in (b"http://", b"https://", b"@import"):
                assert foreign not in content.replace(b"http://www.w3.org/2000/svg", b""), name
    async with http.get(address + "..%2fserver.py") as response:
        assert response.status == 404


async def test_it_listens_on_the_loopback_interface_only(viewer: Viewer) -> None:
    assert viewer.url.startswith("http://127.0.0.1:")
    port = int(viewer.url.split(":")[2].split("/")[0])
    with socket.socket() as other:
        other.bind(("127.0.0.2", port))  # a wildcard socket would have taken this address too


async def test_the_first_browser_plays_and_the_second_watches(
    viewer: Viewer, pages: list[Page], stage: Stage, controls: Demonstrator
) -> None:
    player, watcher = await pages[0].open(), await pages[1].open()
    hello = {"type": "hello", "protocol": 1, "demonstrate": True, "plain": False, "language": None}
    assert player.last("hello") == {**hello, "role": "player"}
    assert watcher.last("hello") == {**hello, "role": "watcher"}
    stage.show(1)
    await until(lambda: player.last("frame") and watcher.last("frame"))
    for message in (
        {"type": "press", "value": 1}, {"type": "mate", "value": "l2"}, {"type": "playback", "name": "play"},
        {"type": "demonstration", "value": "stop"},
    ):  # fmt: skip
        watcher.heard.clear()
        await watcher.say(**message)
        await until(lambda: watcher.last("refused"))
    assert controls.keys.pending is None and not controls.finished and not stage.commands
    await player.say(type="press", value=2)
    await until(lambda: controls.keys.pending)
    assert controls.keys.pending is not None and controls.keys.pending.action == 2


async def test_the_player_stays_the_player_when_the_page_is_loaded_again(viewer: Viewer, pages: list[Page]) -> None:
    player = await pages[0].open()
    await pages[1].open()
    assert player.socket is not None
    await player.socket.close()
    player.heard.clear()
    await player.open()
    assert player.last("hello")["role"] == "player"  # type: ignore[index]


async def test_the_person_is_there_while_a_page_of_the_player_is_open(
    viewer: Viewer, pages: list[Page], controls: Demonstrator
) -> None:
    assert controls.away, "nobody has opened the link yet"
    player = await pages[0].open()
    assert not controls.away
    await pages[1].open()  # watches
    assert player.socket is not None
    await player.socket.close()
    await until(lambda: controls.away)
    await player.open()
    assert not controls.away


async def test_opening_the_link_without_connecting_takes_nothing(viewer: Viewer, pages: list[Page]) -> None:
    """Some programs fetch links that they show."""
    assert (await get(viewer.url))[0] == 200
    assert (await pages[0].open()).last("hello")["role"] == "player"  # type: ignore[index]


async def test_frames_carry_what_the_person_asked_for(
    viewer: Viewer, pages: list[Page], stage: Stage, controls: Demonstrator
) -> None:
    page = await pages[0].open()
    stage.show(1)
    await until(lambda: page.last("frame"))
    await page.say(type="mate", value="l3")
    await until(lambda: controls.keys.pending)
    stage.show(2)
    await until(lambda: page.last("frame")["frame"]["time"] == 2)  # type: ignore[index]
    frame = page.last("frame")["frame"]  # type: ignore[index]
    assert frame["pending"] == 2
    assert [(c["action"], c["mate"], c["arrow"]) for c in frame["choices"]] == [
        (1, "l2", "ArrowRight"),
        (2, "l3", "ArrowDown"),
    ]


async def test_who_comes_later_is_told_everything(viewer: Viewer, pages: list[Page], stage: Stage) -> None:
    assert stage.audience is not None
    end(viewer.room, Episode(1, 0, 40, OUT))
    stage.audience.notice("careful")
    stage.show(41)
    page = await pages[0].open()
    await until(lambda: page.last("frame"))
    assert page.last("episodes")["episodes"] == [  # type: ignore[index]
        {"number": 1, "start": 0, "end": 40, "reason": "o", "cycles": 40}
    ]
    assert page.last("notice")["text"] == "careful"  # type: ignore[index]
    assert page.last("setup")["setup"]["title"] == "test"  # type: ignore[index]
    assert page.last("demonstration")["kept"] == 1  # type: ignore[index]


async def test_the_person_pauses_drops_and_finishes(
    viewer: Viewer, pages: list[Page], stage: Stage, controls: Demonstrator
) -> None:
    page = await pages[0].open()
    for command, key, value in (
        ("pause", "paused", True), ("resume", "paused", False), ("drop", "dropping", True), ("stop", "finished", True),
    ):  # fmt: skip
        await page.say(type="demonstration", value=command)
        await until(lambda key=key, value=value: page.last("demonstration")[key] is value)  # type: ignore[index, misc]
    assert controls.finished


async def test_playback_commands_reach_the_source(viewer: Viewer, pages: list[Page], stage: Stage) -> None:
    page = await pages[0].open()
    await page.say(type="playback", name="play", value=3)
    await page.say(type="playback", name="seek", value="far")
    await page.say(type="playback", name="seek", value=10**1000)
    await until(lambda: sum(m["type"] == "refused" for m in page.heard) == 2)
    assert stage.commands == [("play", 3.0), ("seek", 0.0), ("seek", 0.0)]


@pytest.mark.parametrize(
    "text", ["", "nonsense", "[]", "3", "null", '{"type": 3}', '{"type": "press"}', '{"type": "press", "value": true}',
             '{"type": "press", "value": 99}', '{"type": "mate", "value": 1}', '{"type": "playback", "name": 1}',
             '{"type": "demonstration", "value": "x"}', '{"type": "press", "value": 1.0}', "[" * 4000]
)  # fmt: skip
async def test_malformed_messages_are_refused_and_change_nothing(
    viewer: Viewer, pages: list[Page], stage: Stage, controls: Demonstrator, text: str
) -> None:
    page = await pages[0].open()
    before = controls.status()
    assert page.socket is not None
    await page.socket.send_str(text)
    await until(lambda: page.last("refused"))
    assert controls.status() == before and controls.keys.pending is None and stage.commands == []


async def test_an_overlong_message_ends_that_connection_only(viewer: Viewer, pages: list[Page], stage: Stage) -> None:
    page, other = await pages[0].open(), await pages[1].open()
    assert page.socket is not None
    await page.socket.send_str("x" * 100_000)
    await until(lambda: page.socket.closed)  # type: ignore[union-attr]
    stage.show(3)
    await until(lambda: other.last("frame"))


async def test_a_page_that_does_not_keep_up_gets_the_newest_picture(
    viewer: Viewer, pages: list[Page], stage: Stage
) -> None:
    page = await pages[0].open()
    for time in range(1, 400):
        stage.show(time)
    await until(lambda: page.last("frame") and page.last("frame")["frame"]["time"] == 399)  # type: ignore[index]
    assert sum(m["type"] == "frame" for m in page.heard) < 20


async def test_the_end_of_the_source_is_told_to_pages_and_caller(
    viewer: Viewer, pages: list[Page], stage: Stage
) -> None:
    page = await pages[0].open()
    stage.failure = WatchError("the server has gone")
    stage.over.set()
    with pytest.raises(WatchError, match="has gone"):
        await viewer.wait()
    await until(lambda: page.last("notice") and "has gone" in page.last("notice")["text"])  # type: ignore[index]


async def test_closing_frees_the_port_and_tells_the_pages(stage: Stage) -> None:
    viewer = await serve(stage, open_browser=False)
    page = await Page(viewer.url).open()
    assert page.last("hello")["demonstrate"] is False  # type: ignore[index]
    port = int(viewer.url.split(":")[2].split("/")[0])
    viewer.room.episode(Episode(1, 0, 40, OUT))
    viewer.room.notice("finished")
    await viewer.close()
    await until(lambda: page.socket.closed)  # type: ignore[union-attr]
    assert page.last("episode") is not None and page.last("notice")["text"] == "finished"
    assert page.socket is not None and page.socket.close_code == 1001
    await page.close()
    again = await serve(Stage(), port=port, open_browser=False)
    with pytest.raises(OSError):
        await serve(Stage(), port=port, open_browser=False)
    await again.close()


async def test_the_browser_is_opened_where_there_is_a_desktop(monkeypatch: pytest.MonkeyPatch, stage: Stage) -> None:
    opened: list[str] = []
    monkeypatch.setattr("webbrowser.open", lambda url: opened.append(url))
    monkeypatch.setattr("sys.platform", "linux")
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    await (await serve(stage)).close()
    assert opened == []
    monkeypatch.setenv("DISPLAY", ":0")
    viewer = await serve(Stage())
    assert opened == [viewer.url]
    await viewer.close()
