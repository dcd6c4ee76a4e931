"""What is played or shown in one place, and the pages that look at it; no HTTP: whoever serves pages can use it.

Whoever serves the pages makes a `Room` of a source and, where somebody is to play, a demonstrator; runs it; lets every
page that connects `enter` and passes on what it says (`hear`). Everything belongs to the room: a program may have many.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from rcss_hat.keepaway.report import Episode
from rcss_hat.viewer import protocol
from rcss_hat.viewer.audience import Source, WatchError
from rcss_hat.viewer.browser import Browser
from rcss_hat.viewer.demonstrator import Demonstrator
from rcss_hat.viewer.frames import Frame, Setup
from rcss_hat.viewer.seat import PLAYER, Seat

SEAT_KEPT = 3.0
"""Seconds that the seat is kept for a browser without a page: as long as loading one again takes."""
_HUGE = 1e15
_TOLD = ("setup", "notice", "demonstration", "playback", "replay", "frame", "farewell")
"""What a page that comes is told, in this order."""


@dataclass(frozen=True)
class Manner:
    """How pages show it.

    Attributes
    ----------
    plain : bool
        Without state variables and values: people in studies must not see them, so they are not even sent.
    language : str or None
        Of the texts; None: the browser's.
    """

    plain: bool = False
    language: str | None = None


@dataclass(frozen=True)
class Refusal:
    """Why something was not done: in English, and as a code with values for the page's own language."""

    text: str
    code: str
    values: Mapping[str, Any]


def refusal(code: str, text: str, **values: Any) -> Refusal:
    """Make a refusal."""
    return Refusal(text, code, values)


