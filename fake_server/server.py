"""The server: sockets, clients, and the loop in synch mode and in real time.

In synch mode a cycle is: simulation step, sense_body and what was said, the see messages due before the think,
``(think)`` to everybody, a wait until all have said ``(done)``, their commands, and the see messages that are due
before the next step. What arrives during the wait is kept and carried out in the order of the players' numbers, so
that a seeded match does not depend on the order in which datagrams arrive.
"""

from __future__ import annotations

import contextlib
import selectors
import signal
import socket
import sys
import threading
import time
from collections.abc import Callable, Iterator

import numpy as np

from fake_server import text
from fake_server.connection import Address, Connection
from fake_server.game import Game, JoinError
from fake_server.logs import Logs
from fake_server.monitor import VERSIONS, MonitorClient
from fake_server.options import ServerOptions
from fake_server.param_text import all_params
from fake_server.player_client import PlayerClient
from fake_server.show import MESSAGE_BOARD
from fake_server.simulation import clock
from fake_server.simulation.clock import STEP_DUE
from fake_server.simulation.state import (
    BEFORE_KICK_OFF,
    E_EPISODE_OUT,
    E_EPISODE_TAKEN,
    N_PLAYERS,
    TIME_OVER,
)
from fake_server.trainer import TrainerClient
from fake_server.warm_up import warm_up
from rcss_hat.protocol import commands as said

TICK_S = clock.TICK_MS / 1000.0
PAUSE_BEFORE_KICK_OFF = 0.05
"""Seconds between think steps before the match; an arriving datagram cuts it short."""
WAIT_FOR_DONE = 1.25
MOST_MISSES = 20
_DONE = b"(done)"
_ALL_PARAMETERS = 10**6

Client = PlayerClient | TrainerClient | MonitorClient
EpisodeCallback = Callable[[int, int, int, bool], None]
"""Told number, start, end (cycles) and whether it was taken, of every finished episode."""


