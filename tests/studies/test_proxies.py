"""A study behind nginx and Caddy, as examples/people configures them: pages, forms, and games over WebSockets."""

from __future__ import annotations

import asyncio
import os
import re
import shutil
import socket
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from pathlib import Path

import aiohttp
import pytest

from rcss_hat.studies.address import Address
from rcss_hat.studies.folder import StudyFolder
from rcss_hat.studies.people_file import load_people
from rcss_hat.studies.scripted import ScriptedParticipant
from rcss_hat.studies.server import StudyServer

from .conftest import SMALL
from .serving import people_of, whole

EXAMPLES = Path(__file__).parents[2] / "examples" / "people"
pytestmark = [pytest.mark.compiled, pytest.mark.slow]


def free_port() -> int:
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        port: int = found.getsockname()[1]
        return port


def found(name: str) -> str:
    variable = f"{name.upper()}_PATH"
    path = shutil.which(os.environ.get(variable, name)) or shutil.which(f"/usr/sbin/{name}")
    return path or pytest.skip(f"found no {name}: install it, or set {variable} to its path")


@asynccontextmanager
async def running(*command: str) -> AsyncIterator[None]:
    process = await asyncio.create_subprocess_exec(*command, stderr=asyncio.subprocess.DEVNULL)
    try:
        yield
    finally:
        with suppress(ProcessLookupError):
            process.terminate()
        await process.wait()


def nginx(folder: Path, port: int, behind: int) -> list[str]:
    """Return a command that runs nginx with the example, but without TLS and on other ports."""
    text = (EXAMPLES / "nginx.conf").read_text()
    text = re.sub(r"(?m)^ *ssl_.*\n", "", text).replace("listen 443 ssl", f"listen 127.0.0.1:{port}")
    text = text.replace("127.0.0.1:8000", f"127.0.0.1:{behind}").replace("lab.example.org", "127.0.0.1")
    places = "".join(
        f"{kind}_temp_path {folder}/{kind};\n" for kind in ("proxy", "client_body", "fastcgi", "uwsgi", "scgi")
    )
    head = f"daemon off; pid {folder}/pid; error_log {folder}/error.log;\nevents {{}}\n"
    (folder / "nginx.conf").write_text(head + f"http {{\naccess_log off;\n{places}{text}}}\n")
    return [found("nginx"), "-p", str(folder), "-e", str(folder / "error.log"), "-c", str(folder / "nginx.conf")]


def caddy(folder: Path, port: int, behind: int) -> list[str]:
    """Return a command that runs Caddy with the example, but without TLS and on other ports."""
    text = (EXAMPLES / "Caddyfile").read_text()
    text = text.replace("lab.example.org {", f"http://127.0.0.1:{port} {{").replace(
        "127.0.0.1:8000", f"127.0.0.1:{behind}"
    )
    (folder / "Caddyfile").write_text("{\n\tadmin off\n}\n" + text)
    return [found("caddy"), "run", "--adapter", "caddyfile", "--config", str(folder / "Caddyfile")]


@pytest.mark.parametrize("proxy", [nginx, caddy])
async def test_a_participant_goes_through_the_study_behind_a_proxy(proxy: object, tmp_path: Path) -> None:
    assert callable(proxy)
    port, behind = free_port(), free_port()
    command = proxy(tmp_path, port, behind)
    folder = StudyFolder.begin(tmp_path / "out", load_people(str(SMALL)), rehearsal=True)
    address = Address(port=behind, public=f"http://127.0.0.1:{port}/hat")
    async with StudyServer(folder, address, 1, print, hurry=20.0) as server, running(*command):
        assert server.link(1).startswith(f"http://127.0.0.1:{port}/hat/p/")
        async with aiohttp.ClientSession() as session:
            one = ScriptedParticipant(server.link(1), "B", 1, 20.0)
            async with asyncio.timeout(120):
                told = await one.run(session)
            async with session.get(server.link(1).rstrip("/")) as response:
                assert response.status == 200 and str(response.url) == server.link(1)
            async with session.get(server.lab_link + "status") as response:
                assert (await response.json())["places"][0]["state"] == "finished"
            async with session.post(server.open_link + "go", data={"who": "new"}) as response:
                assert response.status == 200 and "/hat/p/" in str(response.url)
    mine = people_of(folder.path)["p001"]
    whole(mine)
    assert told.code == mine.about["code"]
