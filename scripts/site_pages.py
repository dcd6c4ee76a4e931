"""What the documentation's pages take from the code, for MkDocs: ``<!-- made: NAME -->`` becomes text made here."""

from __future__ import annotations

import ast
import dataclasses
import inspect
import itertools
import re
import subprocess
import sys
import textwrap
from collections.abc import Callable, Iterable
from typing import Any

_EXAMPLE = re.compile(r"\x08\nExample:\n((?:  .*(?:\n|$))+)")
_MARK = re.compile(r"^<!-- made: ([\w-]+) -->$", re.MULTILINE)


def on_config(config: Any) -> Any:
    """Show the examples in the help of commands as code (called by MkDocs before mkdocs-click reads the commands)."""
    import click

    from rcss_hat.cli.main import cli

    context = click.Context(cli)
    for command in [cli, *(cli.get_command(context, name) for name in cli.list_commands(context))]:
        if command is not None and command.help:
            command.help = _EXAMPLE.sub(_shown, command.help)
    return config


def _shown(example: re.Match[str]) -> str:
    return f"```bash\n{textwrap.dedent(example[1]).rstrip()}\n```\n"


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Put in what is made of the code (called by MkDocs)."""
    return _MARK.sub(lambda mark: MADE[mark[1]](), markdown)


def table(head: Iterable[str], rows: Iterable[Iterable[object]]) -> str:
    lines = [list(head)]
    lines += [["---"] * len(lines[0]), *([str(cell).replace("|", r"\|") for cell in row] for row in rows)]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def plain(text: str | None) -> str:
    """A docstring's first paragraph in one line of Markdown."""
    return code(inspect.cleandoc(text or "").split("\n\n")[0])


def code(text: str) -> str:
    return " ".join(text.split()).replace("``", "`")


def fake_server() -> str:
    done = subprocess.run([sys.executable, "-m", "fake_server", "--help"], capture_output=True, text=True, check=True)
    return f"```text\n{done.stdout.rstrip()}\n```"


def commands(name: str) -> Callable[[], str]:
    """What a kind of client may send, from the table of commands."""

    def make() -> str:
        from rcss_hat.protocol.commands import joining, monitor, player, trainer  # noqa: F401
        from rcss_hat.protocol.commands import table as tables

        forms = [form for forms in getattr(tables, name).forms.values() for form in forms]
        rows = []
        for record in dict.fromkeys(form.record for form in forms):
            what, _, sent = inspect.cleandoc(record.__doc__ or "").partition("\n\nSent as ")
            spelled, _, fields = sent.partition("\n")
            rows.append(
                (code(spelled.rstrip(".")), code(what), "<br>".join(fields.splitlines()), f"`{record.__name__}`")
            )
        return table(["sent as", "what it does", "fields", "record"], rows)

    return make


def messages() -> str:
    from rcss_hat.protocol import messages as said

    rows = []
    for name in sorted(said.__all__):
        thing = getattr(said, name)
        if inspect.isclass(thing) and thing.__doc__ and issubclass(thing, said.Event) and thing is not said.Event:
            fields = ", ".join(f"`{f.name}`" for f in dataclasses.fields(thing))
            rows.append((f"`{name}`", plain(thing.__doc__), fields))
    return table(["record", "what is told", "fields"], rows)


def server_parameters() -> str:
    from fake_server.effects import NO_EFFECT
    from rcss_hat.protocol.params import PROFILES, SERVER_PARAMETERS, ServerParams

    new, old = (ServerParams(profile) for profile in PROFILES)

    def shown(value: object) -> str:
        return "`''`" if value == "" else f"`{int(value) if isinstance(value, bool) else value}`"

    rows = [
        (f"`server::{p.name}`", shown(new[p.name]), shown(old[p.name]) if old[p.name] != new[p.name] else "",
         "told, without effect" if p.name in NO_EFFECT["server"] else "")
        for p in SERVER_PARAMETERS
    ]  # fmt: skip
    return table(["parameter", "19.0", "11.1, where it differs", "here"], rows)


def learner_settings() -> str:
    from rcss_hat.learning import config

    said = _said(config.LearnerConfig)
    presets = {name: config.load_config(name).to_dict() for name in config.preset_names()}
    usual = config.LearnerConfig().to_dict()
    rows = []
    for name, value in usual.items():
        if name in ("name", "description"):
            continue
        others = ", ".join(f"{p}: {chosen[name]}" for p, chosen in presets.items() if chosen[name] != value)
        rows.append((f"`learner.{name}`", value, others, said.get(name, said.get(f"{name}_", ""))))
    return table(["setting", "default", "presets that differ", "meaning"], rows)


def methods() -> str:
    from rcss_hat.hat.registry import METHODS

    rows = []
    for name in METHODS.ours:
        method = METHODS[name]
        said = _said(method)
        settings = [
            f"`method.{f.name}={f.default}`: {said.get(f.name, '')}".rstrip(": ") for f in dataclasses.fields(method)
        ]
        needs = "rules" if method.needs_advice else "demonstrations" if method.needs_decisions else ""
        rows.append((f"`{name}`", plain(method.__doc__), needs, "<br>".join(settings)))
    return table(["method", "what it does", "needs", "settings"], rows)


def _said(kind: type) -> dict[str, str]:
    """What is written below the fields of a class and of those it derives from."""
    found: dict[str, str] = {}
    for cls in reversed(kind.__mro__[:-1]):
        try:
            body = ast.parse(inspect.cleandoc("\n" + inspect.getsource(cls))).body[0].body  # type: ignore[attr-defined]
        except (OSError, TypeError, SyntaxError):
            continue
        for field, text in itertools.pairwise(body):
            if isinstance(field, ast.AnnAssign) and isinstance(text, ast.Expr) and isinstance(text.value, ast.Constant):
                found[field.target.id] = plain(str(text.value.value))  # type: ignore[union-attr]
    return found


def state_variables() -> str:
    from rcss_hat.keepaway.state import state_names

    rows = [(f"`state_{k}`", f"`{name}`", _meaning(name)) for k, name in enumerate(state_names(3, 2))]
    return table(["variable", "name", "meaning"], rows)


def _meaning(name: str) -> str:
    kind, _, rest = name.rstrip(")").partition("(")
    a, b, *_ = rest.split(",")
    whom = {"C": "the centre", "K1": "the keeper with the ball"}
    if kind == "min_ang":
        return f"smallest angle at K1 between {a} and a taker, degrees"
    if kind == "min_dist":
        return f"distance of {a} to the taker nearest to him, m"
    return f"distance of {whom.get(a, a)} to {whom.get(b, b)}, m"


MADE: dict[str, Callable[[], str]] = {
    "fake-rcssserver": fake_server,
    "player-commands": commands("PLAYER"),
    "trainer-commands": commands("TRAINER"),
    "monitor-commands": commands("MONITOR"),
    "joining-commands": commands("JOINING"),
    "messages": messages,
    "server-parameters": server_parameters,
    "learner-settings": learner_settings,
    "methods": methods,
    "state-variables": state_variables,
}
