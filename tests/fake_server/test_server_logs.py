"""Logs: what is in them, and what they are called while running and afterwards."""

from __future__ import annotations

import gzip
import re
import time
from pathlib import Path

import numpy as np
import pytest
from recorded_state import frames

from fake_server.logs import LogError, Logs
from rcss_hat.keepaway.report import read_kwy
from rcss_hat.protocol.params import ServerParams, Value
from rcss_hat.simulation.state import BEFORE_KICK_OFF, PLAY_ON, TIME_OVER, new_match

START = time.mktime((2026, 11, 22, 14, 30, 5, 0, 0, -1))
TEAMS = ("keepers", "takers")


def params(folder: Path, **changes: Value) -> ServerParams:
    folders = {f"{kind}_log_dir": str(folder) for kind in ("game", "text", "keepaway")}
    return ServerParams(keepaway=True, **folders | changes)


def playing(mode: int = PLAY_ON, cycle: int = 0) -> np.ndarray:
    match = new_match(ServerParams().record())
    match["mode"], match["time"] = mode, cycle
    return match


def test_names_while_running_and_at_the_end(tmp_path: Path) -> None:
    logs = Logs(params(tmp_path), [], START)
    assert {path.name for path in tmp_path.iterdir()} == {"incomplete.kwy", "incomplete.rcg", "incomplete.rcl"}
    logs.close(playing(), TEAMS)
    stem = "20261122143005-keepers_0-vs-takers_0"
    assert {path.name for path in tmp_path.iterdir()} == {f"{stem}.{end}" for end in ("kwy", "rcg", "rcl")}


def test_names_without_date_and_team(tmp_path: Path) -> None:
    logs = Logs(params(tmp_path, keepaway_log_dated=False, game_logging=False, text_logging=False), [], START)
    logs.close(playing(), ("keepers", ""))
    assert [path.name for path in tmp_path.iterdir()] == ["keepers_0-vs-null.kwy"]


def test_fixed_names_stand_from_the_start(tmp_path: Path) -> None:
    fixed = {"keepaway_log_fixed": True, "keepaway_log_fixed_name": "k", "game_logging": False, "text_logging": False}
    logs = Logs(params(tmp_path / "new" / "folder", **fixed), [], START)
    logs.keepaway_header(3, 2)
    assert logs.paths == [tmp_path / "new" / "folder" / "k.kwy"]
    logs.close(playing(), TEAMS)
    assert logs.paths[0].read_text().startswith("# Keepers: 3\n# Takers:  2\n# Region:  20 x 20\n#\n")


def test_team_names_cannot_leave_the_folder(tmp_path: Path) -> None:
    logs = Logs(params(tmp_path, game_logging=False, text_logging=False), [], START)
    logs.close(playing(), ("/../../x", "takers"))
    assert [path.name for path in tmp_path.iterdir()] == ["20261122143005-_.._.._x_0-vs-takers_0.kwy"]


def test_keepaway_log_is_read_back_while_it_is_written(tmp_path: Path) -> None:
    logs = Logs(params(tmp_path, game_logging=False, text_logging=False), [], START)
    logs.keepaway_header(3, 2)
    logs.episode(1, 0, 212, True)
    logs.episode(2, 212, 350, False)
    assert [tuple(episode) for episode in map(_fields, read_kwy(logs.paths[0]))] == [
        (1, 0, 212, "t"),
        (2, 212, 350, "o"),
    ]
    logs.close(playing(), TEAMS)


def _fields(episode: object) -> tuple[int, int, int, str]:
    return episode.number, episode.start, episode.end, episode.reason  # type: ignore[attr-defined]


@pytest.mark.parametrize("version", [4, 5, 6])
def test_game_log_has_the_recorded_lines(tmp_path: Path, version: int) -> None:
    logs = Logs(params(tmp_path, game_log_version=version), ["(server_param (a 1))"], START)
    kernel = ServerParams().record()
    for mode, cycle in ((BEFORE_KICK_OFF, 0), (PLAY_ON, 1), (PLAY_ON, 2), (TIME_OVER, 2), (TIME_OVER, 2)):
        logs.show(playing(mode, cycle), kernel, TEAMS)
    logs.close(playing(TIME_OVER, 2), TEAMS)
    lines = next(tmp_path.glob("*.rcg")).read_text().splitlines()
    shape = [re.sub(r"(\(show \d+).*", r"\1", line) for line in lines]
    assert shape == [
        f"ULG{version}",
        "(server_param (a 1))",
        "(playmode 1 play_on)",
        "(team 1 keepers takers 0 0)",
        "(show 1",
        "(show 2",
        "(playmode 2 time_over)",
        "(show 2",
        '(msg 2 1 "(result 202611221430 keepers_0-vs-takers_0)")',
        "(team 2 keepers takers 0 0)",
    ]
    samples = [frame["text"] for frame in frames() if frame.get("log") == version]
    kinds = [re.sub(r"\d+", "0", line) for line in shape if not line.startswith(("(show", "(server"))]
    assert {re.sub(r"\d+", "0", text) for text in samples if not text.startswith("(show")} <= set(kinds)


def test_old_game_log_versions_are_written_as_the_oldest_text_version(tmp_path: Path) -> None:
    Logs(params(tmp_path, game_log_version=3), [], START).close(playing(), TEAMS)
    assert next(tmp_path.glob("*.rcg")).read_text().startswith("ULG4\n")


def test_compressed_game_log(tmp_path: Path) -> None:
    Logs(params(tmp_path, game_log_compression=6), ["(x)"], START).close(playing(), TEAMS)
    with gzip.open(next(tmp_path.glob("*.rcg.gz")), "rt") as lines:
        assert lines.readline() == "ULG6\n"


def test_text_log_and_recorded_messages(tmp_path: Path) -> None:
    logs = Logs(params(tmp_path, record_messages=True), [], START)
    waiting, match = playing(BEFORE_KICK_OFF), playing(PLAY_ON, 3)
    waiting["stopped"] = 7
    logs.received(waiting, "keepers_1", "(init keepers (version 11))")
    logs.referee(waiting, "before_kick_off")
    logs.referee(match, "play_on")
    logs.received(match, "keepers_2", "(turn 17)(turn_neck 30)")
    logs.speech(match, "(player keepers 1)", "hi")
    logs.substitution(match, "(change_player_type l 3 2)")
    logs.close(match, TEAMS)
    assert next(tmp_path.glob("*.rcl")).read_text().splitlines() == [
        "0,7\tRecv keepers_1: (init keepers (version 11))",
        "0,7\t(referee before_kick_off)",
        "3,0\t(referee play_on)",
        "3,0\tRecv keepers_2: (turn 17)(turn_neck 30)",
    ]
    assert next(tmp_path.glob("*.rcg")).read_text().splitlines()[1:-2] == [
        '(msg 0 2 "Recv keepers_1: (init keepers (version 11))")',
        '(msg 3 1 "(referee play_on)")',
        '(msg 3 2 "Recv keepers_2: (turn 17)(turn_neck 30)")',
        '(msg 3 1 "((player keepers 1) hi)")',
        '(msg 3 2 "(change_player_type l 3 2)")',
    ]


def test_nothing_is_written_when_everything_is_off(tmp_path: Path) -> None:
    logs = Logs(params(tmp_path, game_logging=False, text_logging=False, keepaway_logging=False), [], START)
    assert not logs.wants_messages
    logs.referee(playing(), "play_on")
    logs.close(playing(), TEAMS)
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_cannot_be_made_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(LogError, match=r"cannot write the game log .*file/incomplete.rcg"):
        Logs(params(tmp_path / "file"), [], START)
