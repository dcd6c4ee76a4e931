"""The server: its clients, what everybody is told of a step, and what clients do to each other.

A server is made of parts: `Game` (the match), `Reception` (the known ports), the clients, `Logs`, and a clock that
calls `Server.step`, `Server.send_sees` and, in synch mode, lets everybody think.
"""

from __future__ import annotations

import contextlib
import selectors
import signal
import socket
import threading
import time
from collections.abc import Callable, Iterator
from functools import partial

import numpy as np
from numpy.typing import NDArray

from fake_server import text
from fake_server.auto_mode import AutoMode
from fake_server.clock import RealTimeClock, SynchClock, Timing
from fake_server.connection import Address, Connection
from fake_server.game import Game
from fake_server.limits import Limits
from fake_server.logs import Logs
from fake_server.monitor import Frames, MonitorClient
from fake_server.options import ServerOptions
from fake_server.param_text import EVERYTHING, all_params
from fake_server.player_client import PlayerClient
from fake_server.reception import Reception
from fake_server.show import MESSAGE_BOARD
from fake_server.simulation.state import BEFORE_KICK_OFF, E_EPISODE_OUT, E_EPISODE_TAKEN, N_PLAYERS
from fake_server.trainer import TrainerClient
from fake_server.warm_up import warm_up
from rcss_hat.protocol.records import MAX_PLAYERS

