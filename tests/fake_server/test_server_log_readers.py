"""Logs of a match hold what their original readers rely on.

The readers: rcssmonitor 19.0.1 (game log), and hist, winsum and kwyzipper of the UT Austin players 0.6 (Keepaway log).
"""

from __future__ import annotations

import re
from itertools import pairwise
from pathlib import Path

import pytest
from server_clients import Clients, options, serving, wait_for

from rcss_hat.viewer.recording import read_recording

NUMBER = r"-?\d+(?:\.\d+)?(?:e[+-]\d+)?"
PLAYER = re.compile(
    rf" \(\(([lr] \d+)\) \d+ (?:0|0x[0-9a-f]+)(?: {NUMBER}){{6}}(?: {NUMBER} {NUMBER})? \(v [hl] {NUMBER}\)"
    rf"( \(fp {NUMBER} {NUMBER}\))? \(s((?: {NUMBER})+)\)(?: \(f [lr] \d+\))? \(c((?: \d+)+)\)\)"
)
SHOW = re.compile(rf"\(show \d+ \(\(b\)(?: {NUMBER}){{4}}\)(.*)\)")
EVERYBODY = [f"{side} {unum}" for side in "lr" for unum in range(1, 12)]
FORMS = {4: (False, 3, 11), 5: (False, 4, 11), 6: (True, 4, 12)}
"""Focus point, stamina values and counters of a player in each version of the game log."""
KEEPAWAY_HEADER = 11
"""kwyzipper skips so many lines; the others skip what begins with #, and one line more."""


def play(clients: Clients) -> None:
    """Play until two episodes have ended with the ball out."""
    players = [clients.player(team) for team in ("keepers", "keepers", "keepers", "takers", "takers")]
    monitor = clients.monitor()
    monitor.send("(dispstart)")
    pause(clients)
    for number in (1, 2):
        players[0].send('(turn 30)(say "a)(\\"b")')
        monitor.send("(dispfoul 320 320 0)")
        wait_for(lambda ended=number: clients.server.game.match["episode"][0] > ended)
        pause(clients)


def pause(clients: Clients) -> None:
    """Let the match go on for some cycles: of an episode without a frame no log tells."""
    begin = clients.server.game.time
    wait_for(lambda: clients.server.game.time > begin + 3)


@pytest.fixture(params=FORMS)
def log(request: pytest.FixtureRequest, tmp_path: Path) -> tuple[int, Path]:
    """Version of the game log, and the folder with the logs of a match."""
    logs = {f"{kind}_log_dir": str(tmp_path) for kind in ("game", "text", "keepaway")}
    logs |= dict.fromkeys(("game_logging", "text_logging", "keepaway_logging", "record_messages", "keepaway"), True)
    with serving(options(simulator_step=20, half_time=-1, game_log_version=request.param, **logs)) as clients:
        play(clients)
    return request.param, tmp_path


def test_logs_are_as_their_readers_want_them(log: tuple[int, Path]) -> None:
    version, folder = log
    (game,), (text,), (keepaway,) = (
        list(folder.glob(f"*-keepers_0-vs-takers_0.{end}")) for end in ("rcg", "rcl", "kwy")
    )
    check_game_log(game.read_text().splitlines(), version)
    check_keepaway_log(keepaway.read_text())
    for line in text.read_text().splitlines():
        assert re.fullmatch(r"\d+,\d+\t(Recv (keepers|takers)_\d: .*|\(referee .*\))", line)
    recording = read_recording(game)
    assert recording.skipped == 0 and [episode.number for episode in recording.episodes] == [1, 2]


def check_game_log(lines: list[str], version: int) -> None:
    kinds = [re.match(r"\(?(\w+)", line)[1] for line in lines]  # type: ignore[index]
    assert kinds[:21] == [f"ULG{version}", "server_param", "player_param", *["player_type"] * 18]
    assert set(kinds[21:]) == {"playmode", "team", "show", "msg"}
    assert all(line.startswith("(") and line.endswith(")") for line in lines[1:])
    assert kinds.index("playmode") < kinds.index("team") < kinds.index("show")
    shows = [line for line in lines if line.startswith("(show ")]
    times = [int(line.split(" ", 2)[1]) for line in shows]
    assert times[0] == 1 and all(after - before in (0, 1) for before, after in pairwise(times))
    for line in shows:
        check_show(line, *FORMS[version])


def check_show(line: str, focus_point: bool, stamina: int, counts: int) -> None:
    players = SHOW.fullmatch(line)[1]  # type: ignore[index]
    found = list(PLAYER.finditer(players))
    assert "".join(player[0] for player in found) == players
    assert [player[1] for player in found] == EVERYBODY
    for player in found:
        assert (bool(player[2]), len(player[3].split()), len(player[4].split())) == (focus_point, stamina, counts)


def check_keepaway_log(text: str) -> None:
    lines = text.splitlines()
    header, episodes = lines[:KEEPAWAY_HEADER], [line.split("\t") for line in lines[KEEPAWAY_HEADER:]]
    assert all(line.startswith("#") for line in header)
    for line, form in zip(header, (r"# Keepers: \d+", r"# Takers:  \d+", r"# Region:  \d+ x \d+"), strict=False):
        assert re.fullmatch(form, line)
    assert text.endswith("\n") and len(episodes) == 2
    start = 0
    for number, (episode, begin, end, duration, reason) in enumerate(episodes, 1):
        assert (int(episode), int(begin), int(duration), reason) == (number, start, int(end) - start, "o")
        start = int(end)
