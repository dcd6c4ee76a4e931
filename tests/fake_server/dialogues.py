"""Dialogues with a server: the same commands, cycle by cycle, to rcssserver and to fake-rcssserver.

A dialogue is played in synch mode. After every step all that everybody was told is collected, then trainer, monitors
and players command in this order, each waiting for a reply, and everybody is done. Noise is switched off, so that all
numbers can be compared but those of see messages; clients that see out of step are not asked what they see.
"""

from __future__ import annotations

import gzip
import json
import re
import socket
import time
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from rcss_hat.protocol.messages import binary
from rcss_hat.protocol.params import Value

PATIENCE = 20.0
QUIET: dict[str, Value] = {
    "synch_mode": True, "synch_offset": 60, "player_rand": 0.0, "ball_rand": 0.0, "kick_rand": 0.0, "wind_rand": 0.0,
    "catch_probability": 1.0, "tackle_rand_factor": 0.0, "game_logging": False, "text_logging": False,
    "keepaway_logging": False, "send_comms": True, "use_offside": False, "back_passes": False,
}  # fmt: skip
GONE = "gone"
"""Said by a player who has been taken out: not sent, but nobody waits for him any more."""
_CHOSEN_BY_CHANCE = re.compile(r"^\(hear (\d+) (-?\d+ )?(our|opp)\b.*")
"""Of several speakers in a cycle one is heard, and it is drawn which."""
OWN_WARNING = "not judged here"
_PARAMETERS = ("(server_param", "(player_param", "(player_type")
_JSON_PARAMETERS = ('{"server_param"', '{"player_param"', '{"player_type"')


PLAYER_PARAMETERS: dict[str, Value] = {"random_seed": 7, "allow_mult_default_type": True}
"""The same types on both servers, and everybody of the default one."""
Told = dict[str, list[str]]
"""What everybody was told in a cycle, by name."""


@dataclass
class Dialogue:
    """Who takes part, and what everybody says in every cycle.

    Attributes
    ----------
    server : dict
        Parameters besides QUIET.
    clients : dict
        First datagram of everybody by name, in the order of joining; names of trainers begin with trainer, those of
        monitors with monitor.
    cycles : list of dict
        Datagrams by name. Who is not in `clients` joins with his first one.
    """

    name: str
    server: dict[str, Value]
    clients: dict[str, str]
    cycles: list[dict[str, list[str]]] = field(default_factory=list)
    drawn: set[int] = field(default_factory=set)
    """Cycles after which places have been drawn, so that no numbers are compared."""

    def then(self, idle: int = 0, **said: str | list[str]) -> Dialogue:
        """Add a cycle in which somebody says something, and some in which nobody does."""
        self.cycles.append({name: [text] if isinstance(text, str) else text for name, text in said.items()})
        self.cycles += [{}] * idle
        return self

    def then_drawn(self, cycles: int, **said: str | list[str]) -> Dialogue:
        """Add so many cycles in which everybody stands where chance has put him."""
        self.drawn |= set(range(len(self.cycles), len(self.cycles) + cycles))
        return self.then(cycles - 1, **said)

    @property
    def n_commands(self) -> int:
        return sum(len(texts) for cycle in self.cycles for texts in cycle.values())


