"""Game logs (``.rcg``) of text versions 4, 5 and 6 and in JSON, compressed or not, cut off or not."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path

from rcss_hat.inputs import FileFormatError, LineReader
from rcss_hat.keepaway.report import Episode
from rcss_hat.protocol import messages
from rcss_hat.protocol.errors import RemoteProtocolError
from rcss_hat.viewer.audience import WatchError
from rcss_hat.viewer.episodes import EpisodeTracker
from rcss_hat.viewer.frames import Setup, Snapshot
from rcss_hat.viewer.json_log import BEGIN, OPENING, read_json_line
from rcss_hat.viewer.narrator import Values
from rcss_hat.viewer.playback import Scene
from rcss_hat.viewer.shows import checked, read, setup_of, snapshot_of, team_names

VERSIONS = (b"ULG4", b"ULG5", b"ULG6")
_USED = (b"(show ", b"(playmode ", b"(team ", b"(server_param ")
MAX_FRAMES = 1_000_000
"""A day of play; every frame takes some kilobytes of memory."""


class Recording:
    """A game log that was read; a `rcss_hat.viewer.playback.Reel`.

    Attributes
    ----------
    setup : Setup
    scenes : list of Scene
    episodes : list of Episode
    skipped : int
        Lines that could not be read; a server that is stopped while it writes leaves one.
    cut : str
        Why the log ended early; ``""`` when it did not.
    """

    complete = True
    values: Values | None = None

    def __init__(self, lines: Iterable[bytes], title: str, reader: Callable[[bytes], messages.Event | None]) -> None:
        self.setup = Setup(title)
        self.scenes: list[Scene] = []
        self.episodes: list[Episode] = []
        self.skipped = 0
        self.cut = ""
        self._reader = reader
        mode = "play_on"
        params: messages.ServerParam | None = None
        team: messages.Team | None = None
        tracker: EpisodeTracker | None = None
        for line in lines:
            event = self._read(line)
            if isinstance(event, messages.Show):
                if tracker is None:
                    self.setup = setup_of(params, title)
                    tracker = EpisodeTracker(self.setup)
                self._show(snapshot_of(event, mode, team), tracker)
            elif isinstance(event, messages.PlayMode):
                mode = event.mode
            elif isinstance(event, messages.Team):
                team = _known(team, event)
            elif isinstance(event, messages.ServerParam):
                params = event
        self.setup = replace(self.setup, teams=team_names(team, self.setup.keepaway))

    def _read(self, line: bytes) -> messages.Event | None:
        """Read a line that matters."""
        try:
            return self._reader(line)
        except (RemoteProtocolError, FileFormatError):
            self.skipped += 1
            return None

    def _show(self, snapshot: Snapshot, tracker: EpisodeTracker) -> None:
        if len(self.scenes) >= MAX_FRAMES:
            raise WatchError(f"{self.setup.title} has more than {MAX_FRAMES} frames, the limit for watching")
        ended = tracker.see(snapshot)
        if ended is not None:
            self.episodes.append(ended)
        self.scenes.append(Scene(snapshot, tracker.number, tracker.start))

    async def grow(self) -> None:
        """Nothing more can come."""


def _known(before: messages.Team | None, now: messages.Team) -> messages.Team:
    """Return the newest scores, and names that teams had before they left."""
    if before is None:
        return now
    left = before.left if now.left == "null" else now.left
    right = before.right if now.right == "null" else now.right
    return replace(now, left=left, right=right)


def _read_text_line(line: bytes) -> messages.Event | None:
    return read(line) if line.startswith(_USED) else None


def read_recording(path: Path) -> Recording:
    """Read a game log.

    Parameters
    ----------
    path : Path
        ``.rcg`` or ``.rcg.gz``; one that was cut off is read up to there.

    Raises
    ------
    WatchError
        When it is no game log, of a version that cannot be read, too long, or without a frame.
    """
    try:
        reader = LineReader(path, "game log")
        lines = iter(reader)
        first, second = next(lines, b""), next(lines, b"")
        if first in VERSIONS:
            recording = Recording(itertools.chain([second], lines), path.name, _read_text_line)
        elif first.strip() == OPENING and second.lstrip().startswith(BEGIN):
            recording = Recording(lines, path.name, _read_checked_json_line)
        else:
            raise WatchError(
                f"{path} is no game log in JSON or of text version 4, 5 or 6; it begins with {first[:12]!r}. Let the "
                "server write one with server::game_log_version=5"
            )
    except FileFormatError as error:
        raise WatchError(str(error)) from error
    recording.cut = reader.cut
    if not recording.scenes:
        raise WatchError(f"{path} has no frame: nothing was played" + (f"; {reader.cut}" if reader.cut else ""))
    return recording


def _read_checked_json_line(line: bytes) -> messages.Event | None:
    event = read_json_line(line)
    return None if event is None else checked(event)
