"""The players against the UT Austin players: the same perceptions must lead to the same commands.

Both are replayed open loop: every cycle our player gets what theirs got from the server, and then is told what theirs
did. Differences remain where their particle filter and our least squares put the player a few centimetres apart and
a threshold lies in between.
"""

from __future__ import annotations

import gzip
import json
import re
from collections import Counter
from pathlib import Path

import numpy as np
from player.beliefs import PARAMS

from rcss_hat.keepaway import agent as kernels
from rcss_hat.keepaway.policies import hand
from rcss_hat.protocol.records import ACTION, DASH, HEARD, KICK, LEFT, RIGHT, SEE, SENSE_BODY, TURN, empty
from rcss_hat.protocol.see import parse_see
from rcss_hat.protocol.sense_body import parse_sense_body

TRANSCRIPT = Path(__file__).parents[1] / "data" / "keepaway" / "transcript-3v2.jsonl.gz"
ARM = "(arm (movable 0) (expires 0) (target 0 0) (count 0))"
REST = f" {ARM} (focus (target none) (count 0)) (tackle (expires 0) (count 0)))\0"
KINDS = {"dash": DASH, "turn": TURN, "kick": KICK}


def commands(text):
    """Body command, arguments, neck and say of a datagram."""
    kind, a, b = 0, 0.0, 0.0
    if body := re.search(r"\((dash|turn|kick) (-?\d+)(?: (-?\d+))?\)", text):
        kind, a, b = KINDS[body[1]], float(body[2]), float(body[3] or 0)
    neck = re.search(r"\(turn_neck (-?\d+)\)", text)
    say = re.search(r'\(say "(.*)"\)', text)
    return kind, a, b, float(neck[1]) if neck else None, say[1] if say else ""


class Replay:
    """One player's game, cycle by cycle."""

    def __init__(self, name):
        self.side = LEFT if name[0] == "k" else RIGHT
        self.team = b"keepers" if self.side == LEFT else b"takers"
        self.agent = kernels.new_agent(self.side, int(name[1]), 3, 2, PARAMS, 0)
        self.sense, self.see, self.heard, self.action = empty(SENSE_BODY), empty(SEE), empty(HEARD), empty(ACTION)
        self.state = np.zeros(13)
        self.cycles = 0

    def cycle(self, sense, see, heard, started):
        parse_sense_body((sense + REST).encode(), self.sense)
        if self.cycles == 0:
            self.agent["counts"][0] = self.sense["counts"][0]
        if see:
            parse_see((see + "\0").encode(), self.team, self.see)
        self.heard["time"][0] = heard[0] if heard else -1
        if heard:
            text = heard[3].encode()
            self.heard["n"][0] = len(text)
            self.heard["text"][0, : len(text)] = np.frombuffer(text, dtype=np.uint8)
        kernels.perceive(
            self.agent, PARAMS, self.sense, self.see, see is not None, self.heard, bool(started) or self.cycles == 0
        )
        self.cycles += 1
        keeper = self.side == LEFT
        status = kernels.decide(self.agent, self.state).status if keeper else kernels.NO_DECISION
        choice = hand(self.state, 3, 2) if status in (kernels.FIRST, kernels.STEP) else 0
        kernels.act(self.agent, PARAMS, status, choice, self.action)
        if status == kernels.NO_DECISION:
            return "keeper without ball" if self.side == LEFT else "taker"
        return "pass" if choice or status == kernels.FOLLOW_THROUGH else "hold"

    def correct(self, kind, a, b, neck):
        """Remember what the original player sent."""
        for name, value in (("sent_kind", kind), ("sent_a", a), ("sent_b", b), ("sent_neck", neck or 0.0)):
            self.agent[name][0] = value


def angle(a, b):
    return abs((a - b + 180.0) % 360.0 - 180.0)


def close(kind, mine, theirs):
    if kind == KICK:
        return abs(mine[0] - theirs[0]) <= 6 and (angle(mine[1], theirs[1]) <= 10 or theirs[0] < 5)
    return angle(mine[0], theirs[0]) <= 6 if kind == TURN else abs(mine[0] - theirs[0]) <= 10


def test_commands_agree_with_the_original_players():
    seen = Counter()
    players = {}
    with gzip.open(TRANSCRIPT, "rt") as file:
        for line in file:
            name, sense, see, heard, started, sent = json.loads(line)
            replay = players.setdefault(name, Replay(name))
            behaviour = replay.cycle(sense, see, heard, started)
            kind, a, b, neck, say = commands(sent)
            action = replay.action
            same = int(action["kind"][0]) == kind
            seen[behaviour] += 1
            seen[behaviour, "kind"] += same
            seen[behaviour, "close"] += same and close(kind, (action["a"][0], action["b"][0]), (a, b))
            mine = action["neck"][0] if action["turns_neck"][0] else None
            seen["neck"] += (mine is None) == (neck is None) and (mine is None or abs(mine - neck) <= 3)
            text = bytes(action["say"][0, : action["say_n"][0]]).decode()
            seen["say"] += text == say
            seen["units"] += len(text) == len(say)
            replay.correct(kind, a, b, neck)
    total = sum(replay.cycles for replay in players.values())
    assert total == 2100
    for behaviour, least in (("hold", 0.97), ("pass", 0.95), ("keeper without ball", 0.97), ("taker", 0.98)):
        assert seen[behaviour] > 40
        assert seen[behaviour, "kind"] / seen[behaviour] > least
        assert seen[behaviour, "close"] / seen[behaviour] > least - 0.01
    assert seen["neck"] / total > 0.98
    assert seen["units"] / total > 0.98
    # Positions are told in cells of 1.4 m x 0.9 m: a few centimetres change the symbol now and then.
    assert seen["say"] / total > 0.87