class Room:
    """A source, who plays it, and the pages that show it; an `rcss_hat.viewer.audience.Audience`.

    Parameters
    ----------
    source : Source
    controls : Demonstrator, optional
        Who takes the keys; without it pages only watch.
    manner : Manner, optional

    Attributes
    ----------
    failure : str or None
        Why the source ended, when it did.
    on_message : callable or None
        Told (page, message) of everything a page says that is well-formed, before it is done.
    """

    def __init__(self, source: Source, controls: Demonstrator | None = None, manner: Manner | None = None) -> None:
        self.source, self.controls, self.manner = source, controls, manner or Manner()
        self.failure: str | None = None
        self.on_message: Callable[[Browser, protocol.Message], None] | None = None
        self._seat = Seat()
        self._release: asyncio.TimerHandle | None = None
        self._browsers: set[Browser] = set()
        self._told: dict[str, Mapping[str, Any]] = {}
        self._episodes: list[dict[str, Any]] = []
        if controls is not None:
            controls.on_replay = self._replay
            controls.person(False)  # nobody is there yet

    async def run(self) -> None:
        """Show the source to its end; pages may come and go meanwhile."""
        try:
            await self.source.run(self)
        except WatchError as error:
            self.failure = str(error)
            self.notice(f"The end: {error}.")

    def close(self, url: str | None = None) -> None:
        """Tell the pages that it is over, and where to go on."""
        if self.controls is not None:
            self._tell_controls()
            self._say_and_keep("farewell", {"type": "farewell", "url": url, **self.controls.farewell()})
        if self._release is not None:
            self._release.cancel()

    @property
    def pages(self) -> list[Browser]:
        """Those that are connected."""
        return list(self._browsers)

    # -- audience: what the source tells ------------------------------------------------------------------------------
    def setup(self, setup: Setup, live: bool) -> None:
        """Tell the pages what is watched."""
        self._say_and_keep("setup", {"type": "setup", "setup": setup.to_dict(), "live": live})

    def frame(self, frame: Frame) -> None:
        """Show the newest picture."""
        if self.controls is not None:
            self.controls.observe(frame)
            self._tell_controls()
        self._show("frame", {"type": "frame", "frame": self._seen(frame)})

    def episodes(self, episodes: Sequence[Episode]) -> None:
        """Tell the pages all episodes."""
        self._episodes = [_episode(e) for e in episodes]
        for browser in self._browsers:
            browser.say({"type": "episodes", "episodes": self._episodes})

    def episode(self, episode: Episode) -> None:
        """Tell the pages one more episode."""
        self._episodes.append(_episode(episode))
        for browser in self._browsers:
            browser.say({"type": "episode", "episode": self._episodes[-1]})
        if self.controls is not None:
            self._tell_controls()

    def playback(self, status: Mapping[str, Any]) -> None:
        """Tell the pages where in a recording we are."""
        self._show("playback", {"type": "playback", **status})

    def notice(self, text: str, code: str | None = None, **values: Any) -> None:
        """Tell people something."""
        self._say_and_keep("notice", {"type": "notice", "text": text, "code": code, "values": values})

    def _seen(self, frame: Frame) -> Frame:
        """Return what pages see of a picture."""
        if not self.manner.plain:
            return frame
        seen = frame.copy()
        seen["state"], seen["values"] = None, None
        return seen

    def _replay(self, replay: Mapping[str, Any] | None) -> None:
        frames = None if replay is None else [self._seen(frame) for frame in replay["frames"]]
        self._say_and_keep("replay", {"type": "replay", **(replay or {}), "frames": frames})

    def _tell_controls(self) -> None:
        assert self.controls is not None
        status = {"type": "demonstration", **self.controls.status()}
        if self._told.get("demonstration") != status:
            self._show("demonstration", status)

    def _say_and_keep(self, kind: str, message: Mapping[str, Any]) -> None:
        self._told[kind] = message
        for browser in self._browsers:
            browser.say(message)

    def _show(self, kind: str, message: Mapping[str, Any]) -> None:
        self._told[kind] = message
        for browser in self._browsers:
            browser.show(kind, message)

    # -- pages that come and go ---------------------------------------------------------------------------------------
    def enter(self, browser: Browser) -> None:
        """Tell a new page what the others know, then count it among them."""
        self._seat.enter(browser)
        browser.say(
            {
                "type": "hello",
                "protocol": protocol.VERSION,
                "role": self._seat.role(browser),
                "demonstrate": self.controls is not None,
                "plain": self.manner.plain,
                "language": self.manner.language,
            }
        )
        browser.say({"type": "episodes", "episodes": self._episodes})
        if self.controls is not None:
            self._told["demonstration"] = {"type": "demonstration", **self.controls.status()}
        for kind in _TOLD:
            if kind in self._told:
                browser.say(self._told[kind])
        self._browsers.add(browser)
        self._seat_changed()

    def leave(self, browser: Browser) -> None:
        """Count a page no more."""
        self._browsers.discard(browser)
        self._seat.leave(browser)
        self._seat_changed()

    def _seat_changed(self) -> None:
        """Tell the pages who plays, and the demonstration whether anybody is there and looks."""
        seat = self._seat
        for browser in self._browsers:
            browser.show("seat", {"type": "seat", "role": seat.role(browser), "state": seat.state})
        if self._release is not None:
            self._release.cancel()
            self._release = None
        if seat.owner is not None and not seat.occupied:
            self._release = asyncio.get_running_loop().call_later(SEAT_KEPT, self._give_up_seat)
        if self.controls is not None:
            self.controls.person(seat.occupied)
            self.controls.look(seat.looking)
            self._tell_controls()

    def _give_up_seat(self) -> None:
        if self._seat.give_up():
            self._seat_changed()

    # -- what people ask for ------------------------------------------------------------------------------------------
    def hear(self, browser: Browser, text: str | bytes) -> None:
        """Take a message of a page; what is malformed, or not for that browser to ask, changes nothing."""
        message = protocol.read_message(text)
        if message is not None and self.on_message is not None:
            self.on_message(browser, message)
        answer = self._answer(browser, message)
        if answer is not None:
            browser.say({"type": "refused", "text": answer.text, "code": answer.code, "values": answer.values})

    def _answer(self, browser: Browser, message: protocol.Message | None) -> Refusal | None:
        """Do what was asked for, or say why not."""
        match message:
            case None:
                return refusal("malformed", "that is no message of the page")
            case protocol.Look(value):
                browser.looking = value
                self._seat_changed()
                return None
            case protocol.Pace():
                return None
            case protocol.TakeSeat():
                if not self._seat.take(browser.session):
                    return refusal("taken", "another browser plays at the moment")
                self._seat_changed()
                return None
        if self._seat.role(browser) != PLAYER:
            return refusal("watching", "another browser plays; this one can only watch")
        done = self._obey(message)
        if self.controls is not None:
            self._tell_controls()
        return None if done else self._refusal(message)

    def _obey(self, message: protocol.Message) -> bool:
        if isinstance(message, protocol.Playback):
            return self.source.command(message.name, _number(message.value))
        controls = self.controls
        if controls is None:
            return False
        match message:
            case protocol.Press(value, at):
                return controls.press(value, at)
            case protocol.Mate(value, at):
                return controls.press_mate(value, at)
            case protocol.Correct(cycle, action):
                return controls.correct(cycle, action)
            case protocol.Command(value):
                return controls.command(value)
        return False

    def _refusal(self, message: protocol.Message) -> Refusal:
        """Say for people why something was not done."""
        match message:
            case protocol.Press() if self.controls is not None:
                known = [a for a in self.controls.keys.actions if a]
                passes = " and ".join(map(str, known))
                return refusal(
                    "no_such_pass", f"there is no such pass here: 0 holds the ball, {passes} passes it", passes=known
                )
            case protocol.Correct():
                return refusal("nothing_to_correct", "nobody had to decide at this moment")
            case protocol.Mate():
                return refusal("no_pass_there", "no pass goes there at the moment")
            case protocol.Command("drop_last"):
                return refusal("nothing_to_drop", "there is no episode to drop")
        return refusal("not_now", "that cannot be done now")


def _number(value: Any) -> float:
    """Return a number of a message; 0 for what is none, or beyond all use."""
    return float(value) if isinstance(value, (int, float)) and abs(value) < _HUGE else 0.0


def _episode(episode: Episode) -> dict[str, Any]:
    told = {name: value for name, value in asdict(episode).items() if name != "final"}  # pages show no state of its end
    return {**told, "cycles": episode.cycles}
