"""The ``fake-rcssserver`` command."""

from __future__ import annotations

import sys
from collections.abc import Sequence
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
    from fake_server.server import Server, stop_on_signals
    from fake_server.warm_up import warm_up

    if not options.quiet:
        for name in without_effect(options):
            print(f"{PROGRAM}: {name} has no effect here", file=sys.stderr)
    warm_up(options.quiet)
    server = Server(options)
    stop_on_signals(server)
    server.start()
    server.say(f"{PROGRAM}: a stand-in for rcssserver-{options.params.profile}\n")
    server.say(f"Simulator Random Seed: {server.seed}")
    server.say(
        f"Listening on {options.bind}: players and monitors {server.port}, trainer {server.coach_port}, "
        f"online coaches {server.olcoach_port}"
    )
    server.say("\nHit CTRL-C to exit")
    return server.run()


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