class Speaker:
    """A client of a dialogue."""

    def __init__(self, name: str, init: str, ports: tuple[int, int]) -> None:
        self.name, self.init = name, init
        version = re.search(r"version (-?\d+)", init)
        self.version = int(version[1]) if version else 1
        self.is_trainer, self.is_monitor = name.startswith("trainer"), name.startswith("monitor")
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.address = ("127.0.0.1", ports[1] if self.is_trainer else ports[0])
        self.told: list[str] = []
        self.thinks = 0
        self.eye = not (self.is_trainer or self.is_monitor)
        """Whether he is asked to think."""

    def send(self, text: str) -> None:
        self.socket.sendto(text.encode("latin-1") + b"\0", self.address)

    def take(self, timeout: float) -> str | None:
        """Take the next message, None when there is none in time."""
        self.socket.settimeout(timeout)
        try:
            data, self.address = self.socket.recvfrom(8192)
        except OSError:
            return None
        text = self._text(data)
        if text == "(think)":
            self.thinks += 1
        else:
            self.told.append(text)
        return text

    def _text(self, data: bytes) -> str:
        if not (self.is_monitor and self.version in (1, 2)):
            return data.rstrip(b"\0").decode("latin-1")
        mode = int.from_bytes(data[:2], "big")
        if mode == binary.MESSAGE_MODE:
            return data[6 if self.version == 2 else 4 :].split(b"\0")[0].decode("latin-1")
        if mode != binary.SHOW_MODE:
            return f"(binary {mode})"
        dtype = binary.SHOW_1 if self.version == 1 else binary.SHOW_2
        frame = np.frombuffer(data.ljust(dtype.itemsize, b"\0"), dtype=dtype)[0]
        states = frame["pos"]["enable"][1:] if self.version == 1 else frame["players"]["state"]
        return f"(show {frame['time']} {frame['pmode']} {' '.join(f'{int(state):x}' for state in states)})"

    def until(self, pattern: str) -> str:
        """Take messages up to one that matches, and forget it."""
        give_up = time.monotonic() + PATIENCE
        while time.monotonic() < give_up:
            text = self.take(0.1)
            if text is not None and text != "(think)" and re.match(pattern, text):
                self.told.pop()
                return text
        raise AssertionError(f"{self.name}: no {pattern} in {self.told[-5:]}")

    def say(self, text: str) -> None:
        """Send a datagram and wait until it has been read."""
        if text != GONE:
            self.send(text)
        if text in (GONE, "(bye)", "(dispbye)"):
            self.eye = False
            return
        if self.is_trainer and text.startswith("(eye "):
            self.eye = text == "(eye on)"
        if self.is_monitor:
            self.send("(check_ball)")
            self.until(r'.*((check_ball \d+ \w+|illegal_command_form)\)("|$)).*')
        elif self.is_trainer:
            self.send("(check_ball)")
            self.until(r"\(ok check_ball")
        else:
            self.send("(score)")
            self.until(r"\(score")

    def bucket(self) -> list[str]:
        """Take all that he was told, made comparable."""
        while self.take(0.0) is not None:
            continue
        told, self.told = self.told, []
        return [text for text in map(self._normal, told) if text]

    def _normal(self, text: str) -> str:
        """Return a message without what depends on when somebody joined; nothing if that is all of it."""
        if text.startswith(("(see ", *_PARAMETERS, *_JSON_PARAMETERS, "(binary")) or OWN_WARNING in text:
            return ""
        text = re.sub(r"-?\d(\.\d+)?e-1\d\b", "0", text)  # the last bits differ
        text = _CHOSEN_BY_CHANCE.sub(
            lambda found: f"(hear {found[1]} {'full' if found[2] else 'part'} {found[3]})", text
        )
        return re.sub(r'"time":0,"stime":\d+', '"time":0,"stime":0', text)