class Server:
    """A stand-in for rcssserver.

    Parameters
    ----------
    options : ServerOptions
    on_episode : callable, optional
    wait : float
        Seconds to wait for ``(done)`` in synch mode.

    Attributes
    ----------
    seed : int
    port, coach_port, olcoach_port : int
        Where first datagrams go.
    exit_code : int
        1 after too many missed cycles, else 0.

    Raises
    ------
    OSError
        When a port cannot be had.
    """

    def __init__(
        self, options: ServerOptions, on_episode: EpisodeCallback | None = None, wait: float = WAIT_FOR_DONE
    ) -> None:
        self.options, self.on_episode, self._wait = options, on_episode, wait
        started = time.time()
        self.seed = options.seed if options.seed is not None else int(started)
        self.game = Game(options, self.seed)
        self.exit_code = 0
        self.players: list[PlayerClient | None] = [None] * N_PLAYERS
        self.monitors: list[MonitorClient] = []
        self.trainer: TrainerClient | None = None
        self._clients: dict[Address, Client] = {}
        self._due = np.zeros(N_PLAYERS, dtype=np.uint8)
        self._stopping = False
        self._kicked_off = False
        self._first_step: float | None = None
        self._misses = 0
        self._over = 0
        self._selector = selectors.DefaultSelector()
        self._wake, self._woken = socket.socketpair()
        self._woken.setblocking(False)
        self._selector.register(self._woken, selectors.EVENT_READ)
        try:
            self._doors = [self._open(name) for name in ("port", "coach_port", "olcoach_port")]
        except OSError:
            self._close_sockets()
            raise
        self.port, self.coach_port, self.olcoach_port = (int(d.getsockname()[1]) for d in self._doors)
        params = options.params
        head = all_params(params, options.player_params, self.game.types, _ALL_PARAMETERS)
        self.logs = Logs(params, head, started)

    def _open(self, name: str) -> socket.socket:
        port = int(self.options.params.number(name))
        door = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        door.setblocking(False)
        try:
            door.bind((self.options.bind, port))
        except OSError as error:
            door.close()
            raise OSError(
                error.errno, f"cannot listen on {self.options.bind}, UDP port {port} ({name}): {error.strerror}"
            ) from None
        self._selector.register(door, selectors.EVENT_READ)
        return door

    # --- life -----------------------------------------------------------------------------------------------------
    def run(self) -> int:
        """Serve until stopped; returns the exit code."""
        try:
            if self.options.params["synch_mode"]:
                self._run_synch()
            else:
                self._run_real_time()
        finally:
            self.close()
        return self.exit_code

    def stop(self) -> None:
        """End `run` soon; may be called from a signal handler or another thread."""
        self._stopping = True
        with contextlib.suppress(OSError):
            self._wake.send(b"\0")

    def close(self) -> None:
        """Finish the logs and close all sockets; does nothing the second time."""
        if self._selector.get_map() is None:
            return
        self.logs.close(self.game.match, self.game.teams)
        self._close_sockets()

    def _close_sockets(self) -> None:
        for key in list(self._selector.get_map().values()):
            key.fileobj.close()  # type: ignore[union-attr]
        self._selector.close()
        self._wake.close()

    # --- the loop -------------------------------------------------------------------------------------------------
    def _run_synch(self) -> None:
        game = self.game
        while not self._stopping:
            self._step()
            clock.sees_before_think(game.match, game.kernel, self._due)
            self._send_sees()
            self._kicked_off = False
            self._think()
            if self._kicked_off:
                game.match["clock"] = 0  # the first cycle of a match is the first of its clock
            else:
                clock.sees_after_think(game.match, game.kernel, self._due)
                self._send_sees()

    def _run_real_time(self) -> None:
        game = self.game
        factor = max(1, int(game.params.number("slow_down_factor")))
        next_tick = time.monotonic()
        while not self._stopping:
            next_tick += TICK_S * factor
            self._gather_until(next_tick)
            next_tick = max(next_tick, time.monotonic() - TICK_S)  # time that was lost is not caught up
            self._execute_all()
            if clock.tick(game.match, game.kernel, self._due) & STEP_DUE:
                due = self._due.copy()
                self._step()
                self._due[:] = due
            self._send_sees()

    def _gather_until(self, when: float) -> None:
        while not self._stopping and (left := when - time.monotonic()) > 0.0:
            self._gather(left)

    def _step(self) -> None:
        game = self.game
        if self._first_step is None:
            self._first_step = time.monotonic()
        was_playing = game.match["episode"][0] > 0
        announced = game.step()
        if was_playing and game.match["events"][0] & (E_EPISODE_OUT | E_EPISODE_TAKEN):
            self._episode_ended()
        self.announce(announced)
        self._start_in_time()
        for monitor in self.monitors:
            monitor.show()
        self.logs.show(game.match, game.kernel, game.teams)
        self._tell_players()
        if self.trainer is not None:
            self.trainer.see_global()
        self._remove_dead()
        if game.mode == TIME_OVER:
            self._over += 1
            if self._over > game.params.number("game_over_wait"):
                self.stop()

    def _tell_players(self) -> None:
        players = [player for player in self.players if player is not None]
        for player in players:
            player.sense_body()
        if self.trainer is not None and self.trainer.to_say:
            for message in self.trainer.to_say:
                for player in players:
                    player.send(text.hear_coach(self.game.time, message))
            self.trainer.to_say.clear()
        for player in players:
            player.hear()

    def _send_sees(self) -> None:
        if not self._due.any():
            return
        for i in np.flatnonzero(self._due):
            player = self.players[i]
            for _ in range(int(self._due[i]) if player is not None else 0):
                player.see()  # type: ignore[union-attr]

    def _episode_ended(self) -> None:
        number, start, end, taken = self.game.last_episode()
        self.logs.episode(number, start, end, taken)
        if self.on_episode is not None:
            self.on_episode(number, start, end, taken)
        if self.options.episodes is not None and number >= self.options.episodes:
            self.stop()

    def _start_in_time(self) -> None:
        """Kick off when keepaway_start whole seconds have gone by since the first step."""
        start = self.game.params.number("keepaway_start")
        if start < 0 or not self.game.kernel["keepaway"][0] or self.game.mode != BEFORE_KICK_OFF:
            return
        assert self._first_step is not None
        if int(time.monotonic() - self._first_step) > start:
            self.kick_off()

    # --- think ----------------------------------------------------------------------------------------------------
    def _waiting(self) -> list[PlayerClient | TrainerClient]:
        waiting: list[PlayerClient | TrainerClient] = [
            p for p in self.players if p is not None and not p.done and p.connection.connected
        ]
        trainer = self.trainer
        if trainer is not None and trainer.waited_for and not trainer.done and trainer.connection.connected:
            waiting.append(trainer)
        return waiting

    def _think(self) -> None:
        game = self.game
        if game.time <= 0 and game.mode == BEFORE_KICK_OFF:
            self._gather(PAUSE_BEFORE_KICK_OFF)
        for player in self.players:
            if player is not None:
                player.done = False
                player.send("(think)")
        if self.trainer is not None:
            self.trainer.done = False
            if self.trainer.waited_for:
                self.trainer.send("(think)")
        give_up = time.monotonic() + self._wait
        if not self._waiting():
            self._gather(0.0)
        while (waiting := self._waiting()) and not self._stopping:
            left = give_up - time.monotonic()
            if left <= 0.0:
                self._missed()
                break
            if all(any(_DONE in data for data in client.inbox) for client in waiting):
                self._execute_all()
            else:
                self._gather(left)
        else:
            self._misses = 0
        self._execute_all()

    def _missed(self) -> None:
        if self.game.time <= 0:
            return
        print(f"Someone missed a cycle at {self.game.time}", file=sys.stderr, flush=True)
        self._misses += 1
        if self._misses > MOST_MISSES:
            print("Waiting too long for clients! Exiting", file=sys.stderr, flush=True)
            self.exit_code = 1
            self.stop()

    # --- datagrams ------------------------------------------------------------------------------------------------
    def _gather(self, timeout: float) -> None:
        """Wait for datagrams, at most ``timeout`` seconds, and put those of clients into their inboxes."""
        for key, _ in self._selector.select(max(timeout, 0.0)):
            client: Client | None = key.data
            if client is not None:
                client.inbox.extend(client.connection.receive())
                if not client.connection.connected:
                    self._forget_socket(key.fileobj)
            elif key.fileobj is self._woken:
                self._woken.recv(64)
            else:
                self._answer_door(key.fileobj)  # type: ignore[arg-type]

    def _execute_all(self) -> None:
        """Carry out what came, in the order of the players' numbers, then trainer and monitors."""
        clients: list[Client] = [p for p in self.players if p is not None]
        if self.trainer is not None:
            clients.append(self.trainer)
        clients.extend(self.monitors)
        for client in clients:
            if client.inbox:
                datagrams, client.inbox = client.inbox, []
                for data in datagrams:
                    client.execute(data)
        self._remove_dead()

    def _answer_door(self, door: socket.socket) -> None:
        try:
            data, address = door.recvfrom(text.MAX_MESSAGE)
        except OSError:
            return
        known = self._clients.get(address)
        if known is not None and known.connection.connected:
            self._at_wrong_door(known, data)
        elif door is self._doors[0]:
            self._welcome(data, address)
        elif door is self._doors[1]:
            self._welcome_trainer(data, address)
        else:
            self._refuse(door, address, "(error no_such_team_or_already_have_coach)")

    def _at_wrong_door(self, client: Client, data: bytes) -> None:
        if isinstance(client, MonitorClient):
            client.inbox.append(data)
        elif isinstance(client, PlayerClient) and client.version < 8:
            client.inbox.append(data)
        else:
            client.connection.send("(error only_init_allowed_on_init_port)")

    def _refuse(self, door: socket.socket, address: Address, reply: str) -> None:
        with contextlib.suppress(OSError):
            door.sendto(reply.encode("latin-1") + b"\0", address)

    def _welcome(self, data: bytes, address: Address) -> None:
        command = said.parse_init(data, self.game.params.profile)
        try:
            if isinstance(command, said.Refusal):
                raise JoinError(command.text)
            if isinstance(command, said.DispInit):
                self._add_monitor(command, address)
                return
            if isinstance(command, said.Init):
                i = self.game.join(command.team, command.version, command.goalie)
                reply = text.init_reply("l" if i < N_PLAYERS // 2 else "r", self.game.unum(i), self.game.mode_name)
            else:
                i = self.game.rejoin(command.team, command.unum)
                reply = text.reconnect_reply("l" if i < N_PLAYERS // 2 else "r", self.game.mode_name)
        except JoinError as refusal:
            self._refuse(self._doors[0], address, str(refusal))
            return
        old = self.players[i]
        if old is not None:
            self._drop(old)
        player = PlayerClient(self, i, Connection(self.options.bind, address))
        self.players[i] = player
        self._add(player)
        if self.logs.wants_messages:
            message = data.split(b"\0", 1)[0].decode("latin-1")
            self.logs.received(self.game.match, player.who, message)
        player.welcome(reply)

    def _add_monitor(self, command: said.DispInit, address: Address) -> None:
        if command.version not in VERSIONS or (self.game.params.profile == "11.1" and command.version not in (1, 2)):
            raise JoinError("(error illegal_client_version)")
        most = int(self.game.params.number("max_monitors"))
        if 0 <= most <= len(self.monitors):
            raise JoinError("(error no_more_monitor)")
        monitor = MonitorClient(self, Connection(self.options.bind, address), int(command.version))
        self.monitors.append(monitor)
        self._add(monitor)
        monitor.welcome()

    def _welcome_trainer(self, data: bytes, address: Address) -> None:
        door = self._doors[1]
        params = self.game.params
        if not params["coach"] and not params["coach_w_referee"]:
            self._refuse(door, address, "(error connected_offline_coach_without_coach_mode)")
            return
        if self.trainer is not None:
            self._refuse(door, address, "(error already_have_offline_coach)")
            return
        command = said.parse_trainer_init(data)
        if not isinstance(command, said.TrainerInit):
            self._refuse(door, address, command.text if command is not None else "(error illegal_command_form)")
            return
        self.trainer = TrainerClient(self, Connection(self.options.bind, address), int(command.version))
        self._add(self.trainer)
        self.trainer.welcome()

    def _add(self, client: Client) -> None:
        self._clients[client.connection.address] = client
        if client.connection.connected:
            self._selector.register(client.connection.socket, selectors.EVENT_READ, client)

    def _forget_socket(self, fileobj: object) -> None:
        with contextlib.suppress(KeyError, ValueError):
            self._selector.unregister(fileobj)  # type: ignore[arg-type]

    def _drop(self, client: Client) -> None:
        self._forget_socket(client.connection.socket)
        client.connection.close()
        if self._clients.get(client.connection.address) is client:
            del self._clients[client.connection.address]

    def _remove_dead(self) -> None:
        """Take out clients whose sockets are gone."""
        for player in self.players:
            if player is not None and not player.connection.connected:
                self.player_left(player)
        if self.trainer is not None and not self.trainer.connection.connected:
            self._drop(self.trainer)
            self.trainer = None
        for monitor in [m for m in self.monitors if not m.connection.connected]:
            self._drop(monitor)
            self.monitors.remove(monitor)

    # --- what clients do to each other ----------------------------------------------------------------------------
    def kick_off(self) -> None:
        """Start the match."""
        first = self.game.match["episode"][0] == 0
        announced = self.game.kick_off()
        if first and self.game.match["episode"][0] > 0:
            self._kicked_off = True
            match = self.game.match
            self.logs.keepaway_header(int(match["n_keepers"][0]), int(match["n_takers"][0]))
        self.announce(announced)

    def announce(self, messages: list[str]) -> None:
        """Let the referee say something to everybody."""
        send_comms = bool(self.game.params["send_comms"])
        for message in messages:
            heard = text.hear_referee(self.game.time, message)
            for player in self.players:
                if player is not None:
                    player.send(heard)
            if self.trainer is not None:
                self.trainer.hear_referee(message)
            if send_comms:
                for monitor in self.monitors:
                    monitor.message(MESSAGE_BOARD, f"(referee {message})")
            self.logs.referee(self.game.match, message)

    def player_spoke(self, player: PlayerClient, message: str) -> None:
        """Tell trainer, monitors and log of what a player said; players hear it in the next cycle."""
        if self.trainer is not None:
            self.trainer.hear_player(player.i, message)
        who = f"(player {self.game.team_name(player.i)} {self.game.unum(player.i)})"
        if self.game.params["send_comms"]:
            for monitor in self.monitors:
                monitor.message(MESSAGE_BOARD, f"({who} {message})")
        self.logs.speech(self.game.match, who, message)

    def player_left(self, player: PlayerClient) -> None:
        """Take out a player who said goodbye or is gone."""
        self.players[player.i] = None
        self.game.leave(player.i)
        self._drop(player)
        team, unum = self.game.team_name(player.i), self.game.unum(player.i)
        self.say(f"A player disconnected : ({team} {unum})")

    def discard(self, i: int) -> None:
        """Take a player out on a monitor's command."""
        player = self.players[i]
        self.game.discard(i)
        if player is not None:
            self.players[i] = None
            self._drop(player)

    def tell_type(self, i: int) -> None:
        """Tell all players of a substitution."""
        for player in self.players:
            if player is not None:
                player.tell_type(i)

    def say(self, line: str) -> None:
        """Print a line unless quiet."""
        if not self.options.quiet:
            print(line, flush=True)


@contextlib.contextmanager
def signals_stop(server: Server) -> Iterator[None]:
    """Let SIGINT and SIGTERM end a server cleanly."""
    before = {number: signal.signal(number, lambda *_: server.stop()) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


@contextlib.contextmanager
def running_server(
    options: ServerOptions, on_episode: EpisodeCallback | None = None, wait: float = WAIT_FOR_DONE
) -> Iterator[Server]:
    """Run a server in a thread of this process, for tests and notebooks.

    Yields
    ------
    Server
        Its ports answer already.
    """
    warm_up(quiet=True)
    server = Server(options, on_episode, wait)
    thread = threading.Thread(target=server.run, name="fake-rcssserver", daemon=True)
    thread.start()
    try:
        yield server
    finally:
        server.stop()
        thread.join(10.0)
