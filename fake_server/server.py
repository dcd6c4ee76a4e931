"""The server: carries out what clients ask for, and lets the time of its match go on.

A server is made of parts that do not know it: `Game` (the match), `Clients`, `Reception` (the known ports), `Logs` and
`Audience`, which tells everybody. `fake_server.running` lets it run by a clock.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from typing import Any

from fake_server.apply import act
from fake_server.audience import Audience
from fake_server.clients import Client, Clients
from fake_server.game import Game
from fake_server.game_log import JSON_LOG
from fake_server.logs import Logs
from fake_server.options import ServerOptions
from fake_server.param_text import EVERYTHING, all_params, json_params
from fake_server.player_client import PlayerClient
from fake_server.reactions import Arrival, Card, Complaint, Datagram, Discard, Placement, Reaction, Reply, Substitution
from fake_server.reception import Reception
from fake_server.soccer.auto_mode import AutoMode
from fake_server.trainer import TrainerClient
from rcss_hat.protocol import commands as said
from rcss_hat.protocol.play_modes import PLAY_MODE_IDS
from rcss_hat.simulation.state import BEFORE_KICK_OFF, E_EPISODE_OUT, E_EPISODE_TAKEN

EpisodeCallback = Callable[[int, int, int, bool], None]
"""Told number, start and end (cycles) of every finished episode, and whether the ball was taken."""
_ENDED = E_EPISODE_OUT | E_EPISODE_TAKEN


class Server:
    """A stand-in for rcssserver.

    Parameters
    ----------
    options : ServerOptions
    on_episode : callable, optional
        See EpisodeCallback; called in the server's thread.

    Attributes
    ----------
    seed : int
        Given, or taken from the clock.
    game : Game
    clients : Clients
    logs : Logs
        Once it was started, as `audience` and the ports.
    audience : Audience
    port, coach_port, olcoach_port : int
        Where first datagrams go.
    running : bool
        False once `stop` was called.
    kicked_off : bool
        Set when the first kick-off happens.
    kick_off_wanted : bool
        Whether somebody asked for the first kick-off, which waits until everybody is done.
    exit_code : int
        1 after too many missed cycles, else 0.
    """

    def __init__(self, options: ServerOptions, on_episode: EpisodeCallback | None = None) -> None:
        self.options, self.on_episode = options, on_episode
        self._started = time.time()
        self.seed = options.seed if options.seed is not None else int(self._started)
        self.game = Game(options, self.seed)
        self.clients = Clients()
        self.running = True
        self.kicked_off = self.kick_off_wanted = False
        self.exit_code = 0
        self._farewell = "Server Killed. Exiting..."
        self._first_step: float | None = None
        self._auto = AutoMode(self.game.params, self.game.match)
        self._reception: Reception | None = None

    # --- life -----------------------------------------------------------------------------------------------------
    @property
    def started(self) -> bool:
        """Whether its ports are open."""
        return self._reception is not None

    def start(self) -> None:
        """Open ports and logs.

        Raises
        ------
        OSError
            When a port cannot be had or a log not be written; names it.
        """
        game = self.game
        try:
            reception = self._reception = Reception(self.options, game, self.clients)
            self.logs = Logs(game.params, self._log_head(), self._started)
        except OSError:
            self._close_sockets()
            raise
        self.audience = Audience(game, self.clients, self.logs)
        self.port, self.coach_port, self.olcoach_port = reception.port, reception.coach_port, reception.olcoach_port
        for number, door in enumerate(reception.doors):
            self.clients.watch(door, number)

    def _log_head(self) -> list[str]:
        """Return the parameter messages of a game log."""
        game = self.game
        if game.params["game_log_version"] == JSON_LOG:
            return json_params(game.params, game.player_params, game.types)
        return all_params(game.params, game.player_params, game.types, EVERYTHING)

    def stop(self, farewell: str | None = None) -> None:
        """End the run soon; may be called from a signal handler or another thread."""
        if self.running and farewell:
            self._farewell = farewell
        self.running = False
        self.clients.ring()

    def close(self) -> None:
        """Give the logs their names and close all sockets; does nothing the second time."""
        if self._reception is None:
            return
        self.clients.release()
        self.say(f"\n{self._farewell}")
        self.logs.close(self.game.match, self.game.teams)
        self._close_sockets()
        left, right = (repr(name) if name else "null" for name in self.game.teams)
        self.say(f"\nGame Results:\n\t{left} vs {right}\n\tScore: {self.game.score[0]} - {self.game.score[1]}")

    def _close_sockets(self) -> None:
        self.clients.close()
        if self._reception is not None:
            self._reception.close()
            self._reception = None

    def say(self, line: str) -> None:
        """Print a line unless quiet."""
        if not self.options.quiet:
            print(line, flush=True)

    # --- datagrams ------------------------------------------------------------------------------------------------
    def read_all(self, timeout: float) -> None:
        """Wait for datagrams, at most so many seconds, and carry out what they ask for."""
        self._read(timeout, players=True)

    def read_others(self, timeout: float) -> None:
        """Wait for datagrams of others than players, at most so many seconds, and carry out what they ask for."""
        self._read(timeout, players=False)

    def _read(self, timeout: float, players: bool) -> None:
        for source in self.clients.wait(timeout, players):
            if not isinstance(source, int):
                for data in source.connection.receive():
                    self._take(source, data)
            elif self._reception is not None:
                for client, reaction in self._reception.read(source):
                    self._do(client, reaction)
        self._remove_disconnected()

    def _take(self, client: Client, data: bytes) -> None:
        self._log(client, data)
        for reaction in client.take(data):
            self._do(client, reaction)

    def _log(self, client: Client, data: bytes) -> None:
        if self.logs.wants_messages and client.who:
            self.logs.received(self.game.match, client.who, data.split(b"\0", 1)[0].decode("latin-1"))

    def _do(self, client: Client, reaction: Reaction) -> None:
        _CARRIED_OUT[type(reaction)](self, client, reaction)

    def carry_out(self) -> None:
        """Carry out what players have commanded, the left team's first, by number."""
        nobody_listens = self.audience.hears_no_player
        for player in self.clients.here():
            self.game.settle_randomness()  # before the match nobody's commands change what others' draw
            if not (nobody_listens and self.game.goes_on_unwatched and player.obey()):
                self._carry_out(player)
        self._remove_disconnected()

    def _carry_out(self, player: PlayerClient) -> None:
        for command in player.commanded():
            if isinstance(command, said.Bye):
                self.discard(player.i)
                return
            accepted, announced = act(self.game, player.i, command)
            self.audience.announce(announced)
            if accepted and isinstance(command, said.Say):
                self.audience.player_spoke(player.i, command.message)

    # --- who is there ---------------------------------------------------------------------------------------------
    def _admit(self, client: Client, arrival: Arrival) -> None:
        """Take a client in, and welcome it."""
        self.clients.add(client)
        for message in arrival.welcome:
            if isinstance(message, str):
                client.connection.send(message)
            else:
                client.connection.send_bytes(message)
        self.say(arrival.news)
        self._log(client, arrival.data)

    def _remove_disconnected(self) -> None:
        for client in self.clients.gone():
            if isinstance(client, PlayerClient):
                self.discard(client.i)
                continue
            self.clients.remove(client)
            self.say(f"{'An offline coach' if isinstance(client, TrainerClient) else 'A monitor'} disconnected")

    def discard(self, i: int) -> None:
        """Take a player out who said goodbye, is gone, or has to go on a monitor's command."""
        player = self.clients.players[i]
        if player is not None:
            self.clients.remove(player)
            self.say(f"A player disconnected : ({self.game.team_name(i)} {self.game.unum(i)})")
        self.game.leave(i)

    def _show_card(self, card: Card) -> None:
        """Show a player a card on a monitor's command, and take him out if that sends him off."""
        self.audience.announce(self.game.cards.give(card.i, card.colour))
        if self.game.cards.sent_off(card.i):
            self.discard(card.i)

    def substitute(self, i: int, player_type: int) -> None:
        """Give a player another type, and tell everybody."""
        self.game.substitute(i, player_type)
        self.audience.tell_substitution(i, player_type)

    # --- a step ---------------------------------------------------------------------------------------------------
    def step(self) -> None:
        """Simulate a step and tell everybody but what players see."""
        game = self.game
        if self._first_step is None:
            self._first_step = time.monotonic()
        announced = game.step()
        if game.match["events"][0] & _ENDED:
            self._end_episode()
        if announced:
            with game.as_of(game.announced_at):
                self.audience.announce(announced)
        self._kick_off_in_time()
        self.audience.show()
        if self._auto.kick_off_due():
            self.kick_off()
        if self._auto.is_over():
            self.stop("Game Over. Exiting...")
        self.audience.tell_step()

    def _end_episode(self) -> None:
        number, start, end, taken = self.game.last_episode()
        self.logs.episode(number, start, end, taken)
        if self.on_episode is not None:
            self.on_episode(number, start, end, taken)
        if self.options.episodes is not None and number >= self.options.episodes:
            self.stop(f"{number} episodes. Exiting...")

    def _kick_off_in_time(self) -> None:
        """Kick off when more than keepaway_start whole seconds have gone by since the first step."""
        if self.game.mode != BEFORE_KICK_OFF or not self.game.kernel["keepaway"][0]:
            return
        start = int(self.game.params.number("keepaway_start"))
        if start >= 0 and self._first_step is not None and int(time.monotonic() - self._first_step) > start:
            self.kick_off()

    # --- the start of a match -------------------------------------------------------------------------------------
    def kick_off(self) -> None:
        """Start the match, or its next half."""
        for i, player_type in self.game.line_up.at_kick_off():
            self.substitute(i, player_type)
        self._play(self.game.kick_off)

    @property
    def about_to_start(self) -> bool:
        """Whether nobody is asked to think any more before the first cycle of the match."""
        return self.kicked_off or self.kick_off_wanted

    def want_kick_off(self) -> None:
        """Kick off; before the match in synch mode not until everybody is done.

        Otherwise some would carry out commands of cycle 0 in a match that has begun, others not.
        """
        if self.game.params["synch_mode"] and self.game.waits_for_kick_off:
            self.kick_off_wanted = True
        else:
            self.kick_off()

    def kick_off_if_wanted(self) -> None:
        """Kick off if somebody asked for it, after a look for answers that came too late for their think."""
        if not self.kick_off_wanted:
            return
        self.read_all(0.0)
        self.carry_out()
        self.kick_off_wanted = False
        if self.game.waits_for_kick_off:
            self.kick_off()

    def change_mode(self, mode: int) -> None:
        """Change the play mode, as a trainer does."""
        self._play(lambda: self.game.change_mode(mode))

    def _play(self, act: Callable[[], list[str]]) -> None:
        """Do something that may be the first kick-off of Keepaway, and announce it."""
        match = self.game.match
        waiting = match["episode"][0] == 0
        announced = act()
        if waiting and match["episode"][0] > 0:
            self.kicked_off = True
            self.logs.keepaway_header(int(match["n_keepers"][0]), int(match["n_takers"][0]))
        self.audience.announce(announced)


