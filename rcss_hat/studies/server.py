"""The server of a study: gives everybody the page of his step, and the experimenter hers.

Whoever has a participant's link is that participant; the link's token is all there is to it, and no address is kept.
All addresses in pages are relative, so that the server may stand behind a reverse proxy, under any path.
"""

from __future__ import annotations

import contextlib
import json
import secrets
import time
from collections.abc import Awaitable, Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any
from urllib.parse import urlsplit

from aiohttp import WSMsgType, web

from rcss_hat.studies.address import Address
from rcss_hat.studies.answers import NotAnswered, read_answers
from rcss_hat.studies.folder import Links, StudyFolder
from rcss_hat.studies.game_page import GamePage
from rcss_hat.studies.pages import HEADERS, Pages, own_files
from rcss_hat.studies.participant import Participant
from rcss_hat.studies.parts import QuestionsStep, TextStep, said
from rcss_hat.studies.plan import participant_name, plan_of
from rcss_hat.studies.pool import Pool
from rcss_hat.studies.progress import Progress
from rcss_hat.system.files import NotWritten
from rcss_hat.viewer.door import Door
from rcss_hat.viewer.pagefiles import static_files

LOOPBACK_NAMES = {"127.0.0.1", "localhost", "[::1]"}
MAX_FORM = 2**17
"""Bytes of a form with answers."""
MAX_EVENT = 2**10
"""Bytes of a remark of a page of text."""
COOKIE = "rcss_hat_place"
"""Of the open link: which place was given to this browser. Sent to that link alone."""
COOKIE_S = 90 * 24 * 3600

Handler = Callable[[web.Request], Awaitable[web.StreamResponse]]


