"""Matches refilled from recorded messages, so that what is written from them can be compared with what was recorded."""

from __future__ import annotations

import base64
import gzip
import json
import re
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from rcss_hat.protocol.messages.fullstate import _FULL_ORDER
from rcss_hat.protocol.play_modes import PLAY_MODE_IDS
from rcss_hat.protocol.records import HIGH, LEFT, LOW, NARROW, NORMAL, RIGHT, WIDE
from rcss_hat.simulation.state import C_CHANGE_FOCUS, C_POINTTO, MATCH

DATA = Path(__file__).parent.parent / "data"
WIDTHS = {"narrow": NARROW, "normal": NORMAL, "wide": WIDE}


class Message(NamedTuple):
    file: str
    client: str
    team: str
    dir: str
    text: str


@cache
def recorded() -> tuple[Message, ...]:
    with gzip.open(DATA / "protocol" / "messages.jsonl.gz", "rt") as lines:
        return tuple(Message(**json.loads(line)) for line in lines)


def received(start: str) -> list[Message]:
    """What clients got that begins with a text; players below version 8 are not served."""
    return [m for m in recorded() if m.dir == "recv" and m.text.startswith(start) and version_of(m) >= 8]


def version_of(message: Message) -> int:
    version = re.search(r"_v(\d+)$", message.client)
    if message.client.startswith("monitor"):
        return 99
    if version:
        return int(version[1])
    return {"k_none": 3, "k_again": 3}.get(message.client, 12 if "v12" in message.file else 11)


def index_of(message: Message) -> int:
    """Index of the player who got a message, from his init reply, or else from his name."""
    replies = [m for m in recorded() if (m.file, m.client) == message[:2] and re.match(r"\(init [lr] \d", m.text)]
    if replies:
        _, side, unum, *_ = replies[0].text.split()
        return (0 if side == "l" else 11) + int(unum) - 1
    return (0 if message.client[0] == "k" else 11) + int(message.client[1]) - 1


@cache
def frames() -> tuple[dict[str, Any], ...]:
    """Lines of game logs (``log``: version) and binary datagrams (``monitor``: version, ``mode``, ``data``)."""
    with gzip.open(DATA / "fake_server" / "frames.jsonl.gz", "rt") as lines:
        found = [json.loads(line) for line in lines]
    for frame in found:
        if "base64" in frame:
            frame["data"] = base64.b64decode(frame["base64"])
    return tuple(found)


def numbers(text: str) -> list[float]:
    return [float(word) for word in text.split()]


def match_of_show(text: str, visible_angle: float) -> tuple[np.ndarray, tuple[str, str] | None]:
    """Refill a match from a frame; also the teams, where the frame has them."""
    match = np.zeros(1, dtype=MATCH)
    match["time"] = int(re.match(r"\(show (\d+)", text)[1])
    head = re.search(r"\(pm (\d+)\) \(tm (\S+) (\S+) (\d+) (\d+)\)", text)
    if head:
        match["mode"] = int(head[1])
        match["score"][0] = int(head[4]), int(head[5])
    ball = numbers(re.search(r"\(\(b\) ([^)]*)\)", text)[1])
    match["ball_pos"][0], match["ball_vel"][0] = ball[:2], ball[2:]
    pattern = (
        r"\(\((l|r) (\d+)\) (\d+) (\w+) ([^(]*) \(v (h|l) (\S+)\)(?: \(fp (\S+) (\S+)\))? \(s ([^)]*)\)"
        r"(?: \(f (l|r) (\d+)\))? \(c ([^)]*)\)\)"
    )
    for found in re.finditer(pattern, text):
        _fill_player(match, found, visible_angle)
    teams = (head[2].replace("null", ""), head[3].replace("null", "")) if head else None
    return match, teams