Client = PlayerClient | TrainerClient | MonitorClient
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
    timing : Timing, optional
        How long to wait in synch mode, instead of what the options say.

    Attributes
    ----------
    seed : int
        Given, or taken from the clock.
    game : Game
    players : list
        The `PlayerClient` of every player index, or None.
    clients : dict
        All clients by address.
    port, coach_port, olcoach_port : int
        Where first datagrams go; known after `start`.
    running : bool
        False once `stop` was called.
    kicked_off : bool
        Set when the first kick-off happens.
    kick_off_wanted : bool
        Whether somebody asked for the first kick-off, which waits until everybody is done.
    exit_code : int
        1 after too many missed cycles, else 0.
    """

    def __init__(
        self, options: ServerOptions, on_episode: EpisodeCallback | None = None, timing: Timing | None = None
    ) -> None:
        self.options, self.on_episode, self._timing = options, on_episode, timing or Timing(options.patience)
        self._started = time.time()
        self.seed = options.seed if options.seed is not None else int(self._started)
        self.game = Game(options, self.seed)
        self.players: list[PlayerClient | None] = [None] * N_PLAYERS
        self.monitors: list[MonitorClient] = []
        self.trainer: TrainerClient | None = None
        self.clients: dict[Address, Client] = {}
        self.running = True
        self.kicked_off = self.kick_off_wanted = False
        self.exit_code = 0
        self._farewell = "Server Killed. Exiting..."
        self._first_step: float | None = None
        self._coach_said: list[str] = []
        self._frames = Frames(self.game)
        self._auto = AutoMode(self)
        self._limits = Limits(self)
        self._reception: Reception | None = None
        self._everybody = selectors.DefaultSelector()
        self._others = selectors.DefaultSelector()  # all but the players
        self._bell, self._ear = socket.socketpair()
        self._ear.setblocking(False)
        self._register(self._ear, self._hear_bell)

    # --- life -----------------------------------------------------------------------------------------------------
    def start(self) -> None:
        """Open ports and logs.

        Raises
        ------
        OSError
            When a port cannot be had or a log not be written; names it.
        """
        game = self.game
        try:
            reception = self._reception = Reception(self)
            head = all_params(game.params, game.player_params, game.types, EVERYTHING)
            self.logs = Logs(game.params, head, self._started)
        except OSError:
            self._close_sockets()
            raise
        self.port, self.coach_port, self.olcoach_port = reception.port, reception.coach_port, reception.olcoach_port
        for number, door in enumerate(reception.doors):
            self._register(door, partial(reception.read, number))

    def run(self) -> int:
        """Serve until stopped, then close everything; returns the exit code."""
        if self._reception is None:
            self.start()
        try:
            if self.game.params["synch_mode"]:
                SynchClock(self, self._timing).run()
            else:
                RealTimeClock(self).run()
        finally:
            self.close()
        return self.exit_code

    def stop(self, farewell: str | None = None) -> None:
        """End `run` soon; may be called from a signal handler or another thread."""
        if self.running and farewell:
            self._farewell = farewell
        self.running = False
        with contextlib.suppress(OSError):
            self._bell.send(b"\0")

    def close(self) -> None:
        """Give the logs their names and close all sockets; does nothing the second time."""
        if self._reception is None:
            return
        self.release()
        self.say(f"\n{self._farewell}")
        self.logs.close(self.game.match, self.game.teams)
        self._close_sockets()
        left, right = (repr(name) if name else "null" for name in self.game.teams)
        self.say(f"\nGame Results:\n\t{left} vs {right}\n\tScore: {self.game.score[0]} - {self.game.score[1]}")

    def _close_sockets(self) -> None:
        for client in self.clients.values():
            if client.connection is not None:
                client.connection.dispose()
        if self._reception is not None:
            self._reception.close()
            self._reception = None
        for selector in (self._everybody, self._others):
            selector.close()
        self._bell.close()
        self._ear.close()

    def _register(self, opened: socket.socket, read: Callable[[], object], player: bool = False) -> None:
        self._everybody.register(opened, selectors.EVENT_READ, read)
        if not player:
            self._others.register(opened, selectors.EVENT_READ, read)

    def _hear_bell(self) -> None:
        with contextlib.suppress(BlockingIOError):
            self._ear.recv(64)

    # --- datagrams ------------------------------------------------------------------------------------------------
    def read_all(self, timeout: float) -> None:
        """Wait for datagrams, at most so many seconds, and answer what came."""
        self._read(self._everybody, timeout)

    def read_others(self, timeout: float) -> None:
        """Wait for datagrams of others than players, at most so many seconds, and answer what came."""
        self._read(self._others, timeout)

    def _read(self, selector: selectors.BaseSelector, timeout: float) -> None:
        for key, _ in selector.select(timeout):
            key.data()
        self._remove_disconnected()

    def carry_out(self) -> None:
        """Carry out what players have commanded, the left team's first, by number."""
        for player in self.players:
            if player is not None:
                self.game.settle_randomness()  # before the match nobody's commands change what others' draw
                player.carry_out()
        self._remove_disconnected()

    def hold(self) -> None:
        """Keep all messages to players and trainer until `release`."""
        for connection in self._thinking():
            connection.hold()

    def release(self) -> None:
        """Send every player and the trainer what was kept, in a burst."""
        for connection in self._thinking():
            connection.release()

    def _thinking(self) -> Iterator[Connection]:
        for player in self.players:
            if player is not None:
                yield player.connection
        if self.trainer is not None and self.trainer.connection is not None:
            yield self.trainer.connection

    def start_thinking(self) -> list[PlayerClient | TrainerClient]:
        """Ask everybody to think who was told of a step; returns those who have to answer.

        The original lets players join only while others think, so that a step always comes before the first think.
        """
        players = [player for player in self.players if player is not None and player.told]
        thinkers: list[PlayerClient | TrainerClient] = [*players]
        if self.trainer is not None and self.trainer.eye:
            thinkers.append(self.trainer)
        for client in thinkers:
            client.done = False
            client.send("(think)")
        return thinkers

    # --- who is there ---------------------------------------------------------------------------------------------
    def add_player(self, player: PlayerClient) -> None:
        """Take a player's client in; one who had his place before is forgotten."""
        old = self.players[player.i]
        if old is not None:
            self._forget(old)
        self.players[player.i] = player
        self._add(player, player.connection)

    def add_monitor(self, monitor: MonitorClient) -> None:
        """Take a monitor in."""
        self.monitors.append(monitor)
        self._add(monitor, monitor.connection)

    def add_trainer(self, trainer: TrainerClient) -> None:
        """Take the trainer in."""
        self.trainer = trainer
        if trainer.connection is not None:
            self._add(trainer, trainer.connection)

    def _add(self, client: Client, connection: Connection) -> None:
        self.clients[connection.address] = client
        self._register(connection.socket, client.read, isinstance(client, PlayerClient))

    def _forget(self, client: Client) -> None:
        connection = client.connection
        if connection is None:
            return
        for selector in (self._everybody, self._others):
            with contextlib.suppress(KeyError):
                selector.unregister(connection.socket)
        connection.dispose()
        if self.clients.get(connection.address) is client:
            del self.clients[connection.address]

    def _remove_disconnected(self) -> None:
        for player in self.players:
            if player is not None and not player.connection.connected:
                self.player_left(player)
        if self.trainer is not None and not self.trainer.connected:
            self._forget(self.trainer)
            self.trainer = None
            self.say("An offline coach disconnected")
        if any(not monitor.connection.connected for monitor in self.monitors):
            for monitor in [monitor for monitor in self.monitors if not monitor.connection.connected]:
                self._forget(monitor)
                self.monitors.remove(monitor)
                self.say("A monitor disconnected")

    def player_left(self, player: PlayerClient) -> None:
        """Take out a player who said goodbye or is gone."""
        self._release(player)
        self.game.leave(player.i)

    def discard(self, i: int) -> None:
        """Take a player out on a monitor's command."""
        player = self.players[i]
        if player is not None:
            self._release(player)
        self.game.leave(i)

    def show_card(self, i: int, card: str) -> None:
        """Show a player a yellow or red card on a monitor's command, and take him out if that sends him off."""
        self.announce(self.game.cards.give(i, card))
        if self.game.cards.sent_off(i):
            self.discard(i)

    def _release(self, player: PlayerClient) -> None:
        self.players[player.i] = None
        self._forget(player)
        self.say(f"A player disconnected : ({self.game.team_name(player.i)} {self.game.unum(player.i)})")

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
            self.announce(announced)
        self._kick_off_in_time()
        self._show()
        self._auto.step()
        self._tell_players()
        if self.trainer is not None:
            self.trainer.see_global()

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

    def _show(self) -> None:
        if self.monitors:
            self._frames.new_step()
            for monitor in self.monitors:
                monitor.connection.send_bytes(self._frames.frame(monitor.version))
        self.logs.show(self.game.match, self.game.kernel, self.game.teams)

    def _tell_players(self) -> None:
        players = [player for player in self.players if player is not None]
        for player in players:
            player.sense_body()
            player.fullstate()
            player.told = True
        if self._coach_said:
            said, self._coach_said = self._coach_said, []
            for player in players:
                for message in said:
                    player.send(text.hear_coach(self.game.time, message))
        if self.game.match["n_heard"][0]:
            for player in players:
                player.hear()

    def send_sees(self, due: NDArray[np.uint8]) -> None:
        """Send so many see messages to every player."""
        for i in np.flatnonzero(due).tolist():
            player = self.players[i]
            if player is not None:
                for _ in range(int(due[i])):
                    player.see()

    # --- what clients do to each other ----------------------------------------------------------------------------
    def kick_off(self) -> None:
        """Start the match, or its next half."""
        for i, player_type in self.game.types_at_kick_off():
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
        self.announce(announced)

    def announce(self, messages: list[str]) -> None:
        """Let the referee say something to everybody."""
        for message in messages:
            heard = text.hear_referee(self.game.time, message)
            for player in self.players:
                if player is not None:
                    player.send(heard)
            if self.trainer is not None:
                self.trainer.hear_referee(message)
            self.logs.referee(self.game.match, message)
            self.tell_monitors(f"(referee {message})")
        self._limits.look(messages)

    def player_spoke(self, i: int, message: str) -> None:
        """Tell trainer, monitors and log what a player said; players hear it in the next cycle."""
        if self.trainer is not None:
            self.trainer.hear_player(i, message)
        who = f"(player {self.game.team_name(i)} {self.game.unum(i)})"
        self.logs.speech(self.game.match, who, message)
        self.tell_monitors(f"({who} {message})")

    def trainer_spoke(self, message: str) -> None:
        """Tell monitors and log what the trainer said; players hear it in the next cycle."""
        self._coach_said.append(message)
        self.logs.speech(self.game.match, "referee", message)
        self.tell_monitors(f"(referee {message})")

    def tell_monitors(self, message: str) -> None:
        """Show a message to monitors, which hear what is said only with ``send_comms``."""
        if self.monitors and self.game.params["send_comms"]:
            for monitor in self.monitors:
                monitor.message(MESSAGE_BOARD, message)

    def substitute(self, i: int, player_type: int) -> None:
        """Give a player another type, and tell everybody."""
        self.game.substitute(i, player_type)
        for player in self.players:
            if player is not None:
                player.tell_type(i)
        news = f"(change_player_type {'l' if i < MAX_PLAYERS else 'r'} {self.game.unum(i)} {player_type})"
        for monitor in self.monitors:
            monitor.message(MESSAGE_BOARD, news)
        self.logs.substitution(self.game.match, news)

    def say(self, line: str) -> None:
        """Print a line unless quiet."""
        if not self.options.quiet:
            print(line, flush=True)


def stop_on_signals(server: Server) -> None:
    """Let SIGINT, SIGTERM and SIGHUP end a server cleanly; for the main thread of a process that only serves."""
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, lambda *_: server.stop())


@contextlib.contextmanager
def running_server(
    options: ServerOptions | None = None,
    seed: int | None = None,
    on_episode: EpisodeCallback | None = None,
    timing: Timing | None = None,
) -> Iterator[Server]:
    """Run a server in a thread of this process, for tests and notebooks.

    Parameters
    ----------
    options : ServerOptions, optional
        With ports 0 any free ones are taken.
    seed : int, optional
        Instead of that of the options.
    on_episode, timing
        See `Server`.

    Yields
    ------
    Server
        Its ports answer already.
    """
    options = options or ServerOptions()
    if seed is not None:
        options.seed = seed
    warm_up(quiet=True)
    server = Server(options, on_episode, timing)
    server.start()
    thread = threading.Thread(target=server.run, name="fake-rcssserver", daemon=True)
    thread.start()
    try:
        yield server
    finally:
        server.stop()
        thread.join()
