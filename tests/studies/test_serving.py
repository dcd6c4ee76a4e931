"""A study that is served: what is kept through kills, breaks and second tabs, and what strangers can do."""

from __future__ import annotations

import asyncio
import json
import zipfile
from collections.abc import AsyncIterator
from contextlib import suppress
from io import BytesIO
from pathlib import Path

import aiohttp
import pytest
import pytest_asyncio

from rcss_hat.studies.address import Address
from rcss_hat.studies.folder import StudyFolder
from rcss_hat.studies.game_files import TABLES
from rcss_hat.studies.people_file import load_people
from rcss_hat.studies.scripted import ScriptedParticipant
from rcss_hat.studies.server import StudyServer

from .conftest import SMALL
from .serving import people_of, served, until, whole

pytestmark = [pytest.mark.asyncio(loop_scope="module"), pytest.mark.compiled]


@pytest_asyncio.fixture(loop_scope="module", scope="module")
async def server(tmp_path_factory: pytest.TempPathFactory) -> AsyncIterator[StudyServer]:
    """A study behind a public address, at twenty times the speed."""
    out = tmp_path_factory.mktemp("studies") / "small"
    folder = StudyFolder.begin(out, load_people(str(SMALL)), rehearsal=True)
    address = Address(public="https://lab.example.org/hat/")
    async with StudyServer(folder, address, 1, lambda text: None, hurry=20.0) as server:
        port = server._door._listener.sockets[0].getsockname()[1]  # type: ignore[union-attr]
        server.url = f"http://127.0.0.1:{port}/hat/"
        yield server


@pytest_asyncio.fixture(loop_scope="module")
async def session() -> AsyncIterator[aiohttp.ClientSession]:
    async with aiohttp.ClientSession(cookie_jar=aiohttp.CookieJar(unsafe=True)) as session:
        yield session


async def to_practice(server: StudyServer, session: aiohttp.ClientSession, place: int) -> None:
    form = {"step": "consent", "agree": "yes"}
    async with session.post(server.link(place) + "step", data=form, allow_redirects=False) as response:
        assert response.status == 303 and response.headers["Location"] == "./"


async def play(server: StudyServer, session: aiohttp.ClientSession, place: int) -> aiohttp.ClientWebSocketResponse:
    origin = {"Origin": server.url.removesuffix("/hat/")}
    return await session.ws_connect(server.link(place) + "socket", headers=origin)


async def test_three_in_three_conditions_come_to_the_end(server: StudyServer, session: aiohttp.ClientSession) -> None:
    people = [ScriptedParticipant(server.link(place), "B", place, 20.0) for place in (1, 2, 3)]
    told = await asyncio.gather(*(one.run(session) for one in people))
    kept = people_of(server.folder.path)
    for place, one in enumerate(told, 1):
        mine = kept[f"p00{place}"]
        whole(mine)
        assert one.code == mine.about["code"] and one.games == 5
        assert mine.progress.answers["about"]["words"] == "scripted"
        for planned in mine.plan:
            for kind, columns in TABLES.items() if planned.kept else ():
                head = (mine.folder / f"{planned.name}.{kind}.csv").read_text().partition("\n")[0]
                assert head.split(",") == list(columns)
    assert sorted(k.about["conditions"][0] for k in kept.values()) == ["fast", "limited", "normal"]
    limited = next(k for k in kept.values() if k.about["conditions"] == ["limited"])
    assert all(
        row.rpartition(",")[2] in ("0", "1") for row in (limited.folder / "play-limited.csv").read_text().split()[1:]
    )


async def test_nothing_is_kept_of_who_only_looks_at_a_link(server: StudyServer, session: aiohttp.ClientSession) -> None:
    async with session.get(server.link(4)) as response:
        assert response.status == 200
        page = await response.text()
    assert "<em>keys</em>" in page and "&lt;b&gt;x&lt;/b&gt;" in page and "https://" not in page
    assert not server.folder.folder_of(4).exists()


async def test_a_form_that_comes_twice_is_taken_once(server: StudyServer, session: aiohttp.ClientSession) -> None:
    async with session.post(server.link(5) + "step", data={"step": "consent"}) as response:
        assert response.status == 422 and 'href="#agree"' in await response.text()
    await to_practice(server, session, 5)
    await to_practice(server, session, 5)
    events = [e["event"] for e in people_of(server.folder.path)["p005"].events]
    assert events.count("agreed") == events.count("done") == 1