class Conversation:
    """A dialogue on a server.

    Parameters
    ----------
    dialogue : Dialogue
    ports : tuple of int
        For players and monitors, and for trainers.
    """

    def __init__(self, dialogue: Dialogue, ports: tuple[int, int]) -> None:
        self._dialogue, self._ports = dialogue, ports
        self._speakers: dict[str, Speaker] = {}

    def run(self) -> list[Told]:
        """Play the dialogue; returns what everybody was told before the first cycle and after each."""
        try:
            for name, init in self._dialogue.clients.items():
                self._join(name, init)
            self._meet()
            for speaker in self._speakers.values():
                speaker.bucket()
            told = []
            for cycle in self._dialogue.cycles:
                for name, texts in self._in_order(cycle):
                    self._speak(name, texts)
                self._finish_cycle()
                heard = {name: speaker.bucket() for name, speaker in self._speakers.items()}
                told.append(_without_numbers(heard) if len(told) in self._dialogue.drawn else heard)
            return told
        finally:
            for speaker in self._speakers.values():
                speaker.socket.close()

    def _in_order(self, cycle: dict[str, list[str]]) -> Iterable[tuple[str, list[str]]]:
        """Trainer, monitors, left and right players: as the stand-in carries commands out."""
        return sorted(cycle.items(), key=lambda item: (not item[0].startswith("t"), not item[0].startswith("m"), item))

    def _speak(self, name: str, texts: list[str]) -> None:
        if name not in self._speakers:
            self._join(name, texts[0], thinking=True)
            texts = texts[1:]
        for text in texts:
            self._speakers[name].say(text)

    def _join(self, name: str, init: str, thinking: bool = False) -> None:
        speaker = self._speakers[name] = Speaker(name, init, self._ports)
        speaker.send(init)
        give_up = time.monotonic() + PATIENCE
        while not any(re.search(r"player_type[\" ]|\(error|\(binary|\(show", text) for text in speaker.told):
            speaker.take(0.02)
            if not thinking:
                self._answer_thinks()
            assert time.monotonic() < give_up, f"{name} is not answered"
        if any("(error" in text for text in speaker.told):
            speaker.eye = False
        elif thinking:
            speaker.take(0.05)

    def _meet(self) -> None:
        """Go on until all players are asked to think in the same cycle, and let them be done."""
        *others, last = [speaker for speaker in self._speakers.values() if speaker.eye]
        give_up = time.monotonic() + PATIENCE
        while not last.thinks:
            last.take(0.001)
            for speaker in others:
                speaker.take(0.001)
                self._done(speaker)
            assert time.monotonic() < give_up, f"{last.name} is not asked to think"
        for speaker in self._speakers.values():  # the server waits for the last one meanwhile
            while speaker.take(0.01) is not None:
                continue
        self._finish_cycle()

    def _answer_thinks(self) -> None:
        for speaker in self._speakers.values():
            speaker.take(0.001)
            self._done(speaker)

    def _done(self, speaker: Speaker) -> None:
        if speaker.thinks:
            speaker.thinks = 0
            speaker.send("(done)")

    def _finish_cycle(self) -> None:
        """Let everybody be done, and wait until all are asked to think again."""
        for speaker in self._speakers.values():
            self._done(speaker)
        give_up = time.monotonic() + PATIENCE
        waiting = [speaker for speaker in self._speakers.values() if speaker.eye]
        while waiting:
            for speaker in waiting:
                speaker.take(0.05)
            waiting = [speaker for speaker in waiting if not speaker.thinks]
            names = [speaker.name for speaker in waiting]
            assert time.monotonic() < give_up, f"{names} are not asked to think"


def _without_numbers(told: Told) -> Told:
    """Return messages without numbers and without collisions, in which chance may have placed somebody."""
    pattern = re.compile(r"-?\b(0x)?\d[\d.a-f-]*|(\bnone|\(ball\) \(player\)|\(ball\)|\(player\))(?=\))")
    return {name: [pattern.sub("#", text) for text in texts] for name, texts in told.items()}


def differences(dialogue: Dialogue, theirs: list[Told], ours: list[Told]) -> list[str]:
    """Return a line for everybody who is told something else in a cycle; of what is told in one the order is free,
    but for announcements and replies among themselves.
    """
    found = []
    for cycle, said in enumerate(dialogue.cycles):
        for name, messages in theirs[cycle].items():
            own = ours[cycle].get(name, [])
            if sorted(messages) != sorted(own) or _ordered(messages) != _ordered(own):
                found.append(
                    f"cycle {cycle}, {name}, after {said}:\n{_only(messages, own)}\nhere\n{_only(own, messages)}"
                )
    return found


def _ordered(messages: list[str]) -> list[list[str]]:
    return [
        [text for text in messages if re.match(kind, text)] for kind in (r"\(hear (\d+ )?referee", r"\((ok|error) ")
    ]


def _only(messages: list[str], others: list[str]) -> list[str]:
    return [text for text in messages if text not in others] or messages


def write(path: Path, told: list[Told]) -> None:
    """Write what everybody was told; a message that somebody has been told before is only named by its number."""
    texts: dict[str, int] = {}
    numbers = [
        {name: [texts.setdefault(text, len(texts)) for text in messages] for name, messages in cycle.items()}
        for cycle in told
    ]
    with gzip.GzipFile(path, "wb", mtime=0) as file:
        file.write(json.dumps({"texts": list(texts), "told": numbers}, separators=(",", ":")).encode())


def read(path: Path) -> list[Told]:
    """Read what `write` wrote."""
    with gzip.open(path, "rt", encoding="utf-8") as file:
        data = json.load(file)
    texts = data["texts"]
    return [{name: [texts[k] for k in numbers] for name, numbers in cycle.items()} for cycle in data["told"]]
