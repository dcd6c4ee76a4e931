"""What is read is written again as it was, wherever an event can be written from its record."""

from __future__ import annotations

import pytest

from rcss_hat.protocol.messages import Event, Hear, OkCompression, OkTeamNames, PlayMode, Reconnect, Team, parse

from .recorded import received


def written(event: Event) -> str | None:
    try:
        return event.to_text()
    except NotImplementedError:  # those whose records kernels write
        return None


def test_recorded_messages_are_written_as_they_were_read() -> None:
    kinds = set()
    for datagram in received():
        event = parse(datagram.text.encode("latin-1"), datagram.team)
        text = written(event)
        of_trainer = datagram.client == "trainer" and " referee " in datagram.text  # only trainers get other forms
        if text is not None and not of_trainer:
            assert text == datagram.text.rstrip("\n")
            kinds.add(type(event).__name__)
    expected = {"Init", "InitOk", "Reconnect", "Ok", "OkClang", "OkCheckBall", "OkTeamNames", "Error"}
    assert kinds >= expected | {"Warning", "Score", "Think", "ChangePlayerType", "Msg", "SeeGlobal", "Hear"}


@pytest.mark.parametrize(
    "event",
    [
        Reconnect(side="r", mode="play_on"),
        OkTeamNames(left=None, right="takers"),
        OkCompression(level=-1),
        PlayMode(time=5, mode="goal_l"),
        Team(time=5, left="a", right="null", left_score=1, right_score=2, penalties=(1, 2, 3, 4)),
        Hear(time=5, source="player", text="hi", unum=3, team="keepers", goalie=True),
        Hear(time=5, source="player", text="hi", direction=-30),
    ],
)
def test_what_is_written_is_read_again(event: Event) -> None:
    assert parse(event.to_text().encode()) == event