def _fill_player(match: np.ndarray, found: re.Match[str], visible_angle: float) -> None:
    i = (0 if found[1] == "l" else 11) + int(found[2]) - 1
    state = int(found[4], 16)
    row = match[0]
    row["type"][i], row["enabled"][i], row["goalie"][i] = int(found[3]), state & 1, state >> 3 & 1
    row["flags"][i] = state & ~9
    values = numbers(found[5])
    row["pos"][i], row["vel"][i] = values[:2], values[2:4]
    row["body"][i], row["neck"][i] = np.deg2rad(values[4:6])
    if len(values) > 6:
        row["arm_pos"][i], row["arm_expires"][i] = values[6:8], 1
    row["quality"][i] = HIGH if found[6] == "h" else LOW
    times = float(found[7]) / visible_angle
    row["synch_see"][i] = times not in (0.5, 1.0, 2.0)
    row["width"][i] = NARROW if times < 0.9 else NORMAL if times < 1.5 else WIDE
    if found[8]:
        row["focus_dist"][i], row["focus_dir"][i] = float(found[8]), np.deg2rad(float(found[9]))
    stamina = numbers(found[10])
    row["stamina"][i], row["effort"][i], row["recovery"][i] = stamina[:3]
    row["capacity"][i] = stamina[3] if len(stamina) > 3 else 0.0
    if found[11]:
        row["focus_side"][i], row["focus_unum"][i] = LEFT if found[11] == "l" else RIGHT, int(found[12])
    counts = [int(count) for count in found[13].split()]
    row["counts"][i][: len(counts)] = counts


def match_of_fullstate(text: str, i: int, version: int) -> np.ndarray:
    """Refill a match from the fullstate message of player ``i``."""
    match = np.zeros(1, dtype=MATCH)
    row = match[0]
    head = re.match(r"\(fullstate (\d+) \(pmode (\w+)\) \(vmode (\w+) (\w+)\) \(count ([^)]*)\)", text)
    row["time"], row["mode"] = int(head[1]), PLAY_MODE_IDS[head[2].replace("goalie_catch_ball", "free_kick")]
    row["quality"][i], row["width"][i] = HIGH if head[3] == "high" else LOW, WIDTHS[head[4]]
    row["version"][i] = version
    counts = [int(count) for count in head[5].split()]
    row["counts"][i][_FULL_ORDER[: len(counts)]] = counts
    arm = re.search(r"\(movable (\d+)\) \(expires (\d+)\) \(target (\S+) (\S+)\) \(count (\d+)\)", text)
    row["arm_movable"][i], row["counts"][i][C_POINTTO] = int(arm[1]), int(arm[5])
    own = 0 if i < 11 else 1
    row["score"][[own, 1 - own]] = [int(v) for v in re.search(r"\(score (\d+) (\d+)\)", text).groups()]
    ball = numbers(re.search(r"\(\(b\) ([^)]*)\)", text)[1])
    row["ball_pos"], row["ball_vel"] = ball[:2], ball[2:]
    pattern = (
        r"\(\(p (l|r) (\d+)( g)?(?: (\d+))?\) ([^(]*)(?: \(focus_point (\S+) (\S+)\))? \(stamina ([^)]*)\)( [tk])?"
    )
    for found in re.finditer(pattern, text):
        _fill_full_player(match, found)
    return match


def _fill_full_player(match: np.ndarray, found: re.Match[str]) -> None:
    j = (0 if found[1] == "l" else 11) + int(found[2]) - 1
    row = match[0]
    row["enabled"][j], row["goalie"][j], row["type"][j] = 1, found[3] is not None, int(found[4] or 0)
    values = numbers(found[5])
    row["pos"][j], row["vel"][j] = values[:2], values[2:4]
    row["body"][j], row["neck"][j] = np.deg2rad(values[4]), np.deg2rad(values[5])
    if len(values) > 6:
        face = row["body"][j] + row["neck"][j] + values[7]
        row["arm_pos"][j] = row["pos"][j] + values[6] * np.array([np.cos(face), np.sin(face)])
        row["arm_expires"][j] = 1
    if found[6]:
        row["focus_dist"][j], row["focus_dir"][j] = float(found[6]), np.deg2rad(float(found[7]))
    stamina = numbers(found[8])
    row["stamina"][j], row["effort"][j], row["recovery"][j] = stamina[:3]
    row["capacity"][j] = stamina[3] if len(stamina) > 3 else 0.0
    row["tackle_cycles"][j], row["kick_cycles"][j] = found[9] == " t", found[9] == " k"


def focus_of_sense_body(text: str, match: np.ndarray, i: int) -> None:
    """Fill in what the SENSE_BODY record does not hold."""
    found = re.search(r"\(change_focus (\d+)\).*\(focus_point (\S+) ([^)]+)\)", text)
    if found:
        match["counts"][0, i, C_CHANGE_FOCUS] = int(found[1])
        match["focus_dist"][0, i] = float(found[2])
        match["focus_dir"][0, i] = np.deg2rad(float(found[3]))
