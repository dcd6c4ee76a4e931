"""While kernels compile, the page answers."""

from __future__ import annotations

import threading
from collections.abc import Callable

import pytest

from rcss_hat.arena.match import ArenaMatch
from rcss_hat.viewer.audience import Source
from rcss_hat.viewer.controls import KeyChannel
from rcss_hat.viewer.demonstrator import Demonstrator
from rcss_hat.viewer.playback import Playback
from rcss_hat.viewer.server import serve
from rcss_hat.viewer.stage_game import StageGame
from rcss_hat.viewer.stage_reel import StageReel

from .audience import played_by, until
from .test_server import Page


def to_play() -> Source:
    demonstrator = Demonstrator(KeyChannel(), None)
    return StageGame(played_by(demonstrator, 1), demonstrator)


def to_watch() -> Source:
    return Playback(StageReel(played_by(Demonstrator(KeyChannel(), None), 1), 1))


@pytest.mark.parametrize("source", [to_play, to_watch])
async def test_the_page_answers_while_the_arena_compiles(
    source: Callable[[], Source], monkeypatch: pytest.MonkeyPatch
) -> None:
    compiling, allowed = threading.Event(), threading.Event()
    advance = ArenaMatch.advance

    def compile_first(match: ArenaMatch, *arguments, **keywords):  # type: ignore[no-untyped-def]
        compiling.set()
        assert allowed.wait(60.0)
        return advance(match, *arguments, **keywords)

    monkeypatch.setattr(ArenaMatch, "advance", compile_first)
    async with await serve(source(), open_browser=False) as viewer:
        await until(compiling.is_set)
        page = await Page(viewer.url).open()
        assert page.last("setup") is None
        allowed.set()
        await until(lambda: page.last("frame"), 300.0)
        await page.close()


async def test_a_viewer_is_closed_while_the_arena_compiles(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ctrl-C: nobody waits for what takes for ever."""
    compiling = threading.Event()

    def compile_for_ever(match: ArenaMatch, *arguments, **keywords):  # type: ignore[no-untyped-def]
        while True:
            compiling.set()
            threading.Event().wait(0.001)

    monkeypatch.setattr(ArenaMatch, "advance", compile_for_ever)
    async with await serve(to_play(), open_browser=False):
        await until(compiling.is_set)
        assert "_advance" in {thread.name for thread in threading.enumerate()}
    assert "_advance" not in {thread.name for thread in threading.enumerate()}
