"""A room without HTTP: pages are told everything, and what they say is done or answered."""

from __future__ import annotations

import asyncio
import json
from typing import Any

import pytest

from rcss_hat.keepaway.report import OUT, Episode
from rcss_hat.viewer import protocol
from rcss_hat.viewer.browser import Browser
from rcss_hat.viewer.controls import Fate, KeyChannel
from rcss_hat.viewer.demonstrator import Demonstrator, Terms
from rcss_hat.viewer.room import Manner, Room

from .audience import FIELD, SETUP, Stage, end, snapshot, until
from .audience import make_frame as make


class Page(Browser):
    """A page at the end of no network."""

    def __init__(self, session: str = "anna") -> None:
        super().__init__(self._deliver_here, session)
        self.heard: list[dict[str, Any]] = []

    async def _deliver_here(self, text: str) -> None:
        self.heard.append(json.loads(text))

    async def last(self, kind: str) -> dict[str, Any]:
        await self.flush()
        return next(m for m in reversed(self.heard) if m["type"] == kind)


def say(room: Room, page: Page, **message: Any) -> None:
    room.hear(page, json.dumps(message))


@pytest.fixture
async def controls() -> Demonstrator:
    return Demonstrator(KeyChannel(), None, Terms(5, start=True))


@pytest.fixture
async def room(controls: Demonstrator) -> Room:
    return Room(Stage(), controls, Manner(plain=True, language="de"))


async def test_who_comes_back_is_where_he_was(room: Room, controls: Demonstrator) -> None:
    """The connection breaks in the middle of a game, and another one of the same person comes."""
    page = Page()
    room.enter(page)
    room.setup(SETUP, live=True)
    say(room, page, type="demonstration", value="start")
    say(room, page, type="press", value=1, at=10.5)
    end(room, Episode(1, 0, 40, OUT))
    room.frame(make(snapshot(41, (0.5, 0.0), **FIELD), SETUP, 2, 40))
    room.leave(page)
    assert controls.standing
    again = Page()
    room.enter(again)
    assert not controls.standing
    hello = await again.last("hello")
    assert (hello["role"], hello["plain"], hello["language"], hello["protocol"]) == ("player", True, "de", 1)
    status = await again.last("demonstration")
    assert status["started"] and status["kept"] == 1
    assert (await again.last("frame"))["frame"]["time"] == 41
    assert [e["number"] for e in (await again.last("episodes"))["episodes"]] == [1]


async def test_in_plain_manner_no_state_variable_leaves_the_room(room: Room) -> None:
    page = Page()
    room.enter(page)
    shown = make(snapshot(1, (0.5, 0.0), **FIELD), SETUP, 1, 0)
    room.frame(shown)
    told = (await page.last("frame"))["frame"]
    assert shown["state"] is not None and told["state"] is None and told["values"] is None
    assert told["choices"] and told["players"]


async def test_every_key_has_one_fate(room: Room, controls: Demonstrator) -> None:
    fates = list[Fate]()
    controls.keys.on_fate = fates.append
    page = Page()
    room.enter(page)
    say(room, page, type="demonstration", value="start")
    room.frame(make(snapshot(1, (0.5, 0.0), **FIELD), SETUP, 1, 0))
    for message in (
        {"type": "press", "value": 1}, {"type": "press", "value": 2, "at": 12}, {"type": "press", "value": 7},
        {"type": "press", "value": 0}, {"type": "mate", "value": "l3"}, {"type": "mate", "value": "l1"},
    ):  # fmt: skip
        say(room, page, **message)
    assert controls.keys.take(1, 1, [0.0] * 13) == 2
    say(room, page, type="press", value=1)
    room.frame(make(snapshot(2, (-5.2, 0.0), **FIELD), SETUP, 1, 0))
    assert [(f.press.action, f.fate) for f in fates] == [
        (1, "replaced"), (7, "refused"), (2, "taken back"), (0, "hold"), (0, "refused"), (2, "played"), (1, "lapsed"),
    ]  # fmt: skip
    assert fates[2].press.at == 12.0 and fates[-1].cycle == 2
    assert (await page.last("refused"))["code"] == "no_pass_there"


async def test_what_pages_say_is_told_to_whoever_keeps_a_log(room: Room) -> None:
    said = list[protocol.Message]()
    room.on_message = lambda page, message: said.append(message)
    page = Page()
    room.enter(page)
    for text in ('{"type": "pace", "intervals": [100, 101]}', '{"type": "look", "value": false}', "nonsense"):
        room.hear(page, text)
    assert said == [protocol.Pace([100, 101]), protocol.Look(False)]
    assert (await page.last("refused"))["code"] == "malformed"


async def test_rooms_know_nothing_of_each_other(room: Room, controls: Demonstrator) -> None:
    other = Room(Stage(), Demonstrator(KeyChannel(), None, Terms(5, start=True)))
    page, stranger = Page(), Page("bert")
    room.enter(page)
    other.enter(stranger)
    say(other, stranger, type="demonstration", value="start")
    assert not controls.started and (await stranger.last("hello"))["role"] == "player"
    running = asyncio.create_task(other.run())
    await until(lambda: other.source.audience is other)  # type: ignore[attr-defined]
    running.cancel()
    other.close("../next")
    assert (await stranger.last("farewell"))["url"] == "../next"
    await page.flush()
    assert all(m["type"] != "farewell" for m in page.heard)
