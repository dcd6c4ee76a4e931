"""A scripted participant: goes through a study as a person does, by its pages and their protocol.

He reads the links, ticks, answers at random, and plays as a teacher of `rcss_hat.hat.teachers` would: on the pictures
that the page is sent, with the teacher's reaction time, by the keys that a page sends.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import math
import time
from dataclasses import asdict, dataclass, field, replace
from html.parser import HTMLParser
from typing import Any
from urllib.parse import urlsplit

import aiohttp
import numpy as np
from numpy.typing import NDArray

from rcss_hat.hat.teachers import ScriptedTeacher, Teacher, style
from rcss_hat.keepaway.decision import PERSON

AGAIN = 1.0
"""Seconds until he tries again when the server does not answer, or a page is closed."""
PRESSES = 3
"""Cycles after which he presses a key again that was not taken up."""
GAP = 20
"""Cycles between two pictures, at most, that he makes up the ones between."""
TELLS = 20
"""Pictures after which his page tells how they came."""
REACH = 20.0
"""Seconds without a picture or a word, after which he loads the page again."""
LOOKS_AGAIN = 8.0
"""Seconds for which he looks at a game again."""
_VARIETY = {"delay": 0.15, "pass_distance": 0.12, "open": 0.08, "misjudgement": 0.4, "lapse": 0.5, "unready": 0.5}
"""How people of one style differ: standard deviations of the logarithm."""


def person(name: str, seed: int) -> Teacher:
    """Draw a person in the manner of a teacher of `rcss_hat.hat.teachers.STYLES`."""
    teacher, rng = style(name), np.random.default_rng(seed)
    drawn = {k: getattr(teacher, k) * math.exp(sd * rng.standard_normal()) for k, sd in _VARIETY.items()}
    drawn["lapse"], drawn["unready"] = min(drawn["lapse"], 0.5), min(drawn["unready"], 0.5)
    return replace(teacher, **drawn, delay_spread=min(teacher.delay_spread, drawn["delay"]))


@dataclass(slots=True)
class Told:
    """What a scripted participant tells of his way.

    Attributes
    ----------
    name : str
        His teacher's.
    games : dict of str to int
        Ends of games that he saw, by the titles of the pages he was at.
    intervals : list of float
        Milliseconds between pictures, by his own clock, while the game went on.
    wanted_ms : list of float
        What they should have been.
    breaks : int
        How often he had to connect again.
    code : str
        The code he was shown at the end.
    finished : bool
    """

    name: str
    games: int = 0
    intervals: list[float] = field(default_factory=list)
    wanted_ms: list[float] = field(default_factory=list)
    breaks: int = 0
    code: str = ""
    finished: bool = False

    def to_dict(self) -> dict[str, Any]:
        """Return it ready for JSON."""
        return asdict(self)


class _Page(HTMLParser):
    """What a page asks for."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.fields: list[dict[str, str | None]] = []
        self.is_game = self.is_form = False
        self.code = ""
        self._strong = False
        self._in_code = False
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Take a tag."""
        had = dict(attrs)
        if tag == "canvas" and had.get("id") == "pitch":
            self.is_game = True
        elif tag == "form" and had.get("id") == "step":
            self.is_form = True
        elif tag in ("input", "textarea") and had.get("name") and self.is_form:
            self.fields.append({**had, "tag": tag})
        elif tag == "p":
            self._in_code = had.get("class") == "code"
        self._strong = tag == "strong"

    def handle_data(self, data: str) -> None:
        """Take text."""
        if self._in_code and self._strong and data.strip():
            self.code, self._strong = data.strip(), False


class ScriptedParticipant:
    """Goes through a study.

    Parameters
    ----------
    link : str
        Ends in a slash.
    teacher : str
        A style of `rcss_hat.hat.teachers.STYLES`.
    seed : int
    hurry : float
        How much faster than it should the study is rehearsed.
    """

    def __init__(self, link: str, teacher: str, seed: int, hurry: float = 1.0) -> None:
        self.link, self.hurry = link, hurry
        self.told = Told(teacher)
        self._habits, self._seed = person(teacher, seed), seed
        self._rng = np.random.default_rng(seed)

    async def run(self, session: aiohttp.ClientSession) -> Told:
        """Go to the end; a server that does not answer is waited for."""
        while not self.told.finished:
            try:
                await self._next(session)
            except (aiohttp.ClientError, TimeoutError, ConnectionError):
                self.told.breaks += 1
                await asyncio.sleep(AGAIN)
        return self.told

    async def _next(self, session: aiohttp.ClientSession) -> None:
        async with session.get(self.link) as response:
            response.raise_for_status()
            page = _Page(await response.text())
        if page.is_game:
            await self._play(session)
        elif page.is_form:
            await asyncio.sleep(1.0 / self.hurry)
            async with session.post(self.link + "step", data=self._answers(page), allow_redirects=False) as response:
                if response.status not in (303, 503):
                    raise RuntimeError(f"{self.link}: an answer was refused ({response.status})")
        else:
            self.told.code, self.told.finished = page.code, True

    def _answers(self, page: _Page) -> dict[str, str]:
        """Fill in a form: every field, choices at random."""
        answers: dict[str, str] = {}
        choices: dict[str, list[str]] = {}
        for f in page.fields:
            name, kind = str(f["name"]), f.get("type")
            if kind == "radio":
                choices.setdefault(name, []).append(str(f["value"]))
            elif kind == "number":
                low, high = float(f.get("min") or 0), float(f.get("max") or 100)
                answers[name] = f"{round(self._rng.uniform(low, min(high, low + 50)))}"
            elif f["tag"] == "textarea":
                answers[name] = "scripted"
            else:
                answers[name] = str(f.get("value") or "")
        return answers | {name: str(self._rng.choice(values)) for name, values in choices.items()}

    async def _play(self, session: aiohttp.ClientSession) -> None:
        parts = urlsplit(self.link)
        origin = {"Origin": f"{parts.scheme}://{parts.netloc}"}
        async with session.ws_connect(self.link + "socket", headers=origin, max_msg_size=2**22) as socket:
            game = _Game(self, socket)
            while True:
                message = await socket.receive(timeout=REACH)
                if message.type is not aiohttp.WSMsgType.TEXT:
                    raise ConnectionError("the page was closed")
                if not await game.take(json.loads(message.data)):
                    return

    def eyes(self, speed: float, actions: int) -> ScriptedTeacher:
        """Return him as he plays at a speed, with so many actions to choose from."""
        habits = self._habits if speed == 1.0 else self._habits.fast(speed)
        self._seed += 1
        return ScriptedTeacher(replace(habits, max_action=min(habits.max_action, actions - 1)), self._seed)


class _Game:
    """One page of a game, as a scripted participant sees it."""

    def __init__(self, player: ScriptedParticipant, socket: aiohttp.ClientWebSocketResponse) -> None:
        self._player, self._socket = player, socket
        self._teacher: ScriptedTeacher | None = None
        self._step_ms, self._speed = 100.0, 1.0
        self._status: dict[str, Any] = {}
        self._episode, self._pressed = -1, (-PRESSES, None)
        self._seen: tuple[int, NDArray[np.float64]] | None = None
        self._last: float | None = None
        self._intervals: list[int] = []
        self._answering: asyncio.Task[None] | None = None
        self._again: list[int] = []  # cycles of the decisions that he is shown again

    async def take(self, message: dict[str, Any]) -> bool:
        """Take a message; False: the game is over."""
        kind = message["type"]
        if kind == "setup":
            self._step_ms = message["setup"]["step_s"] * 1000.0
            self._speed = 100.0 / self._step_ms / self._player.hurry
        elif kind == "demonstration":
            self._take_status(message)
        elif kind == "episode":
            self._player.told.games += 1
        elif kind == "replay" and message["frames"]:
            self._again = [decision["cycle"] for decision in message["decisions"]]
        elif kind == "frame":
            await self._look(message["frame"])
        return bool(kind != "farewell")

    def _take_status(self, status: dict[str, Any]) -> None:
        self._status = status
        if status["standing"]:
            self._last = None
        asked = ("start", not status["started"]), ("here", status["asking"]), ("seen", status["replaying"])
        wanted = next((command for command, holds in asked if holds), None)
        if wanted and (self._answering is None or self._answering.done()):
            self._answering = asyncio.create_task(self._answer(wanted))

    async def _answer(self, command: str) -> None:
        await asyncio.sleep((LOOKS_AGAIN if command == "seen" else 1.0) / self._player.hurry)
        with contextlib.suppress(ConnectionError):
            if command == "seen" and self._again:
                await self._socket.send_json({"type": "correct", "cycle": self._again.pop(), "action": 0})
            await self._socket.send_json({"type": "demonstration", "value": command})

    async def _look(self, frame: dict[str, Any]) -> None:
        """See a picture, and press the key that he would."""
        await self._time()
        if not self._status:
            return
        if self._teacher is None:
            self._teacher = self._player.eyes(round(self._speed, 3), len(self._status["actions"]))
        if frame["episode"] != self._episode:
            self._episode = frame["episode"]
            self._teacher.new_episode()
            self._seen = None
            if self._status["turns"] and self._status["by"] == PERSON:
                await self._socket.send_json({"type": "demonstration", "value": "give"})
        key = self._show(self._teacher, frame)
        again = frame["time"] - self._pressed[0] >= PRESSES or frame["holder"] != self._pressed[1]
        if key and frame["pending"] is None and frame["holder"] and again and not self._status["standing"]:
            self._pressed = frame["time"], frame["holder"]
            at = round(time.monotonic() * 1000.0) % 10**9
            await self._socket.send_json({"type": "press", "value": key, "at": at})

    def _show(self, teacher: ScriptedTeacher, frame: dict[str, Any]) -> int:
        """Show him a picture; of those that were left out he makes up his mind, as eyes do."""
        places = [(p["x"], p["y"]) for p in frame["players"] if p["side"] == "l"]
        keepers = len(places)
        places += [(p["x"], p["y"]) for p in frame["players"] if p["side"] == "r"]
        now = frame["time"], np.array([frame["ball"][:2], *places])
        before = self._seen if self._seen is not None and 0 < now[0] - self._seen[0] <= GAP else None
        self._seen = now
        key = 0
        for cycle in range(now[0] if before is None else before[0] + 1, now[0] + 1):
            share = 1.0 if before is None else (cycle - before[0]) / (now[0] - before[0])
            seen = now[1] if before is None else before[1] + share * (now[1] - before[1])
            key = teacher(cycle, seen[0], seen[1 : 1 + keepers], seen[1 + keepers :])
        return key

    async def _time(self) -> None:
        """Take down how long the picture was waited for, and tell now and then."""
        now = time.monotonic()
        if self._last is not None:
            interval = (now - self._last) * 1000.0
            self._player.told.intervals.append(round(interval, 1))
            self._player.told.wanted_ms.append(self._step_ms)
            self._intervals.append(round(interval))
        self._last = None if self._status.get("standing", True) else now
        if len(self._intervals) >= TELLS:
            await self._socket.send_json({"type": "pace", "intervals": self._intervals})
            self._intervals = []