class StudyServer:
    """Serves a study.

    Parameters
    ----------
    folder : StudyFolder
    address : Address
    jobs : int
        Processes in which games are played.
    say : callable
        Told what whoever runs the server should know.
    hurry : float
        How much faster games are played than they should, in a rehearsal.

    Attributes
    ----------
    url : str
        Public address of the study, ending in a slash.
    port : int
        Where it listens.
    links : Links
    participants : dict of int to Participant
        By place, those who have begun.
    removed : dict of str to str
        Whose data were removed, and when.
    """

    def __init__(
        self, folder: StudyFolder, address: Address, jobs: int, say: Callable[[str], None], hurry: float = 1.0
    ) -> None:
        self.folder, self.address, self.say = folder, address, say
        self.url, self.port = "", 0
        self.links: Links = folder.links()
        self.participants: dict[int, Participant] = {}
        self.pages = Pages(folder.study)
        self.pool = Pool(jobs, self._deliver, say)
        self._hurry = hurry
        self._places = {token: place for place, token in enumerate(self.links.places, 1)}
        self.removed = folder.removed()
        self._sockets: dict[int, GamePage] = {}
        self._numbers = 0
        self._files = {**static_files(), **own_files()}
        self._writing = ThreadPoolExecutor(1, "journal")
        self._door: Door | None = None
        self._names = set(LOOPBACK_NAMES)
        self._begun = time.monotonic()

    # -- beginning and end --------------------------------------------------------------------------------------------
    async def start(self) -> None:
        """Read what is kept, start the workers, and open the door.

        Raises
        ------
        FileFormatError
            When something that is kept is damaged.
        OSError
            When the port is taken, for example.
        """
        for place in range(1, self.folder.study.participants + 1):
            if (self.folder.folder_of(place) / "participant.json").exists():
                self._admit(place)
        await self.pool.start()
        door = Door(self._app())
        port = await door.open(self.address.bind, self.address.port)
        self._door, self.port = door, port
        parts = urlsplit(self.address.public)
        self._names |= {name for name in (parts.hostname, self.address.bind) if name}
        self.url = self.address.public.rstrip("/") + "/" if self.address.public else f"http://{self._host(port)}/"

    def _host(self, port: int) -> str:
        return f"{'127.0.0.1' if self.address.bind in ('0.0.0.0', '::') else self.address.bind}:{port}"

    async def close(self) -> None:
        """Put all games away, write what is to be written, and free the port."""
        await self.pool.close()
        for participant in self.participants.values():
            await participant.close()
        for page in list(self._sockets.values()):
            await page.close(1012)
        if self._door is not None:
            await self._door.close()
        self._writing.shutdown()

    async def __aenter__(self) -> StudyServer:
        await self.start()
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.close()

    def link(self, place: int) -> str:
        """Link of a place."""
        return f"{self.url}p/{self.links.places[place - 1]}/"

    @property
    def open_link(self) -> str:
        """Link that gives everybody the next free place."""
        return f"{self.url}join/{self.links.open}/"

    @property
    def lab_link(self) -> str:
        """The experimenter's link."""
        return f"{self.url}lab/{self.links.lab}/"

    # -- addresses ----------------------------------------------------------------------------------------------------
    def _app(self) -> web.Application:
        from rcss_hat.studies.lab import Lab  # which knows the server

        app = web.Application(middlewares=[self._guard], client_max_size=MAX_FORM)
        lab = Lab(self)
        routes: list[tuple[str, str, Handler]] = [
            ("GET", "/p/{token}/", self._step),
            ("POST", "/p/{token}/step", self._send_step),
            ("POST", "/p/{token}/language", self._language),
            ("POST", "/p/{token}/events", self._event),
            ("GET", "/p/{token}/alive", self._alive),
            ("GET", "/p/{token}/socket", self._socket),
            ("GET", "/join/{token}/", self._join),
            ("POST", "/join/{token}/go", self._go),
            *lab.routes(),
            ("GET", "/{kind:(p|join|lab)}/{token}/{name}", self._static),
        ]
        for prefix in {"", self.address.prefix}:
            for method, path, handler in routes:
                app.router.add_route(method, prefix + path, handler)
            app.router.add_get(prefix + "/{kind:(p|join|lab)}/{token}", self._slash)
        return app

    @web.middleware
    async def _guard(self, request: web.Request, handler: Handler) -> web.StreamResponse:
        """Refuse foreign names and foreign pages; everything gets the security headers."""
        host = request.headers.get("Host", "")
        name = host.rpartition(":")[0] if not host.endswith("]") and ":" in host else host
        if name not in self._names:
            return _plain(403, "This server does not answer to that name; see --public-url.")
        origin = request.headers.get("Origin")
        if (origin is not None and request.method != "GET") or request.path.endswith("/socket"):
            if origin not in {f"http://{host}", f"https://{host}", *self._public_origin()}:
                return _plain(403, "Only the study's own pages may do that.")
        try:
            response = await handler(request)
        except NotWritten as problem:
            self.say(str(problem))
            return _plain(503, "That could not be saved. Please try again in a minute.")
        except web.HTTPException as problem:
            problem.headers.update(HEADERS)
            raise
        if not response.prepared:
            response.headers.update(HEADERS)
        return response

    def _public_origin(self) -> set[str]:
        parts = urlsplit(self.address.public)
        return {f"{parts.scheme}://{parts.netloc}"} if self.address.public else set()

    async def _slash(self, request: web.Request) -> web.StreamResponse:
        """Relative addresses need the slash at the end."""
        return web.Response(status=307, headers={"Location": f"{request.match_info['token']}/"})

    async def _static(self, request: web.Request) -> web.StreamResponse:
        found = self._files.get(request.match_info["name"])
        if found is None:
            return _plain(404, "There is nothing of that name.")
        return web.Response(body=found[0], content_type=found[1], charset="utf-8")

    # -- participants -------------------------------------------------------------------------------------------------
    def _admit(self, place: int) -> Participant:
        participant = self.participants.get(place)
        if participant is None:
            participant = Participant(self.folder, place, self._writing, self._hurry)
            participant.serve(self.pool)
            self.participants[place] = participant
        return participant

    def _place(self, request: web.Request) -> int:
        """Return the place of a link.

        Raises
        ------
        web.HTTPException
            With a page that says why there is none.
        """
        place = self._places.get(request.match_info["token"])
        if place is None:
            raise web.HTTPNotFound(text=self.pages.message("unknown"), content_type="text/html")
        if participant_name(place) in self.removed:
            raise web.HTTPGone(text=self.pages.message("removed"), content_type="text/html")
        return place

    async def _step(self, request: web.Request) -> web.StreamResponse:
        """Give the page of the step that a participant is at."""
        place = self._place(request)
        participant = self.participants.get(place)
        if participant is None:  # not before he does something: programs look at links, too
            return _html(self.pages.step(Progress(plan_of(self.folder.study, place)), ""))
        participant.heard()
        if participant.progress.current.game is not None:
            content, kind = self._files["play.html"]
            return web.Response(body=content, content_type=kind, charset="utf-8")
        await participant.begin_step()
        return _html(self.pages.step(participant.progress, participant.about["code"]))

    async def _send_step(self, request: web.Request) -> web.StreamResponse:
        """Take a form."""
        participant = self._admit(self._place(request))
        participant.heard()
        form = await request.post()
        current = participant.progress.current
        if form.get("step") != current.name or participant.progress.finished or current.game is not None:
            return _see_other("./")  # sent twice, or from a page that was left open
        events: list[tuple[str, dict[str, Any]]] = []
        wrong: dict[str, NotAnswered] = {}
        step, first = current.step, self.folder.study.language
        if isinstance(step, QuestionsStep):
            answers, wrong = read_answers(step, form, first)
            events.append(("answers", {"answers": answers}))
        elif isinstance(step, TextStep) and step.agree:
            if form.get("agree") != "yes":
                wrong["agree"] = NotAnswered("not_agreed")
            events.append(("agreed", {"text": said(step.agree, self.pages.language(participant.progress), first)}))
        given = {name: [v for v in form.getall(name) if isinstance(v, str)] for name in form}
        progress, code = participant.progress, participant.about["code"]
        if wrong:
            return _html(self.pages.step(progress, code, wrong, given), 422)
        try:
            await participant.finish_step(current.name, *events)
        except NotWritten as problem:
            self.say(str(problem))
            return _html(self.pages.step(progress, code, {}, given, "not_saved"), 503)
        return _see_other("./")

    async def _language(self, request: web.Request) -> web.StreamResponse:
        participant = self._admit(self._place(request))
        chosen = (await request.post()).get("language")
        if chosen in self.folder.study.languages and chosen != participant.progress.language:
            await participant.note("language", value=chosen)
        return _see_other("./")

    async def _event(self, request: web.Request) -> web.StreamResponse:
        """Take what a page of text tells of itself: whether it is in sight."""
        participant = self._admit(self._place(request))
        participant.heard()
        body = await request.content.read(MAX_EVENT)
        with contextlib.suppress(ValueError, RecursionError):
            told = json.loads(body)
            if isinstance(told, dict) and isinstance(told.get("look"), bool):
                await participant.begin_step()
                participant.look(told["look"])
        return web.Response(status=204)

    async def _alive(self, request: web.Request) -> web.StreamResponse:
        self._place(request)
        return web.Response(text="yes\n")

    # -- the open link ------------------------------------------------------------------------------------------------
    def _check_open(self, request: web.Request) -> None:
        if not secrets.compare_digest(request.match_info["token"].encode(), self.links.open.encode()):
            raise web.HTTPNotFound(text=self.pages.message("unknown"), content_type="text/html")

    def _mine(self, request: web.Request) -> int | None:
        place = self._places.get(request.cookies.get(COOKIE, ""))
        return place if place in self.participants and participant_name(place) not in self.removed else None

    async def _join(self, request: web.Request) -> web.StreamResponse:
        self._check_open(request)
        mine = self._mine(request)
        if mine is None and self._free_place() is None:
            return _html(self.pages.message("full"))
        return _html(self.pages.join(self.folder.study.language, mine is not None))

    async def _go(self, request: web.Request) -> web.StreamResponse:
        """Give somebody the next free place; who presses twice gets it once."""
        self._check_open(request)
        mine = self._mine(request)
        if (await request.post()).get("who") != "again" or mine is None:
            mine = self._free_place()
            if mine is None:
                return _html(self.pages.message("full"))
            self._admit(mine)
        token = self.links.places[mine - 1]
        response = _see_other(f"../../p/{token}/")
        response.headers.add("Set-Cookie", f"{COOKIE}={token}; Max-Age={COOKIE_S}; HttpOnly; SameSite=Lax")
        return response

    def _free_place(self) -> int | None:
        for place in range(1, self.folder.study.participants + 1):
            if place not in self.participants and participant_name(place) not in self.removed:
                return place
        return None

    # -- pages of games -----------------------------------------------------------------------------------------------
    async def _socket(self, request: web.Request) -> web.StreamResponse:
        """Serve one page of a game."""
        participant = self._admit(self._place(request))
        self._numbers += 1
        page = GamePage(self._numbers)
        await page.open(request)
        self._sockets[page.number] = page
        try:
            await participant.enter(page)
            async for message in page.socket:
                if message.type is WSMsgType.TEXT and not page.takes(message.data):
                    break
                if message.type is WSMsgType.TEXT:
                    participant.hear(page, message.data)
        finally:
            participant.leave(page)
            del self._sockets[page.number]
            await page.close(1008)
        return page.socket

    def _deliver(self, number: int, text: str) -> None:
        page = self._sockets.get(number)
        if page is not None:
            page.say(text)

    # -- the experimenter ---------------------------------------------------------------------------------------------
    async def remove(self, place: int) -> None:
        """Remove a participant's data, when nothing of his is open."""
        participant = self.participants.pop(place, None)
        if participant is not None:
            await participant.stop()
            await participant.put_away()
            await participant.close()
        self.folder.remove(participant_name(place))
        self.removed = self.folder.removed()


def _plain(status: int, text: str) -> web.Response:
    return web.Response(status=status, text=text + "\n", headers=HEADERS)


def _html(text: str, status: int = 200) -> web.Response:
    return web.Response(status=status, text=text, content_type="text/html")


def _see_other(where: str) -> web.Response:
    return web.Response(status=303, headers={"Location": where})