async def test_a_second_tab_takes_over_and_the_first_one_is_closed(
    server: StudyServer, session: aiohttp.ClientSession
) -> None:
    await to_practice(server, session, 6)
    first = await play(server, session, 6)
    assert json.loads(await first.receive_str())["type"] == "hello"
    second = await play(server, session, 6)
    hello = json.loads(await second.receive_str())
    assert hello["type"] == "hello" and hello["role"] == "player" and hello["plain"] is True
    async with asyncio.timeout(10):
        while (last := await first.receive()).type is aiohttp.WSMsgType.TEXT:
            pass
    assert (last.type, last.data) == (aiohttp.WSMsgType.CLOSE, 4001)
    await second.close()
    await until(server.participants[6]._inbox.empty)
    states = [e["state"] for e in people_of(server.folder.path)["p006"].events if e["event"] == "page"]
    assert states[:3] == ["opened", "replaced", "opened"]


HOSTILE = (
    "", "{}", "[" * 4000, '{"type": "press", "value": 1e999}', '{"type": "press", "value": "x"}',
    '{"type": "demonstration", "value": "stop"}', '{"type": "demonstration", "value": "drop"}',
    '{"type": "pace", "intervals": [-1]}', '{"type": "look", "value": 3}', '{"type": "seat"}', "\u0000", "x" * 4000,
)  # fmt: skip


async def test_hostile_messages_change_nothing(server: StudyServer, session: aiohttp.ClientSession) -> None:
    await to_practice(server, session, 7)
    socket = await play(server, session, 7)
    for message in HOSTILE:
        await socket.send_str(message)
    await socket.send_str('{"type": "demonstration", "value": "start"}')
    async with asyncio.timeout(20):
        while not (told := json.loads(await socket.receive_str())).get("started"):
            assert told["type"] != "farewell"
    assert server.participants[7].progress.current.name == "practice"
    await socket.close()


async def test_who_says_too_much_is_closed_and_nobody_else(server: StudyServer, session: aiohttp.ClientSession) -> None:
    await to_practice(server, session, 8)
    socket = await play(server, session, 8)
    with suppress(ConnectionError, aiohttp.ClientError):
        for _ in range(5_000):
            await socket.send_str('{"type": "press", "value": 1}')
    async with asyncio.timeout(20):
        while (await socket.receive()).type is aiohttp.WSMsgType.TEXT:
            pass
    again = await play(server, session, 8)
    assert json.loads(await again.receive_str())["type"] == "hello"
    await again.close()


@pytest.mark.parametrize("origin", [None, "https://evil.example", "null"])
async def test_games_are_for_the_studys_own_pages(
    server: StudyServer, session: aiohttp.ClientSession, origin: str | None
) -> None:
    headers = {} if origin is None else {"Origin": origin}
    with pytest.raises(aiohttp.WSServerHandshakeError) as error:
        await session.ws_connect(server.link(9) + "socket", headers=headers)
    assert error.value.status == 403
    async with session.post(server.link(9) + "step", data={"step": "consent"}, headers=headers) as response:
        assert response.status == (422 if origin is None else 403)


async def test_other_names_and_other_links_are_nobodys(server: StudyServer, session: aiohttp.ClientSession) -> None:
    async with session.get(server.link(9), headers={"Host": "evil.example"}) as response:
        assert response.status == 403
    for host in ("lab.example.org", "localhost:1234"):
        async with session.get(server.link(9), headers={"Host": host}) as response:
            assert response.status == 200
    for path in ("p/nobody/", "join/nobody/", "lab/nobody/", "lab/nobody/status", "lab/nobody/data.zip", "p/../x"):
        async with session.get(server.url + path) as response:
            assert response.status == 404
            assert response.headers["Referrer-Policy"] == "same-origin"


async def test_the_open_link_gives_the_next_free_place_once(server: StudyServer) -> None:
    places = []
    for _ in range(2):
        async with aiohttp.ClientSession(cookie_jar=aiohttp.CookieJar(unsafe=True)) as someone:
            async with someone.get(server.open_link) as response:
                assert "Begin" in await response.text()
            for who in ("new", "again"):
                async with someone.post(server.open_link + "go", data={"who": who}, allow_redirects=False) as response:
                    places.append(response.headers["Location"].split("/")[3])
    assert places[0] == places[1] != places[2] == places[3]


