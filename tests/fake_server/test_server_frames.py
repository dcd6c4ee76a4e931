"""Frames of monitors and game logs are written as they were recorded."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest
from recorded_state import frames, match_of_show, recorded

from fake_server import show
from fake_server.player_param import PlayerParams
from rcss_hat.protocol.digits import ascii_bytes
from rcss_hat.protocol.messages import binary
from rcss_hat.protocol.messages.show import MAX_SHOW
from rcss_hat.protocol.messages.show_json import json_message
from rcss_hat.protocol.params import ServerParams
from rcss_hat.simulation.player_types import player_types
from rcss_hat.simulation.state import MATCH, new_match

BUFFER = np.zeros(MAX_SHOW, dtype=np.uint8)
ANGLES = {"transcript-v11-keepaway-360-synch-trainer-monitor": 360.0}


def write(text: str, version: int, angle: float) -> str:
    match, teams = match_of_show(text, angle)
    head = show.monitor_head(int(match["mode"][0]), teams, tuple(match["score"][0])) if teams else ""
    size = show.write_show(match, ServerParams(visible_angle=angle).record(), version, ascii_bytes(head), BUFFER)
    return BUFFER[:size].tobytes().decode("ascii")


def test_frames_of_text_monitors() -> None:
    versions = set()
    for message in recorded():
        if message.text.startswith("(show ") and message.dir == "recv":
            version = int(message.client[-1])
            angle = next((angle for file, angle in ANGLES.items() if file in message.file), 90.0)
            assert write(message.text, version, angle) == message.text
            versions.add(version)
    assert versions == {3, 4, 5}


def test_frames_of_game_logs() -> None:
    logs = [frame for frame in frames() if "log" in frame and frame["text"].startswith("(show")]
    assert {frame["log"] for frame in logs} == {4, 5, 6}
    for frame in logs:
        angle = 360.0 if frame["log"] == 5 else 90.0
        assert write(frame["text"], frame["log"] - 1, angle) == frame["text"]


def _recorded_frames(version: int) -> list[np.ndarray]:
    dtype = binary.SHOW_1 if version == 1 else binary.SHOW_2
    found = [f["data"] for f in frames() if f.get("monitor") == version and f["mode"] == binary.SHOW_MODE]
    return [np.frombuffer(data.ljust(dtype.itemsize, b"\0"), dtype=dtype) for data in found]


def test_binary_frames_have_the_recorded_layout() -> None:
    match = new_match(ServerParams().record())
    for version, frame in (
        (1, show.show_1(match, ServerParams().record(), ("", ""))),
        (2, show.show_2(match, ServerParams().record(), ("", ""))),
    ):
        dtype = binary.SHOW_1 if version == 1 else binary.SHOW_2
        own = np.frombuffer(frame, dtype=dtype)
        assert len(frame) == dtype.itemsize
        (first, *_), bench = _recorded_frames(version), slice(4, 11)
        field = "pos" if version == 1 else "players"
        start = 1 if version == 1 else 0
        # players 5 to 11 never connected: the same in the recording and in a new match
        recorded_bench, own_bench = (f[field][0, start:][bench] for f in (first, own))
        for name in recorded_bench.dtype.names:
            assert np.array_equal(recorded_bench[name], own_bench[name]), name
        assert first["mode"] == own["mode"] == 1


def test_binary_frames_hold_what_the_match_holds() -> None:
    for recorded_frame in _recorded_frames(2):
        match = np.zeros(1, dtype=MATCH)
        players = recorded_frame["players"][0]
        match["time"], match["mode"] = recorded_frame["time"], recorded_frame["pmode"]
        match["ball_pos"][0], match["ball_vel"][0] = np.split(recorded_frame["ball"][0] / 65536.0, 2)
        for name in ("pos", "vel", "body", "neck", "stamina", "effort", "recovery"):
            match[name][0] = players[name] / 65536.0
        match["enabled"][0], match["quality"][0], match["width"] = players["state"] & 1, players["quality"], 1
        match["flags"][0] = players["state"] & ~1
        match["counts"][0][:, binary._COUNTS_2] = players["counts"]
        teams = tuple(name.decode() for name in recorded_frame["teams"]["name"][0])
        frame = np.frombuffer(show.show_2(match, ServerParams().record(), teams), dtype=binary.SHOW_2)
        assert frame.tobytes()[:44] == recorded_frame.tobytes()[:44]
        for name in players.dtype.names:
            assert np.array_equal(frame["players"][0][name], players[name]), name


def test_binary_parameters() -> None:
    data = {(f["mode"], int.from_bytes(f["data"][4:6], "big")): f["data"] for f in frames() if f.get("monitor") == 2}
    options = {"coach_w_referee": True, "synch_mode": True, "synch_offset": 80, "keepaway": True, "half_time": -1}
    options |= {"use_offside": False, "forbid_kick_off_offside": False, "fullstate_l": True}
    params = ServerParams(**options)
    server = next(d for (mode, _), d in data.items() if mode == binary.SERVER_MODE)
    assert binary.server_params(params)[: len(server)] == server
    recorded_params = next(d for (mode, _), d in data.items() if mode == binary.PLAYER_MODE)
    seed = int.from_bytes(recorded_params[76:80], "big")
    # what the structures leave free holds left-overs in the recording
    own = binary.player_params(PlayerParams(random_seed=seed))
    assert own[:10] == recorded_params[:10]
    assert own[12:112] == recorded_params[12:112]
    types = player_types(params, seed)
    for number in (0, 1):
        recorded_type = data[(binary.TYPE_MODE, number)]
        assert binary.player_type(types, number)[8 : len(recorded_type)] == recorded_type[8:]


def test_binary_messages() -> None:
    for version in (1, 2):
        for frame in [f for f in frames() if f.get("monitor") == version and f["mode"] == binary.MESSAGE_MODE]:
            start = 2 if version == 1 else 4
            text = frame["data"][start + 2 :].split(b"\0")[0].decode()
            own = binary.message(version, show.MESSAGE_BOARD, text)
            assert own[start : len(frame["data"])] == frame["data"][start:]
            assert own[:2] == frame["data"][:2]


def test_json_frame_holds_the_same_numbers_as_the_text_frame() -> None:
    params = ServerParams().record()
    shows = [m for m in recorded() if m.text.startswith("(show ") and m.client == "monitor_v5"]
    for message in shows[:3]:
        angle = next((angle for file, angle in ANGLES.items() if file in message.file), 90.0)
        match, teams = match_of_show(message.text, angle)
        params["visible_angle"] = angle
        frame = json.loads(show.json_show(match, params, "play_on", teams))["show"]
        assert [player["unum"] for player in frame["players"]] == [*range(1, 12), *range(1, 12)]
        assert frame["team"]["l"] == {"name": teams[0], "score": int(match["score"][0, 0])}
        for player, found in zip(
            frame["players"], re.findall(r"\(\([lr] \d+\) \d+ \w+ (\S+) (\S+)", message.text), strict=True
        ):
            assert (player["x"], player["y"]) == pytest.approx(tuple(map(float, found)))


def test_json_message() -> None:
    match = np.zeros(1, dtype=MATCH)
    match["time"], match["stopped"] = 5, 2
    message = json.loads(json_message(match, 1, 'say "hi"'))["msg"]
    assert message == {"time": 5, "stime": 2, "board": 1, "message": 'say "hi"'}
