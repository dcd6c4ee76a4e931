"""What players' plain commands do, and what everybody perceives, is the same as one by one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from fake_server import text
from fake_server.apply import act
from fake_server.connection import Nobody
from fake_server.game import Game
from fake_server.options import ServerOptions
from fake_server.perception import Perception
from fake_server.player_client import PlayerClient
from rcss_hat.protocol.commands import MAX_DATAGRAM
from rcss_hat.protocol.landmarks import N_LANDMARKS
from rcss_hat.protocol.params import ServerParams
from rcss_hat.protocol.records import SEE, SENSE_BODY, empty
from rcss_hat.protocol.see import team_names, write_see
from rcss_hat.simulation import body, hearing, vision
from rcss_hat.simulation.state import MAX_MESSAGES, N_PLAYERS

pytestmark = pytest.mark.compiled
DATAGRAMS = {
    0: b'(dash 80)(turn_neck 20)(say "1abc")(done)\0',
    1: b'(turn -35)(say "2xyz")(done)\0',
    2: b"(kick 40 15)(turn_neck -90)(done)\0",
    11: b"(dash -40)(done)\0",
    12: b"(done)\0",
}


def playing(profile: str = "19.0") -> tuple[Game, list[PlayerClient]]:
    """A game of Keepaway, three against two, that has been kicked off, with a ball at the third keeper's feet."""
    options = ServerOptions()
    params = ServerParams(profile, keepaway=True, synch_mode=True, visible_angle=360.0)
    game = Game(replace(options, params=params), seed=5)
    clients = [
        PlayerClient(game, game.join(team, 11, False), Nobody())
        for team, n in (("keepers", 3), ("takers", 2))
        for _ in range(n)
    ]
    game.step()
    game.kick_off()
    game.step()
    game.move_ball(*(game.match["pos"][0, 2] + 0.5).tolist(), (0.0, 0.0))
    return game, clients


def state(game: Game) -> tuple[bytes, bytes]:
    return game.match.tobytes(), game.streams.tobytes()


@pytest.mark.parametrize("profile", ["19.0", "11.1"])
def test_plain_commands_do_what_they_do_one_by_one(profile: str) -> None:
    (quick, obedient), (slow, spelled) = playing(profile), playing(profile)
    assert state(quick) == state(slow)
    for _ in range(4):
        for one, other in zip(obedient, spelled, strict=True):
            one.done = other.done = False
            assert not one.take(DATAGRAMS[one.i]) and not other.take(DATAGRAMS[other.i])
            assert one.done and other.done
            assert quick.goes_on_unwatched and one.obey()
            for command in other.commanded():
                act(slow, other.i, command)
        assert state(quick) == state(slow)
        assert quick.step() == slow.step()
        assert state(quick) == state(slow)
    assert quick.match["counts"][0].sum() > 0


def test_a_second_datagram_of_a_cycle_is_spelled_out() -> None:
    _, (client, *_) = playing()
    client.take(b"(dash 80)\0")
    client.take(b"(turn_neck 20)\0")
    client.take(b"(done)\0")
    assert client.done and not client.obey()
    assert [command.text() for command in client.commanded()] == ["(dash 80)", "(turn_neck 20)"]
    assert client.obey() and client.commanded() == [], "nothing is left to be done"


def one_by_one(game: Game, due: np.ndarray) -> list[tuple[int, bytes]]:
    """All that players perceive, each message by the kernels that write it."""
    told, buffer = [], np.zeros(MAX_DATAGRAM, dtype=np.uint8)
    see, sense = empty(SEE), empty(SENSE_BODY)
    order, ends = np.zeros((MAX_MESSAGES, 2), dtype=np.int32), np.zeros(MAX_MESSAGES, dtype=np.int64)
    players = [i for i in range(N_PLAYERS) if game.enabled(i)]
    for i in players:
        body.sense_body(game.world, i, sense)
        told.append((i, buffer[: text.write_sense_body(sense, game.match, i, buffer)].tobytes() + b"\0"))
    for i in players:
        n = hearing.deliver(game.world, i, order)
        text.write_hear(game.match, i, order, n, buffer, ends)
        starts = [0, *ends[:n]]
        told += [(i, buffer[starts[m] : starts[m + 1]].tobytes()) for m in range(n)]
    for i in players:
        names, sizes = team_names(*(("keepers", "takers") if i < 11 else ("takers", "keepers")))
        for _ in range(due[i]):
            vision.see(game.world, i, np.arange(N_LANDMARKS, dtype=np.uint8), True, see)
            told.append((i, buffer[: write_see(see, names, sizes, buffer)].tobytes() + b"\0"))
    return told


def test_everybody_perceives_what_he_would_alone() -> None:
    (game, clients), (other, others) = playing(), playing()
    due = np.zeros(N_PLAYERS, dtype=np.uint8)
    perception, seats = Perception(game), [client.i for client in clients]
    for k in range(3):
        for client in (*clients, *others):
            client.take(DATAGRAMS[client.i])
            client.obey()
        game.step()
        other.step()
        due[seats] = k, 1, 2, 0, 30
        told = [*perception.sense_body(seats), *perception.hear(seats), *perception.see(due)]
        assert told == one_by_one(other, due)
        assert state(game) == state(other)
    assert sum(data.startswith(b"(hear ") for _, data in told) == 7, "who hears two of a team misses the second"