_CARRIED_OUT: dict[type, Callable[[Server, Client, Any], object]] = {
    Reply: lambda server, client, asked: client.reply(asked.text),
    Complaint: lambda server, client, asked: None if server.options.quiet else print(asked.text, file=sys.stderr),
    Arrival: Server._admit,
    Datagram: lambda server, client, asked: server._take(client, asked.data),
    Placement: lambda server, client, asked: server.game.move_player(*asked),
    Substitution: lambda server, client, asked: server.substitute(*asked),
    Discard: lambda server, client, asked: server.discard(asked.i),
    Card: lambda server, client, asked: server._show_card(asked),
    said.Compression: lambda server, client, asked: client.connection.compress(asked.level),
    said.TrainerSay: lambda server, client, asked: server.audience.trainer_spoke(asked.message),
    said.Start: lambda server, client, asked: server.kick_off(),
    said.DispStart: lambda server, client, asked: server.want_kick_off(),
    said.DispBye: lambda server, client, asked: client.connection.close(),
    said.ChangeMode: lambda server, client, asked: server.change_mode(PLAY_MODE_IDS[asked.mode]),
    said.MoveBall: lambda server, client, asked: server.game.move_ball(asked.x, asked.y, asked.velocity or (0.0, 0.0)),
    said.Recover: lambda server, client, asked: server.game.recover(),
    said.DispFoul: lambda server, client, asked: server.audience.announce(
        server.game.call_foul(asked.side, asked.x, asked.y)
    ),
}
"""How what clients ask for is done."""
