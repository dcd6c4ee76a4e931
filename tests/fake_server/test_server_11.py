"""The stand-in as server 11.1.2, against what that server says."""

from __future__ import annotations

import gzip
import json
from pathlib import Path
from typing import Any

import pytest
from server_clients import Clients, options, serving

from fake_server.options import ServerOptions
from fake_server.player_param import PlayerParams
from rcss_hat.protocol.params import Value

RECORDED: dict[str, Any] = json.loads(
    gzip.decompress((Path(__file__).parents[1] / "data" / "fake_server" / "server-11.1.2.json.gz").read_bytes())
)
SEED = 5
"""``player::random_seed`` of the recording."""
LCM_STEP = 258
"""Offset of that member in the server's parameters for monitors of version 2."""


def version_11(**player_params: Value) -> ServerOptions:
    wanted = options(profile="11.1")
    wanted.player_params = PlayerParams("11.1", **player_params)
    return wanted


@pytest.fixture(scope="module")
def clients():
    with serving(version_11(random_seed=SEED)) as clients:
        yield clients


@pytest.mark.parametrize(("first", "reply"), RECORDED["refusals"])
def test_first_datagrams_are_refused_as_by_11_1(clients: Clients, first: str, reply: str) -> None:
    client = clients.open()
    client.send(first)
    assert client.receive() == reply
    assert client.address is None


def without(message: str, *names: str) -> str:
    for name in names:
        start = message.index(f"({name} ")
        message = message[:start] + message[message.index(")", start) + 1 :]
    return message


def test_a_player_is_welcomed_as_by_11_1_with_the_same_player_types(clients: Clients) -> None:
    client = clients.open()
    client.send("(init keepers (version 11))")
    got = client.until(r"\(player_type \(id 6\)")
    ours = [message for message in got if not message.startswith(("(see", "(sense"))]
    theirs: list[str] = RECORDED["welcome"]
    switched_off = ("port", "coach_port", "olcoach_port")
    assert without(ours[1], *switched_off) == without(theirs[1], *switched_off)
    assert ours[0] == theirs[0]
    assert ours[2:] == theirs[2:]


def test_a_monitor_is_told_the_parameters_as_by_11_1(clients: Clients) -> None:
    client = clients.open()
    client.send("(dispinit version 2)")
    got = [client.receive_bytes() for _ in range(4)]
    for k, (ours, (size, text)) in enumerate(zip(got, RECORDED["monitor_2"], strict=True)):
        assert len(ours) == size
        theirs = bytes.fromhex(text)
        if k == 0:  # 3000 there, whatever it is made of, 300 here
            ours, theirs = (data[:LCM_STEP] + data[LCM_STEP + 2 :] for data in (ours, theirs))
        assert theirs.startswith(ours.rstrip(b"\0"))  # the original leaves chance bytes behind


def test_the_seed_of_the_types_is_not_told_unless_it_was_given() -> None:
    with serving(version_11()) as clients:
        client = clients.open()
        client.send("(init keepers (version 11))")
        assert "(random_seed -1)" in client.until(r"\(player_param")[-1]
