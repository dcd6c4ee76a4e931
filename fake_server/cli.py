"""The ``fake-rcssserver`` command."""

from __future__ import annotations

import contextlib
import signal
import sys
import threading
from collections.abc import Iterator, Sequence
from pathlib import Path

from fake_server.options import PROGRAM, USAGE, HelpRequested, UsageError, parse_options, without_effect


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command line and exit: 0 after a clean stop, 1 on failure, 2 for wrong usage."""
    sys.exit(run(sys.argv[1:] if arguments is None else arguments))


def run(arguments: Sequence[str]) -> int:
    """Run the command line; returns the exit code."""
    try:
        if arguments[:1] == ["replay"]:
            return _replay(arguments[1:])
        return _serve(arguments)
    except HelpRequested:
        print(USAGE, end="")
        return 0
    except UsageError as error:
        print(f"{PROGRAM}: {error}", file=sys.stderr)
        return 2
    except OSError as error:
        print(f"{PROGRAM}: {error.strerror or error}", file=sys.stderr)
        return 1


def _serve(arguments: Sequence[str]) -> int:
    options = parse_options(arguments)
    from fake_server.running import run as run_server
    from fake_server.running import stopped_by_signals
    from fake_server.server import Server
    from fake_server.warm_up import warm_up

    if not options.quiet:
        for name in without_effect(options):
            print(f"{PROGRAM}: {name} has no effect here", file=sys.stderr)
    with _ending_at_once():
        warm_up(options.quiet)
    server = Server(options)
    with stopped_by_signals(server):
        server.start()
        server.say(f"{PROGRAM}: a stand-in for rcssserver-{options.params.profile}\n")
        server.say(f"Simulator Random Seed: {server.seed}")
        server.say(
            f"Listening on {options.bind}: players and monitors {server.port}, trainer {server.coach_port}, "
            f"online coaches {server.olcoach_port}"
        )
        server.say("\nHit CTRL-C to exit")
        return run_server(server)


@contextlib.contextmanager
def _ending_at_once() -> Iterator[None]:
    """Let Ctrl-C end the program without an exception, which the compiler of kernels would lose or print."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_DFL)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _replay(arguments: Sequence[str]) -> int:
    files, port, bind = [], 6000, "127.0.0.1"
    rest = iter(arguments)
    for argument in rest:
        name, _, value = argument.partition("=")
        if argument in ("--help", "-h"):
            raise HelpRequested
        if name in ("--port", "--bind"):
            value = value or next(rest, "")
            if name == "--bind":
                bind = value
            elif value.isdigit() and int(value) < 65536:
                port = int(value)
            else:
                raise UsageError(f"--port takes a port, 0 to 65535, not {value!r}")
        elif argument.startswith("-"):
            raise UsageError(f"unknown option {argument!r}; replay takes FILE, --port P and --bind ADDRESS")
        else:
            files.append(Path(argument))
    if len(files) != 1:
        raise UsageError(f"replay takes one transcript: {PROGRAM} replay FILE [--port P]")
    from fake_server.replay import Replay, TranscriptError, read_transcript

    try:
        replay = Replay(read_transcript(files[0]), port, bind)
    except TranscriptError as error:
        print(f"{PROGRAM}: {error}", file=sys.stderr)
        return 1
    print(f"Replaying {files[0]} on {bind}: players {replay.port}, trainer {replay.coach_port}", flush=True)
    try:
        replay.run()
    except KeyboardInterrupt:
        return 0
    finally:
        replay.close()
    return 0
