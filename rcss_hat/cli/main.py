"""The ``rcss-hat`` command: a group whose subcommands are imported only when they are run."""

from __future__ import annotations

import importlib
import importlib.util
import signal
from types import FrameType

import click

from rcss_hat import __version__

COMMANDS = {
    "play": ("rcss_hat.cli.play", "Play Keepaway with both teams and report the episodes."),
    "keepers": ("rcss_hat.cli.teams", "Launch the keepers against a running server."),
    "takers": ("rcss_hat.cli.teams", "Launch the takers against a running server."),
    "referee": ("rcss_hat.cli.referee", "Referee Keepaway as a trainer, on servers without Keepaway mode."),
    "server": ("rcss_hat.cli.server", "Run a real or fake rcssserver with Keepaway options."),
    "record": ("rcss_hat.cli.record", "Record everything said between clients and a server."),
    "demonstrate": ("rcss_hat.cli.demonstrate", "Record demonstrations of a teacher."),
    "sets": ("rcss_hat.cli.sets", "Choose, join, split and describe demonstrations."),
    "summarize": ("rcss_hat.cli.summarize", "Learn a decision list from demonstrations."),
    "train": ("rcss_hat.cli.train", "Learn by Sarsa, alone or with a transfer method."),
    "evaluate": ("rcss_hat.cli.train", "Play learned weights without learning."),
    "experiment": ("rcss_hat.cli.experiment", "Run the trials of an experiment, in parallel and resumable."),
    "report": ("rcss_hat.cli.experiment", "Tables, statistics and figures of an experiment."),
    "study": ("rcss_hat.cli.study", "Studies with people: serve, rehearse, report."),
    "compile": ("rcss_hat.cli.compile", "Compile all kernels ahead of time."),
    "watch": ("rcss_hat.cli.watch", "Watch a server, a match or a log in the browser."),
}
"""Name to (module, one line of help); the module has a click command of that name."""


EXTRAS = {
    "aiohttp": ("the page", "web"),
    "gymnasium": ("an environment", "envs"),
    "jinja2": ("a report, or a study's page,", "report,web"),
    "markdown_it": ("a study's page", "web"),
    "matplotlib": ("a report", "report"),
    "pettingzoo": ("an environment", "envs"),
}
"""Package that only some installations have: what needs it, and the extra that brings it."""


class LazyGroup(click.Group):
    """Lists its commands without importing them, so that ``--help`` needs no compiler."""

    def invoke(self, ctx: click.Context) -> object:
        """Run a command; what is not installed for it is said with what would install it."""
        try:
            return super().invoke(ctx)
        except ModuleNotFoundError as problem:
            package = (problem.name or "").split(".")[0]
            if package not in EXTRAS:
                raise
            what, extra = EXTRAS[package]
            message = f"{what} needs {package}, which is not installed: pip install 'rcss-hat[{extra}]'"
            raise click.ClickException(message) from problem

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names in the order people use them."""
        return [name for name in COMMANDS if importlib.util.find_spec(COMMANDS[name][0])]

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import and return one command."""
        if cmd_name not in COMMANDS:
            return None
        module = importlib.import_module(COMMANDS[cmd_name][0])
        command: click.Command = getattr(module, cmd_name)
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the command that was named; what it may have been is suggested."""
        if args and args[0] not in COMMANDS and not args[0].startswith("-"):
            from rcss_hat.schema import did_you_mean

            ctx.fail(f"no such command {args[0]!r}{did_you_mean(args[0], COMMANDS)}")
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the list of commands without importing them."""
        with formatter.section("Commands"):
            formatter.write_dl([(name, COMMANDS[name][1]) for name in self.list_commands(ctx)])


@click.group(cls=LazyGroup, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="rcss-hat")
def cli() -> None:
    """RoboCup Keepaway and Human-Agent Transfer.

    \b
    Example:
      rcss-hat play --on fake --keepers hand --episodes 20 --seed 1
      rcss-hat demonstrate --teacher hand --episodes 20 --out demo.csv
      rcss-hat summarize demo.csv --out rules.json
      rcss-hat play --on fake --keepers rules.json --episodes 20
    """


def _interrupt(number: int, frame: FrameType | None) -> None:
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # shells ignore Ctrl-C for background jobs
        raise KeyboardInterrupt
    signal.raise_signal(signal.SIGINT)


def main() -> None:
    """Entry point of the console script; being terminated is the same as Ctrl-C, so that nothing is left half done."""
    from rcss_hat.cli.common import fail, silence_stdout

    signal.signal(signal.SIGTERM, _interrupt)
    try:
        cli(prog_name="rcss-hat")
    except OSError as problem:  # nothing that can be printed, or read, or written ends in a traceback
        silence_stdout()
        fail(str(problem))
