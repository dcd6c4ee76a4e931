"""Game logs (``.rcg``) of text versions 4, 5 and 6, compressed or not."""

from __future__ import annotations

import gzip
import zlib
from collections.abc import Iterable
from pathlib import Path

from rcss_hat.keepaway.report import Episode
from rcss_hat.protocol import messages
from rcss_hat.protocol.errors import RemoteProtocolError
from rcss_hat.viewer.audience import WatchError
from rcss_hat.viewer.episodes import EpisodeTracker
from rcss_hat.viewer.frames import TEAMS, Setup, Snapshot
from rcss_hat.viewer.narrator import Values
from rcss_hat.viewer.playback import Scene
from rcss_hat.viewer.shows import read, setup_of, snapshot_of, team_names

VERSIONS = (b"ULG4", b"ULG5", b"ULG6")
_USED = (b"(show ", b"(playmode ", b"(team ", b"(server_param ")
_GZIP = b"\x1f\x8b"


class Recording:
    """A game log that was read; a `rcss_hat.viewer.playback.Reel`.

    Attributes
    ----------
    setup : Setup
    scenes : list of Scene
    episodes : list of Episode
    skipped : int
        Lines that could not be read; a server that is stopped while it writes leaves one.
    """

    complete = True
    values: Values | None = None

    def __init__(self, lines: Iterable[bytes], title: str) -> None:
        self.setup = Setup(title)
        self.scenes: list[Scene] = []
        self.episodes: list[Episode] = []
        self.skipped = 0
        mode, teams = "play_on", TEAMS
        params: messages.ServerParam | None = None
        tracker: EpisodeTracker | None = None
        for line in lines:
            event = self._read(line)
            if isinstance(event, messages.Show):
                if tracker is None:
                    self.setup = setup_of(params, title, teams)
                    tracker = EpisodeTracker(self.setup)
                self._show(snapshot_of(event, mode), tracker)
            elif isinstance(event, messages.PlayMode):
                mode = event.mode
            elif isinstance(event, messages.Team) and tracker is None:
                teams = team_names(event)
            elif isinstance(event, messages.ServerParam):
                params = event

    def _read(self, line: bytes) -> messages.Event | None:
        """Read a line that matters."""
        if not line.startswith(_USED):
            return None
        try:
            return read(line)
        except RemoteProtocolError:
            self.skipped += 1
            return None

    def _show(self, snapshot: Snapshot, tracker: EpisodeTracker) -> None:
        ended = tracker.see(snapshot)
        if ended is not None:
            self.episodes.append(ended)
        self.scenes.append(Scene(snapshot, tracker.number, tracker.start))

    async def grow(self) -> None:
        """Nothing more can come."""


def read_recording(path: Path) -> Recording:
    """Read a game log.

    Parameters
    ----------
    path : Path
        ``.rcg`` or ``.rcg.gz``.

    Raises
    ------
    WatchError
        When it is no game log, of a version that cannot be read, or without a frame.
    """
    data = path.read_bytes()
    if data.startswith(_GZIP):
        try:
            data = gzip.decompress(data)
        except (OSError, EOFError, zlib.error) as error:
            raise WatchError(f"{path} cannot be decompressed: {error}") from error
    lines = data.splitlines()
    if not lines or lines[0] not in VERSIONS:
        raise WatchError(
            f"{path} is no game log of text version 4, 5 or 6; it begins with {data[:12]!r}. Let the server write one "
            "with server::game_log_version=5"
        )
    recording = Recording(lines, path.name)
    if not recording.scenes:
        raise WatchError(f"{path} has no frame: nothing was played")
    return recording
