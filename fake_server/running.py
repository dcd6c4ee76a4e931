"""Letting a server run: by the clock its options ask for, until a signal or its own end stops it."""

from __future__ import annotations

import contextlib
import signal
import threading
from collections.abc import Iterator

from fake_server.clock import RealTimeClock, SynchClock, Timing
from fake_server.options import ServerOptions
from fake_server.server import EpisodeCallback, Server
from fake_server.warm_up import warm_up


def run(server: Server, timing: Timing | None = None) -> int:
    """Let a server serve until it is stopped, then close everything.

    Parameters
    ----------
    server : Server
        It is started if it is not yet.
    timing : Timing, optional
        How long to wait in synch mode, instead of what the server's options say.

    Returns
    -------
    int
        Exit code.
    """
    if not server.started:
        server.start()
    try:
        if server.game.params["synch_mode"]:
            SynchClock(server, timing or Timing(server.options.patience)).run()
        else:
            RealTimeClock(server).run()
    finally:
        server.close()
    return server.exit_code


@contextlib.contextmanager
def stopped_by_signals(server: Server) -> Iterator[None]:
    """Let SIGINT, SIGTERM and SIGHUP end a server cleanly; in the main thread, which has its own handlers back then.

    Windows has no SIGHUP; there Ctrl-Break does the same.
    """
    names = ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK")
    numbers = [getattr(signal, name) for name in names if hasattr(signal, name)]
    before = [signal.signal(number, lambda *_: server.stop()) for number in numbers]
    try:
        yield
    finally:
        for number, handler in zip(numbers, before, strict=True):
            signal.signal(number, handler)


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
    on_episode : callable, optional
        See `Server`.
    timing : Timing, optional
        See `run`.

    Yields
    ------
    Server
        Its ports answer already.
    """
    options = options or ServerOptions()
    if seed is not None:
        options.seed = seed
    warm_up(quiet=True)
    server = Server(options, on_episode)
    server.start()
    thread = threading.Thread(target=run, args=(server, timing), name="fake-rcssserver", daemon=True)
    thread.start()
    try:
        yield server
    finally:
        server.stop()
        thread.join()
