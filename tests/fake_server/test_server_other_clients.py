"""Clients of other people, as recorded on rcssserver 19.0.0: what they send is answered here as it was there.

See ``tests/data/fake_server/README.md`` for the transcripts. Positions and random draws differ between two matches, so
that see, sense_body and numbers are compared as kinds only; all other messages as they are and in their order.
"""

from __future__ import annotations

import gzip
import json
import re
import time
from collections import defaultdict
from dataclasses import dataclass, field
from pathlib import Path

import pytest
from server_clients import PATIENCE, Client, Clients, options, serving, wait_for

from fake_server.options import ServerOptions
from fake_server.reception import NO_ONLINE_COACH
from rcss_hat.protocol.params import Value

DATA = Path(__file__).parent.parent / "data" / "fake_server"
PERIODIC = ("(see ", "(sense_body", "(show", "(see_global", "(think")
PARAMETERS = ("(server_param", "(player_param", "(player_type")
OF_THE_MACHINE = re.compile(r"port|_dir$|_file$|_start$")
"""Server parameters that say where a server runs and writes, or when a match starts."""


def transcript(name: str) -> list[dict[str, str]]:
    with gzip.open(DATA / name, "rt", encoding="utf-8") as lines:
        return [json.loads(line) for line in lines]


def kind(message: str) -> str:
    """A message without cycles, directions and what is said: these depend on when and where somebody stands."""
    found = re.match(r"\(hear (referee )?-?\d+ (-?\d+ )?(self|our|opp|coach|referee|\(p)", message)
    if found and found[3] != "referee":
        return f"(hear {found[3]}"
    message = re.sub(r"\((hear|hear referee|score|ok check_ball) \d+ ", r"(\1 ", message)
    return message[:8] if message.startswith("(ok look") else message


def answers(messages: list[str]) -> list[str]:
    """Messages that answer somebody or announce something."""
    return [message for message in messages if not message.startswith((*PERIODIC, *PARAMETERS))]


def parameters(messages: list[str], start: str) -> dict[str, str]:
    (message,) = [message for message in messages if message.startswith(start)]
    return dict(re.findall(r"\((\w+) ([^()]*)\)", message))


def same_parameters(received: list[str], recorded: list[str]) -> None:
    wanted, got = parameters(recorded, "(server_param"), parameters(received, "(server_param")
    assert {
        name for name in wanted | got if wanted.get(name) != got.get(name) and not OF_THE_MACHINE.search(name)
    } == set()
    for start in PARAMETERS[1:]:
        assert [m for m in received if m.startswith(start)] == [m for m in recorded if m.startswith(start)]


@dataclass
class Part:
    """What one recorded player sent after each think, and received."""

    name: str
    client: Client
    recorded: list[str] = field(default_factory=list)
    sent: list[list[str]] = field(default_factory=lambda: [[]])
    before: int = 0
    """Thinks before the kick-off."""
    at: int = 0
    """Thinks answered so far."""

    def add(self, direction: str, text: str) -> None:
        if direction == "send":
            self.sent[-1].append(text)
            return
        self.recorded.append(text)
        if text == "(think)":
            self.sent.append([])
        elif text.startswith("(hear 0 referee"):
            self.before = len(self.sent) - 1

    @property
    def ready(self) -> bool:
        return self.at >= self.before

    @property
    def finished(self) -> bool:
        return self.at >= len(self.sent) - 1

    def answer(self, kicked_off: bool) -> None:
        """Say what was said after this think, and done if that is missing: the recorded client was too late."""
        said: list[str] = []
        if not self.finished and (kicked_off or not self.ready):
            self.at += 1
            said = self.sent[self.at]
        for text in said:
            self.client.send(text)
        if not any("(done)" in text for text in said):
            self.client.send("(done)")


def lively(clients: Clients, parts: list[Part]) -> None:
    """Answer all thinks until everything recorded was said; somebody kicks off when everybody is ready."""
    monitor = None
    give_up = time.monotonic() + 3 * PATIENCE
    while not all(part.finished for part in parts):
        assert time.monotonic() < give_up
        if monitor is None and all(part.ready for part in parts):
            monitor = clients.monitor()
            monitor.send("(dispstart)")
        for part in parts:
            for message in part.client.until(r"\((think|hear 0 referee)"):
                if message == "(think)":
                    part.answer(any(heard.startswith("(hear 0 referee") for heard in part.client.got))


