"""Who holds whom in a live server: no object holds, over any way, one that holds it."""

from __future__ import annotations

import gc
import types
from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from server_clients import PATIENCE, Clients, keepaway, options

from fake_server.clock import SynchClock, Timing
from fake_server.options import ServerOptions
from fake_server.server import Server

_SHARED = (type, types.ModuleType, types.BuiltinFunctionType, types.CodeType)
"""Objects that belong to the program, not to a server."""


def held_by(thing: object) -> list[object]:
    """What an object refers to; of a function only what it closes over."""
    if isinstance(thing, types.FunctionType):
        return [cell.cell_contents for cell in thing.__closure__ or ()]
    return [held for held in gc.get_referents(thing) if not isinstance(held, _SHARED)]


def is_ours(thing: object) -> bool:
    return type(thing).__module__.partition(".")[0] in ("fake_server", "rcss_hat")


def walk(root: object) -> tuple[list[object], list[tuple[int, int]]]:
    """All objects that can be reached from one, and who (an index) holds whom."""
    things, index, holds = [root], {id(root): 0}, []
    for holder, thing in enumerate(things):
        for held in held_by(thing):
            if id(held) not in index:
                index[id(held)] = len(things)
                things.append(held)
            holds.append((holder, index[id(held)]))
    return things, holds


def circles(root: object) -> list[set[str]]:
    """Names of our classes whose instances hold themselves by way of each other."""
    things, holds = walk(root)
    holders, held = np.array(holds).T
    graph = coo_array((np.ones(len(holds)), (holders, held)), shape=(len(things), len(things)))
    labels = connected_components(graph.tocsr(), connection="strong")[1]
    members = defaultdict(list)
    for thing, label in zip(things, labels.tolist(), strict=True):
        members[label].append(thing)
    itself = {int(labels[holder]) for holder, other in holds if holder == other}
    rings = [ring for label, ring in members.items() if len(ring) > 1 or label in itself]
    return [names for ring in rings if (names := {type(thing).__name__ for thing in ring if is_ours(thing)})]


@contextmanager
def inhabited(wanted: ServerOptions) -> Iterator[Server]:
    """A server with two players, a monitor and, where it takes one, a trainer, after some steps."""
    server = Server(wanted)
    server.start()
    clients = Clients(server)
    doors = [("(init keepers (version 11))", server.port), ("(init takers (version 19))", server.port)]
    doors += [("(dispinit version 4)", server.port), ("(init (version 11))", server.coach_port)]
    for first, port in doors:
        client = clients.open(port)
        client.send(first)
        server.read_all(PATIENCE)
        client.receive()
        client.send("(turn 10)(say hello)(sense_body)" if port == server.port else "(eye on)")
        server.read_all(PATIENCE)
        server.carry_out()
        server.step()
    server.kick_off()
    yield server
    server.close()
    for client in clients.all:
        client.close()


@pytest.mark.parametrize("wanted", [keepaway(), options(coach_w_referee=True, auto_mode=True)])
def test_no_object_of_a_live_server_holds_who_holds_it(wanted: ServerOptions) -> None:
    with inhabited(wanted) as server:
        clock = SynchClock(server, Timing())
        assert circles(clock) == []
        found = {type(thing).__name__ for thing in walk(clock)[0]}
    assert {"Server", "Game", "Clients", "MonitorClient", "Connection", "Reception", "Audience", "AutoMode"} <= found
    assert ("TouchReferee" in found, "TrainerClient" in found) == (not wanted.params["keepaway"],) * 2


def test_a_circle_would_be_found() -> None:
    server = Server(keepaway())
    assert circles(server) == []
    server.clients.by_address[("", 0)] = server  # type: ignore[assignment]
    assert circles(server) == [{"Server", "Clients"}]
    server.clients.by_address.clear()
    server.game.cards.back = lambda: server.game  # type: ignore[attr-defined]
    assert circles(server)[0] >= {"Game", "Cards"}
    server.clients.close()
