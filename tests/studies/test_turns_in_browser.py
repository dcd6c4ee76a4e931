"""A participant in a real browser plays in turns with the computer, and looks at a game again."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from rcss_hat.hat.decision_list import PAPER_RULES
from rcss_hat.studies.address import Address
from rcss_hat.studies.folder import StudyFolder
from rcss_hat.studies.people_file import load_people
from rcss_hat.studies.plan import assigned
from rcss_hat.studies.server import StudyServer

from .serving import people_of
from .test_people_page import PHONE, begin_game, free_of_faults, opened, seen
from .test_turns import TURNS

if TYPE_CHECKING:
    from playwright.async_api import Browser

pytestmark = [pytest.mark.asyncio(loop_scope="module"), pytest.mark.compiled, pytest.mark.slow]


@pytest.mark.parametrize("screen", [{"viewport": {"width": 1280, "height": 800}}, PHONE], ids=["desk", "phone"])
async def test_the_computer_plays_until_a_key_and_the_game_is_looked_at_again(
    tmp_path: Path, chromium: Browser, screen: dict[str, Any]
) -> None:
    PAPER_RULES.save(tmp_path / "rules.json")
    (tmp_path / "turns.toml").write_text(TURNS.read_text())
    folder = StudyFolder.begin(tmp_path / "folder", load_people(str(tmp_path / "turns.toml")), rehearsal=True)
    place = next(k for k in (1, 2, 3) if assigned(folder.study, k) == ("turns",))
    complaints: list[str] = []
    async with StudyServer(folder, Address(), 1, print, hurry=4.0) as server:
        page = await opened(chromium, server.link(place), complaints, **screen)
        await page.get_by_role("button", name="Continue").click()
        await begin_game(page)
        await seen(page, "viewer.status.started && viewer.status.by === 'learner'")
        assert "The computer plays." in await page.inner_text("#turns")
        if screen is PHONE:
            await page.locator("#passes button").nth(1).tap()
        else:
            await page.keyboard.press("1")
        await seen(page, "viewer.status.by === 'person' || viewer.replay.shown")
        await seen(page, "viewer.replay.shown && viewer.replay.decision")
        await free_of_faults(page)
        await page.locator("#rights button").first.click()
        await seen(page, "[...viewer.replay.decisions.values()].some(d => d.right === 0)")
        await page.locator("#replay-done").click()
        await page.get_by_text("Game 1 of 3").wait_for()
        await page.context.close()
    mine = people_of(folder.path)[f"p00{place}"]
    assert [e["action"] for e in mine.events if e["event"] == "correction"][-1:] == [0]
    assert any(e["event"] == "stood" and e["why"] == "replay" for e in mine.events)
    assert not complaints