def play(clients: Clients, name: str) -> dict[str, Part]:
    """Let recorded players join in their order and play their parts."""
    parts: dict[str, Part] = {}
    for entry in transcript(name):
        if not entry["client"].endswith("coach"):
            who = entry["client"]
            parts.setdefault(who, Part(who, clients.open())).add(entry["dir"], entry["text"])
    for part in parts.values():
        for text in part.sent[0]:
            part.client.send(text)
        part.client.until(r"\(player_type \(id 17\)")
    lively(clients, list(parts.values()))
    return parts


def with_types_of_the_recording(**changes: Value) -> ServerOptions:
    wanted = options(synch_mode=True, **changes)
    wanted.player_params.set("random_seed", 7)
    return wanted


def test_the_second_fork_of_the_keepaway_players() -> None:
    task: dict[str, Value] = {"keepaway": True, "half_time": -1, "use_offside": False, "stamina_inc_max": 3500.0}
    with serving(with_types_of_the_recording(visible_angle=360.0, **task)) as clients:
        for part in play(clients, "keepaway-fork.jsonl.gz").values():
            received = part.client.got
            same_parameters(received, part.recorded)
            spoken = ("(hear self", "(hear our", "(hear opp")
            heard = [[kind(m) for m in answers(messages)] for messages in (received, part.recorded)]
            got, wanted = ([m for m in kinds if m not in spoken] for kinds in heard)
            assert got == wanted
            assert set(heard[0]) == set(heard[1]) >= set(spoken)


def test_pyrus2d() -> None:
    with serving(with_types_of_the_recording()) as clients:
        parts = play(clients, "pyrus2d.jsonl.gz")
        for part in parts.values():
            received = part.client.got
            same_parameters(received, part.recorded)
            # The recorded coach gave his team other types.
            got, wanted = (
                [kind(m) for m in answers(messages) if not m.startswith("(change_player_type")]
                for messages in (received, part.recorded)
            )
            assert got == wanted
            assert "(ok synch_see)" in got and "(hear referee kick_off_l)" in got
        other = answers(parts["OTHER_2"].client.got)
        assert other.index("(change_player_type 2 1)") < other.index("(hear 0 referee kick_off_l)")
        match = clients.server.game.match
        assert (abs(match["pos"][0, [0, 1, 11, 12], 1]) < 34.0).all()  # all four have moved onto the field


@pytest.mark.parametrize("name", ["pyrus2d.jsonl.gz", "rcssclient.jsonl.gz"])
def test_online_coaches_are_refused_whatever_they_say(name: str) -> None:
    said = defaultdict(list)
    for entry in transcript(name):
        if entry["client"].endswith("coach") and entry["dir"] == "send":
            said[entry["client"]].append(entry["text"])
    assert said
    with serving(options()) as clients:
        for texts in said.values():
            coach = clients.open(clients.server.olcoach_port)
            for text in dict.fromkeys(texts):
                coach.send(text)
                assert coach.receive() == NO_ONLINE_COACH


def test_the_sample_client_of_rcssserver() -> None:
    entries = [entry for entry in transcript("rcssclient.jsonl.gz") if entry["client"] not in ("coach", "monitor")]
    wanted = options(coach_w_referee=True, simulator_step=40)
    wanted.player_params.set("random_seed", 7)
    with serving(wanted) as clients:
        doors = {"sample": clients.server.port, "other": clients.server.port, "trainer": clients.server.coach_port}
        opened = {name: clients.open(port) for name, port in doors.items()}
        for entry in entries:
            client, text = opened[entry["client"]], entry["text"]
            if entry["dir"] == "send":
                client.send(text)
                two_steps(clients)
            elif not text.startswith((*PERIODIC, "(server_param")):
                assert kind(next_answer(client)) == kind(text), entry


def two_steps(clients: Clients) -> None:
    """Let what was said take effect: nobody typed two commands within a cycle."""
    match = clients.server.game.match
    for _ in range(2):
        now = int(match["time"][0]), int(match["stopped"][0])
        wait_for(lambda now=now: (int(match["time"][0]), int(match["stopped"][0])) != now)


def next_answer(client: Client) -> str:
    """Next message that is neither periodic nor of the server's parameters."""
    pattern = r"\((?!see |sense_body|show|see_global|think|server_param)"
    return client.until(pattern)[-1]