async def test_the_experimenter_sees_extends_stops_and_removes(
    server: StudyServer, session: aiohttp.ClientSession
) -> None:
    await to_practice(server, session, 10)

    async def do(**what: object) -> tuple[int, dict[str, object]]:
        async with session.post(server.lab_link + "do", json={"place": 10, **what}) as response:
            return response.status, await response.json()

    async def seen() -> dict[str, object]:
        async with session.get(server.lab_link + "status") as response:
            found: dict[str, object] = (await response.json())["places"][9]
            return found

    assert (await seen())["state"] == "here" and (await seen())["wanted"] == 2
    assert (await do(action="extend", games=3))[0] == 200 and (await seen())["wanted"] == 5
    assert (await do(action="extend", games=10**9))[0] == 409
    assert (await do(action="dance"))[0] == 409
    socket = await play(server, session, 10)
    assert (await do(action="stop"))[0] == 200
    async with asyncio.timeout(20):
        while json.loads(await socket.receive_str())["type"] != "farewell":
            pass
    await socket.close()
    async with session.get(server.link(10)) as response:
        assert "ended for you by the experimenter" in await response.text()
    async with session.get(server.lab_link + "data.zip") as response:
        packed = zipfile.ZipFile(BytesIO(await response.read()))
    names = packed.namelist()
    assert "participants/p010/journal.jsonl" in names and not any("key" in n and "keys.csv" not in n for n in names)
    assert (await do(action="remove"))[0] == 200
    assert not server.folder.folder_of(10).exists()
    async with session.get(server.link(10)) as response:
        assert response.status == 410
    assert (await seen())["state"] == "removed"


@pytest.mark.slow
async def test_killed_at_random_moments_it_loses_the_running_game_and_no_more(tmp_path: Path) -> None:
    study = tmp_path / "study.toml"
    study.write_text(
        SMALL.read_text().replace("episodes = 3", "episodes = 6\nspeed = 10").replace("speed = 5", "speed = 20")
    )
    out = tmp_path / "out"
    async with served(study, out) as server, aiohttp.ClientSession() as session:
        people = [ScriptedParticipant(server.links[k], "A", k, 10.0) for k in range(3)]
        way = asyncio.gather(*(one.run(session) for one in people))
        for pause in (2.5, 3.5):
            await asyncio.sleep(pause)
            before = {name: _games(kept.folder) for name, kept in people_of(out).items()}
            await server.kill()
            await server.start()
            after = {name: _games(kept.folder) for name, kept in people_of(out).items()}
            assert all(after[name][: len(games)] == games for name, games in before.items())
        told = await way
    kept = people_of(out)
    for one, mine in zip(told, kept.values(), strict=True):
        whole(mine)
        assert one.code == mine.about["code"]
    assert sum(e["event"] == "resumed" for mine in kept.values() for e in mine.events) >= 2


def _games(folder: Path) -> list[dict[str, object]]:
    """Games in the headers of the demonstrations, as they are on the disk now."""
    found: list[dict[str, object]] = []
    for file in sorted(folder.glob("play*.json")):
        found += json.loads(file.read_text())["episodes"]
    return found


async def test_a_worker_that_is_killed_is_replaced(server: StudyServer, session: aiohttp.ClientSession) -> None:
    one = ScriptedParticipant(server.link(11), "C", 11, 20.0)
    way = asyncio.create_task(one.run(session))
    await until(lambda: 11 in server.participants and server.participants[11].progress.played["practice"].matches > 0)
    worker = server.pool._workers[0]
    assert worker is not None
    worker.process.kill()
    await way
    mine = people_of(server.folder.path)["p011"]
    whole(mine)
    assert any(e["event"] == "failed" for e in mine.events)


async def test_a_full_disk_is_waited_for(
    server: StudyServer, session: aiohttp.ClientSession, monkeypatch: pytest.MonkeyPatch
) -> None:
    from rcss_hat.studies import journal
    from rcss_hat.system.files import NotWritten

    await to_practice(server, session, 12)
    place = server.participants[12]
    await until(lambda: place._inbox.empty())

    def full(path: Path, data: bytes) -> None:
        raise NotWritten(f"{path} was not written: No space left on device")

    real = journal.append
    monkeypatch.setattr(journal, "append", full)
    with pytest.raises(NotWritten):
        await place.note("language", value="de")
    assert place.progress.language is None and "No space left" in place.trouble
    place.note_later("language", value="de")
    await asyncio.sleep(0.1)
    monkeypatch.setattr(journal, "append", real)
    await until(lambda: place.progress.language == "de", 10.0)
    assert place.trouble == ""
