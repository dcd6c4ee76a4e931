"""The experimenter's page: who is where, how it goes, what is wrong; to stop, to extend, to remove, and to download."""

from __future__ import annotations

import asyncio
import secrets
import tempfile
import zipfile
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from aiohttp import web

from rcss_hat.inputs import FileFormatError
from rcss_hat.studies.folder import EXPERIMENT
from rcss_hat.studies.pages import HEADERS, lab_page
from rcss_hat.studies.participant import Participant
from rcss_hat.studies.plan import assigned, participant_name
from rcss_hat.studies.progress import Progress
from rcss_hat.system.files import NotWritten

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable

    from rcss_hat.studies.server import StudyServer

IDLE_SHARE, LATE_SHARE = 0.3, 0.05
"""Shares of idle games, and of late pictures, that are called a problem."""
FEW_GAMES, FEW_PICTURES = 5, 200
"""Fewer say nothing."""
MOST_EXTRA = 1_000
"""Games that may be added at once."""
SECRET_FOLDER = "keys"


class Lab:
    """What the experimenter asks for.

    Parameters
    ----------
    server : StudyServer
    """

    def __init__(self, server: StudyServer) -> None:
        self._server = server

    def routes(self) -> list[tuple[str, str, Callable[[web.Request], Awaitable[web.StreamResponse]]]]:
        """Return what is answered."""
        return [
            ("GET", "/lab/{token}/", self._page),
            ("GET", "/lab/{token}/status", self._status),
            ("POST", "/lab/{token}/do", self._do),
            ("GET", "/lab/{token}/data.zip", self._download),
        ]

    def _check(self, request: web.Request) -> None:
        given = request.match_info["token"]
        if not secrets.compare_digest(given.encode(), self._server.links.lab.encode()):
            raise web.HTTPNotFound(text="There is nothing here.\n", headers=HEADERS)

    async def _page(self, request: web.Request) -> web.StreamResponse:
        self._check(request)
        study = self._server.folder.study
        return web.Response(text=lab_page(study), content_type="text/html")

    async def _status(self, request: web.Request) -> web.StreamResponse:
        self._check(request)
        return web.json_response(status_of(self._server))

    async def _do(self, request: web.Request) -> web.StreamResponse:
        self._check(request)
        try:
            told = await request.json()
        except (ValueError, RecursionError):
            told = None
        place = told.get("place") if isinstance(told, dict) else None
        if not isinstance(place, int) or not 1 <= place <= len(self._server.links.places):
            return web.json_response({"done": False, "why": "there is no such place"}, status=400)
        try:
            why = await self._act(told.get("action"), place, told.get("games"))
        except (NotWritten, FileFormatError) as problem:
            why = str(problem)
        return web.json_response({"done": why is None, "why": why}, status=200 if why is None else 409)

    async def _act(self, action: Any, place: int, games: Any) -> str | None:
        """Do what was asked for; returns why it was not."""
        participant = self._server.participants.get(place)
        if participant is None:
            return "nobody has begun there"
        if action == "stop":
            await participant.stop()
        elif action == "extend":
            if type(games) is not int or not 1 <= games <= MOST_EXTRA:
                return f"games must be 1 to {MOST_EXTRA}"
            if not await participant.extend(games):
                return "the participant is not at a game"
        elif action == "remove":
            await self._server.remove(place)
        else:
            return "there is no such action"
        return None

    async def _download(self, request: web.Request) -> web.StreamResponse:
        """Give everything that is kept, without the links."""
        self._check(request)
        with tempfile.TemporaryDirectory(prefix="rcss-hat-") as temporary:
            packed = Path(temporary) / "data.zip"
            await asyncio.to_thread(pack, self._server.folder.path, packed)
            response = web.StreamResponse(headers={**HEADERS, "Content-Disposition": 'attachment; filename="data.zip"'})
            response.content_type = "application/zip"
            response.content_length = packed.stat().st_size
            await response.prepare(request)
            with packed.open("rb") as file:
                while part := file.read(2**18):
                    await response.write(part)
            await response.write_eof()
        return response


def pack(folder: Path, target: Path) -> None:
    """Pack what is kept in a study's folder, without the links, learners and what is hidden."""
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as packed:
        for file in _data_files(folder):
            packed.write(file, file.relative_to(folder))


def _data_files(folder: Path) -> Iterator[Path]:
    for file in sorted(folder.rglob("*")):
        parts = file.relative_to(folder).parts
        if (
            file.is_file()
            and parts[0] not in (SECRET_FOLDER, EXPERIMENT)
            and not any(part.startswith(".") for part in parts)
        ):
            yield file


def status_of(server: StudyServer) -> dict[str, Any]:
    """Return what the experimenter's page shows; JSON data."""
    places = []
    for place in range(1, server.folder.study.participants + 1):
        participant = server.participants.get(place)
        name = participant_name(place)
        entry: dict[str, Any] = {
            "place": place,
            "name": name,
            "link": f"../../p/{server.links.places[place - 1]}/",
            "conditions": list(assigned(server.folder.study, place)),
            "state": "removed" if name in server.removed else "free",
            "problems": [],
        }
        places.append(entry if participant is None else {**entry, **_of(participant)})
    means = _condition_means(server)
    return {"places": places, "means": means, "open_link": f"../../join/{server.links.open}/"}


def _of(participant: Participant) -> dict[str, Any]:
    progress = participant.progress
    current = progress.current
    played = progress.played.get(current.name)
    state = (
        "stopped" if progress.stopped else "finished" if progress.finished else "here" if participant.online else "away"
    )
    return {
        "state": state,
        "step": current.name,
        "position": progress.plan.index(current) + 1,
        "steps": len(progress.plan),
        "games": None if played is None else len(played.games),
        "wanted": None if played is None else progress.wanted(current.name),
        "mean_s": _mean(_demonstrated(progress)),
        "problems": problems(participant),
    }


def problems(participant: Participant) -> list[str]:
    """Return what is wrong with a participant, in words."""
    found = []
    if participant.trouble:
        found.append(participant.trouble)
    games = [game for played in participant.progress.played.values() for game in played.games]
    idle = sum(bool(game["idle"]) for game in games)
    if len(games) >= FEW_GAMES and idle / len(games) > IDLE_SHARE:
        found.append(f"idle: no key in {idle} of {len(games)} games")
    pictures, late, worst = participant.lag
    if pictures >= FEW_PICTURES and late / pictures > LATE_SHARE:
        found.append(f"lag: {100 * late / pictures:.0f} % of the pictures came late, the worst after {worst} ms")
    return found


def _demonstrated(progress: Progress) -> list[float]:
    return [
        s for planned in progress.plan if planned.kept and planned.step_kind == "demonstration"
        for s in progress.played[planned.name].seconds
    ]  # fmt: skip


def _condition_means(server: StudyServer) -> list[dict[str, Any]]:
    found: dict[str, list[list[float]]] = {c.name: [] for c in server.folder.study.conditions}
    for participant in server.participants.values():
        for planned in participant.progress.plan:
            if planned.step_kind == "demonstration" and planned.condition is not None:
                seconds = participant.progress.played[planned.name].seconds
                if seconds:
                    found[planned.condition].append(seconds)
    return [
        {
            "condition": name,
            "participants": len(games),
            "games": sum(map(len, games)),
            "mean_s": _mean([sum(s) / len(s) for s in games]),
        }
        for name, games in found.items()
    ]


def _mean(values: list[float]) -> float | None:
    return round(sum(values) / len(values), 2) if values else None
