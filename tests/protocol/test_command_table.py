"""Every row of the table of commands goes out and comes back, whichever rows there are."""

from __future__ import annotations

import contextlib
import itertools
import re
from typing import Any

import pytest

from rcss_hat.protocol import commands
from rcss_hat.protocol.commands.table import JOINING, MONITOR, PLAYER, TRAINER, Command, Form, Table
from rcss_hat.protocol.commands.values import Kind
from rcss_hat.protocol.errors import LocalProtocolError

VALUES: list[Any] = [
    *(0, 1, -1, 11, 19, 90, -180, 0.5, -0.0625, 3e9, True, False, (3.0, -4.5), (0.0, 0.125)),
    *("our", "l", "keepers", "x_1-b", "abc.+", "wide", "low", "partial", "play_on", "yellow"),
]


def legal(kind: Kind) -> list[Any]:
    """Return the values of a kind among some of all types, but for teams whose names are words of players' commands."""
    if kind.legal == "True or False":
        return [True, False]
    found = []
    for value in VALUES:
        with contextlib.suppress(TypeError):
            found += [value] if kind.spell(value) else []
    return [value for value in found if "t" not in kind.tokens or value not in ("wide", "low", "partial")]


def read(table: Table, command: Command) -> object:
    data = commands.datagram(command)
    if table is PLAYER:
        return commands.parse_commands(data)
    if table is TRAINER:
        return commands.parse_trainer_command(data)
    if table is MONITOR:
        return commands.parse_monitor_command(data)
    is_trainer = isinstance(command, commands.TrainerInit)
    return commands.parse_trainer_init(data) if is_trainer else commands.parse_init(data)


ROWS = [
    pytest.param(table, form, id=f"{speaker} {form.text}")
    for speaker, table in {"player": PLAYER, "trainer": TRAINER, "monitor": MONITOR, "joining": JOINING}.items()
    for forms in table.forms.values()
    for form in forms
]


@pytest.mark.parametrize(("table", "form"), ROWS)
def test_a_row_goes_out_and_comes_back(table: Table, form: Form) -> None:
    choices = [[v for v in legal(kind) if v != kind.absent or kind.absent is None] for kind in form.kinds.values()]
    assert all(choices), "no value of a kind is known here"
    pattern = re.compile(".+".join(map(re.escape, re.split(r"\{\w+\}", form.text))))
    for values in itertools.islice(itertools.product(*choices), 200):
        command = form.record(**dict(zip(form.kinds, values, strict=True)))
        assert pattern.fullmatch(command.text())
        assert read(table, command) == (([command], True) if table is PLAYER else command)


@pytest.mark.parametrize(("table", "form"), [row for row in ROWS if row.values[1].kinds])
def test_what_a_row_cannot_say_is_refused_and_named(table: Table, form: Form) -> None:
    fitting = {name: legal(kind)[0] for name, kind in form.kinds.items()}
    for name, kind in form.kinds.items():
        wrong = (float("inf"),) * 2 if kind.parts else "" if isinstance(fitting[name], str) else float("nan")
        if kind.spell(wrong):  # switches and marks take any truth value
            continue
        with pytest.raises(LocalProtocolError, match=f"^{form.name}: "):
            form.record(**fitting | {name: wrong}).text()


def test_help_says_how_a_command_is_sent() -> None:
    assert "Sent as ``(kick POWER DIRECTION)``" in (commands.Kick.__doc__ or "")
    assert "POWER: a number from -100 to 100." in (commands.Kick.__doc__ or "")
