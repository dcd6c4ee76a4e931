"""Game logs in JSON: byte for byte what rcssserver 19.0.0 writes, and readable JSON after a clean stop."""

from __future__ import annotations

import gzip
import json
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from server_clients import options, serving

from fake_server.game_log import JsonForm
from fake_server.logs import Logs
from fake_server.param_text import json_params
from fake_server.player_param import PlayerParams
from rcss_hat.protocol.params import ServerParams
from rcss_hat.protocol.play_modes import PLAY_MODE_IDS
from rcss_hat.protocol.records import HIGH, LEFT, LOW, NARROW, NORMAL, RIGHT, WIDE
from rcss_hat.simulation.player_types import player_types
from rcss_hat.simulation.state import PLAY_ON, new_match

DATA = Path(__file__).parents[1] / "data" / "fake_server" / "game-json.rcg.gz"
LINES = gzip.decompress(DATA.read_bytes()).decode().splitlines()
PARAMS = ServerParams(visible_angle=360.0)
KERNEL = PARAMS.record()
COUNTS = ("kick", "dash", "turn", "catch", "move", "turn_neck", "change_view", "say", "tackle", "pointto")


def recorded(kind: str) -> list[str]:
    return [line.rstrip(",") for line in LINES if line.startswith(f'{{"{kind}"')]


def match_at(entry: dict[str, Any]) -> np.ndarray:
    match = new_match(KERNEL)
    match["time"], match["stopped"] = entry["time"], entry.get("stime", 0)
    return match


def match_of(show: dict[str, Any]) -> np.ndarray:
    """Refill a match from a frame."""
    match = match_at(show)
    row, ball = match[0], show["ball"]
    row["ball_pos"], row["ball_vel"] = (ball["x"], ball["y"]), (ball["vx"], ball["vy"])
    for i, player in enumerate(show["players"]):
        row["type"][i], state = player["type"], player["state"]
        row["enabled"][i], row["goalie"][i], row["flags"][i] = state & 1, state >> 3 & 1, state & ~9
        row["pos"][i], row["vel"][i] = (player["x"], player["y"]), (player["vx"], player["vy"])
        row["body"][i], row["neck"][i] = np.deg2rad(player["body"]), np.deg2rad(player["neck"])
        if "px" in player:
            row["arm_pos"][i], row["arm_expires"][i] = (player["px"], player["py"]), 1
        row["quality"][i] = HIGH if player["vq"] == "h" else LOW
        times = player["vw"] / 360.0
        row["synch_see"][i] = times not in (0.5, 1.0, 2.0)
        row["width"][i] = NARROW if times < 0.9 else NORMAL if times < 1.5 else WIDE
        for name in ("stamina", "effort", "recovery", "capacity"):
            row[name][i] = player[name]
        if "fside" in player:
            row["focus_side"][i], row["focus_unum"][i] = LEFT if player["fside"] == "l" else RIGHT, player["fnum"]
        row["counts"][i] = [player[name] for name in (*COUNTS, "attentionto", "change_focus")]
    return match


@pytest.mark.parametrize("line", recorded("show"), ids=range(len(recorded("show"))))
def test_frames_are_the_original_s(line: str) -> None:
    match = match_of(json.loads(line)["show"])
    assert JsonForm("19.0").show(match, KERNEL) == b",\n" + line.encode()


def test_everything_else_is_the_original_s() -> None:
    form = JsonForm("19.0")
    for line in recorded("msg"):
        entry = json.loads(line)["msg"]
        assert form.message(match_at(entry), entry["board"], entry["message"]) == b",\n" + line.encode()
    for line in recorded("playmode"):
        match = match_at(json.loads(line)["playmode"])
        match["mode"] = PLAY_MODE_IDS[json.loads(line)["playmode"]["mode"]]
        assert form.play_mode(match) == b",\n" + line.encode()
    for line in recorded("team"):
        entry = json.loads(line)["team"]
        match = match_at(entry)
        match["score"] = entry["l"]["score"], entry["r"]["score"]
        assert form.team(match, (entry["l"]["name"] or "", entry["r"]["name"] or "")) == b",\n" + line.encode()


def test_the_head_is_the_original_s() -> None:
    told = [json.loads(line) for line in (recorded("server_param") + recorded("player_param"))]
    params = ServerParams(**told[0]["server_param"])
    player_params = PlayerParams(**told[1]["player_param"])
    types = player_types(params, int(player_params["random_seed"]), player_params.numbers())
    form = JsonForm("19.0")
    start = time.mktime((2026, 11, 28, 15, 38, 11, 0, 0, 0))
    written = form.begin(json_params(params, player_params, types), start).decode().split("\n")
    original = LINES[: len(written)]
    assert written[2][:35] == original[2][:35] == '{"timestamp":"2026-11-28T15:38:11+0'
    assert [line.rstrip(",") for line in written[:2] + written[3:]] == [
        line.rstrip(",") for line in original[:2] + original[3:]
    ]
    assert len(written) == 3 + 2 + len(types)
    assert form.end().decode().split() == LINES[-1:]


@pytest.mark.parametrize("level", [0, 6])
def test_a_log_is_json_once_it_is_closed(tmp_path: Path, level: int) -> None:
    folders = {f"{kind}_log_dir": str(tmp_path) for kind in ("game", "text", "keepaway")}
    params = ServerParams(game_log_version=-1, game_log_compression=level, record_messages=True, **folders)
    logs = Logs(params, ['{"server_param":{"half_time":300}}'], 0.0)
    match = new_match(KERNEL)
    match["mode"] = PLAY_ON
    for cycle in (1, 2):
        match["time"] = cycle
        logs.show(match, KERNEL, ("Red", ""))
        logs.received(match, "Red_1", '(say "a\x1b\xe9\\")')
    running = logs.paths[0]
    if level == 0:  # as the original leaves it when it is killed: the beginning of an array
        assert [json.loads(line.strip(",")) for line in running.read_text().split("\n")[1:]]
        with pytest.raises(ValueError, match="delimiter"):
            json.loads(running.read_text())
    logs.close(match, ("Red", ""))
    path = next(tmp_path.glob("*.rcg*"))
    data = gzip.decompress(path.read_bytes()) if level else path.read_bytes()
    kinds = [next(iter(entry)) for entry in json.loads(data)]
    assert kinds == [
        *("version", "timestamp", "server_param", "playmode", "team", "show", "msg", "show", "msg", "msg", "team"),
    ]


def test_a_server_writes_its_parameters(tmp_path: Path) -> None:
    wanted = options(game_logging=True, game_log_version=-1, game_log_dir=str(tmp_path), game_log_fixed=True)
    with serving(wanted):
        pass
    log = json.loads((tmp_path / "rcssserver.rcg").read_text())
    assert log[2]["server_param"]["game_log_version"] == -1
    assert [entry["player_type"]["id"] for entry in log[4:22]] == list(range(18))
