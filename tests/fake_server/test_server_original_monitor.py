"""What rcssmonitor 19.0.1 sends and was told by rcssserver 19.0.0, against this server's answers."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest
from server_clients import Client, Clients, options, serving, wait_for

RECORDED = Path(__file__).parent.parent / "data" / "fake_server" / "rcssmonitor.jsonl"
SESSIONS = {"keepaway": {"keepaway": True, "keepaway_start": -1}, "coach": {"coach_w_referee": True}}
TEAMS = {"l": ("keepers", 3), "r": ("takers", 2)}
IN_THE_GAME_OR_CARDS = 0x1 | 0x40000 | 0x80000
MOST_FRAMES = 5


def exchanges(session: str) -> list[dict[str, Any]]:
    return [e for e in map(json.loads, RECORDED.read_text().splitlines()) if e["session"] == session]


def shown(frame: str) -> dict[str, Any]:
    """The frame as the recording has it, without what chance decides: the steps in which players collide."""
    states = re.findall(r"\(\(([lr] \d+)\) \d+ (0x\w+) ", frame)
    mode, *ball = re.match(r"\(show \d+ \(pm (\d+)\) \(tm keepers takers 0 0\) \(\(b\) (\S+) (\S+) ", frame).groups()  # type: ignore[union-attr]
    return {
        "mode": int(mode),
        "ball": [float(number) for number in ball],
        "states": {who.replace(" ", ""): int(state, 16) & IN_THE_GAME_OR_CARDS for who, state in states},
    }


def wanted(then: dict[str, Any]) -> dict[str, Any]:
    states = {who: int(state, 16) & IN_THE_GAME_OR_CARDS for who, state in then["states"].items()}
    return {**then, "states": states}


def answers(monitor: Client, then: dict[str, Any]) -> list[str]:
    """Messages up to the first frame that shows what the original showed next; a frame or two may be on their way."""
    told: list[str] = []
    for _ in range(MOST_FRAMES):
        *messages, frame = monitor.until(r"\(show ")
        told += map(brief, messages)
        if shown(frame) == wanted(then):
            return told
    raise AssertionError(f"{shown(frame)} instead of {wanted(then)}")


def brief(message: str) -> str:
    """The text of a (msg ...); of the parameters only what they are."""
    text = re.fullmatch(r'\(msg \d+ 1 "(.*)"\)', message)
    return text[1] if text else message[1:].split(" ", 1)[0]


def join(clients: Clients) -> None:
    for team, size in TEAMS.values():
        for _ in range(size):
            clients.player(team)


@pytest.mark.parametrize("session", SESSIONS)
def test_the_original_monitor_is_answered_as_by_the_original_server(session: str) -> None:
    with serving(options(half_time=-1, simulator_step=25, **SESSIONS[session])) as clients:
        join(clients)
        monitor = clients.open()
        for exchange in exchanges(session):
            for command in exchange["sent"]:
                monitor.send(command)
            if exchange["then"] is not None:
                assert (exchange["sent"], answers(monitor, exchange["then"])) == (exchange["sent"], exchange["told"])
        wait_for(lambda: clients.server.clients.monitors == [])
