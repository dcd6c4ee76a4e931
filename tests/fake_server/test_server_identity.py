"""What clients are told about who they are, and what the console says of those who are refused."""

from __future__ import annotations

import pytest
from server_clients import options, serving

ILLEGAL = "(error no_more_player_or_goalie_or_illegal_client_version)"


def test_opponents_see_fixed_team_names() -> None:
    changes = {"fixed_teamname_l": "RED", "fixed_teamname_r": "BLUE", "visible_angle": 360.0}
    with serving(options(coach_w_referee=True, **changes)) as clients:
        assert clients.open().join("(init BLUE (version 18))") == "(error conflict_with_fixed_teamname)"
        players = [clients.open() for _ in range(3)]
        for player, team in zip(players, ("Alpha", "Beta", "Alpha"), strict=True):
            player.join(f"(init {team} (version 18))")
        monitor, trainer = clients.monitor(), clients.trainer()
        seen = {player: player.until(r"\(see .*\(\(p \".*\(\(p \"")[-1] for player in players}
        assert '((p "BLUE" 1)' in seen[players[0]] and '((p "Alpha" 2)' in seen[players[0]]
        assert seen[players[1]].count('((p "RED" ') == 2
        assert "Beta" not in seen[players[0]] and "Alpha" not in seen[players[1]]
        names = trainer.ask("(team_names)", r"\(ok team_names")
        assert names == "(ok team_names (team l Alpha) (team r Beta))\n"
        assert '((p "Beta" 1)' in trainer.ask("(look)", r"\(ok look")
        assert " (tm Alpha Beta 0 0) " in monitor.until(r"\(show .*\(tm Alpha Beta")[-1]


def test_one_name_may_be_fixed() -> None:
    with serving(options(fixed_teamname_r="BLUE", visible_angle=360.0)) as clients:
        left, right = clients.open(), clients.open()
        left.join("(init Alpha (version 18))")
        right.join("(init Beta (version 18))")
        assert '((p "BLUE" 1)' in left.until(r"\(see .*\(\(p \"")[-1]
        assert '((p "Alpha" 1)' in right.until(r"\(see .*\(\(p \"")[-1]


def test_refused_versions_are_named_once(capsys: pytest.CaptureFixture[str]) -> None:
    with serving(options(coach_w_referee=True)) as clients:
        for first in ("(init Puck (version 7))", "(init P (version 7))", "(init Puck)", "(init Puck (version 99))"):
            assert clients.open().join(first) == ILLEGAL
        trainer = clients.open(clients.server.coach_port)
        assert trainer.join("(init (version 5))") == "(error illegal_client_version)"
        assert clients.open().join("(dispinit version 6)") == "(error illegal_client_version)"
    lines = capsys.readouterr().err.splitlines()
    assert [line.split(": ", 2)[2] for line in lines] == [
        "a player of protocol version 7 was refused; versions 8 to 19 are served",
        "a player of protocol version 3 was refused; versions 8 to 19 are served",
        "a player of protocol version 99 was refused; versions 8 to 19 are served",
        "a trainer of protocol version 5 was refused; versions 8 to 19 are served",
        "a monitor of protocol version 6 was refused; versions -1 to 5 are served",
    ]
    assert all(line.startswith("fake-rcssserver: 127.0.0.1:") for line in lines)
