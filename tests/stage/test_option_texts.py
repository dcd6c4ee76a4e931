"""Command lines of servers: texts arrive as they are, with whatever characters a folder may have."""

from __future__ import annotations

import pytest

from fake_server.options import parse_options
from rcss_hat.keepaway.task import Task
from rcss_hat.stage.options import server_options


@pytest.mark.parametrize("text", ["/var/logs", "/a b/c", "/it's", "2026-a", "on-time", "//x", "a:b", "a=b", "", "\tx"])
def test_texts_arrive(text: str) -> None:
    line = server_options(Task(), real=False, keepaway_log_dir=text, half_time=7)
    params = parse_options(line).params
    assert (params["keepaway_log_dir"], params["half_time"]) == (text, 7)


def test_an_argument_has_blanks_only_between_quotes() -> None:
    line = server_options(Task(), real=True, keepaway_log_dir="/a b")
    assert [word for word in line if " " in word] == ["'/a b'"]
    assert line[line.index("'/a b'") - 1] == "server::keepaway_log_dir="
