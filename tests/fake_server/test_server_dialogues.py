"""What everybody is told in long dialogues is what rcssserver 19.0.0 told, cycle by cycle."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from dialogue_scripts import DIALOGUES
from dialogues import PLAYER_PARAMETERS, QUIET, Conversation, Dialogue, Told, differences, read
from server_clients import FAST, options

from fake_server.player_param import PlayerParams
from fake_server.running import running_server

DATA = Path(__file__).parent.parent / "data" / "fake_server"


def converse(dialogue: Dialogue) -> list[Told]:
    wanted = options(**QUIET | dialogue.server)
    wanted.player_params = PlayerParams("19.0", **PLAYER_PARAMETERS)
    with running_server(wanted, timing=FAST) as server:
        return Conversation(dialogue, (server.port, server.coach_port)).run()


@pytest.mark.parametrize("script", DIALOGUES)
def test_everybody_is_told_what_the_original_told(script: Callable[[], Dialogue]) -> None:
    dialogue = script()
    recorded = read(DATA / f"dialogue-{dialogue.name}.json.gz")
    assert len(recorded) == len(dialogue.cycles)
    assert differences(dialogue, recorded, converse(dialogue)) == []


def test_a_difference_is_found() -> None:
    dialogue = Dialogue("one", {}, {}).then(l1="(turn 5)")
    same, other = [{"l1": ["(hear 1 self a)"]}], [{"l1": ["(hear 2 self a)"]}]
    assert differences(dialogue, same, same) == []
    (line,) = differences(dialogue, same, other)
    assert "(turn 5)" in line and "(hear 1 self a)" in line and "(hear 2 self a)" in line
