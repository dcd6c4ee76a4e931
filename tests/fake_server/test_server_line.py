"""Lines of parameters, compared with what rcssserver 19.0.0 makes of the same command lines."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from fake_server.options import HelpRequested, UsageError, parse_options, without_effect
from fake_server.param_text import server_param
from fake_server.player_param import PlayerParams
from fake_server.server_line import MAX_FILE_SIZE
from rcss_hat.protocol.messages.parameters import wire_text
from rcss_hat.protocol.params import ServerParams

LINES: list[dict[str, Any]] = [
    json.loads(line)
    for line in (Path(__file__).parents[1] / "data" / "fake_server" / "command-lines.jsonl").read_text().splitlines()
]


def outcome(line: list[str]) -> dict[str, Any]:
    try:
        options = parse_options(line)
    except HelpRequested:
        return {"help": True}
    except UsageError:
        return {"refuses": True}
    spaces = (("server", options.params, ServerParams()), ("player", options.player_params, PlayerParams()))
    return {
        "starts": {
            f"{space}::{name}": printed(chosen[name])
            for space, chosen, default in spaces
            for name in chosen
            if chosen[name] != default[name]
        }
    }


def printed(value: bool | int | float | str) -> str:
    return wire_text(value) if isinstance(value, str) else f"{value:g}"


@pytest.mark.parametrize("entry", LINES, ids=[" ".join(entry["line"]) for entry in LINES])
def test_a_line_does_what_it_does_with_the_original(entry: dict[str, Any]) -> None:
    original = {key: value for key, value in entry.items() if key not in ("line", "here")}
    assert outcome(entry["line"]) == entry.get("here", original)


def test_most_lines_do() -> None:
    differing = [entry for entry in LINES if "here" in entry]
    assert len(LINES) - len(differing) > 100
    casts_and_limits = ("=1.5", "=2", "=-1", "=0.5", "_r=A", "=20", "=7", "\rb")
    for entry in differing:  # of what the original takes, only this is refused
        line = " ".join(entry["line"])
        glued = line.count("=") > len(entry["line"])
        foreign = not line.startswith(("server::", "player::")) or "a::b" in line
        assert "starts" not in entry or line.endswith(casts_and_limits) or glued or foreign, line


def test_blanks_may_stand_on_either_side() -> None:
    line = "server::auto_mode = 1 server::synch_mode= false -server::half_time =30 --player::pt_max  =  2"
    options = parse_options(line.split(" "))
    assert (options.params["auto_mode"], options.params["half_time"], options.player_params["pt_max"]) == (True, 30, 2)


def test_own_options_stand_between_the_words_of_a_line() -> None:
    options = parse_options(["server::half_time", "=", "30", "--seed", "5", "#", "server::half_time=40"])
    assert (options.params["half_time"], options.seed) == (30, 5)


def test_files_are_included_in_their_place(tmp_path: Path) -> None:
    (tmp_path / "sub").mkdir()
    (tmp_path / "a.conf").write_bytes(
        b"\xef\xbb\xbf# server::port\nserver::port = 7\n"
        b"/* two\nlines */ include = 'sub/b.conf'\nserver::coach_port = 8\n"
    )
    (tmp_path / "sub" / "b.conf").write_text(
        'server::version = "19.0.0"\nserver::half_time = 5\nCSVSaver::save = off\n'
        "include = ../a.conf\nserver::kick_rand=0.5\n"
    )
    options = parse_options(["server::port=1", f"include={tmp_path}/a.conf", "server::coach_port=9"])
    told = [options.params[name] for name in ("port", "half_time", "kick_rand", "coach_port")]
    assert told == [7, 5, 0.5, 9]
    assert without_effect(options) == []


@pytest.mark.parametrize(
    ("content", "complaint"),
    [
        ("server::port = 1\nserver::prt = 2\n", "a.conf:2: unknown parameter server::prt; did you mean server::port?"),
        ("server::port = 1\nport = 2\n", "unknown option 'port'; did you mean server::port?"),
        (None, "a.conf: there is no such configuration file"),
        ("include = .", ": is a folder, not a configuration file"),
        ("#" * (MAX_FILE_SIZE + 1), "a.conf: is longer than 1 MiB, the limit for a configuration file"),
    ],
)
def test_what_is_wrong_in_a_file_is_said_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, content: str | None, complaint: str
) -> None:
    monkeypatch.chdir(tmp_path)
    if content is not None:
        Path("a.conf").write_text(content)
    with pytest.raises(UsageError) as error:
        parse_options(["include=a.conf"])
    assert complaint in str(error.value) and "\n" not in str(error.value)


def test_texts_go_out_as_they_were_typed() -> None:
    told = server_param(parse_options(["server::team_l_start=é€"]).params, 19)
    assert told[told.index("(team_l") :].split(")")[0].encode("latin-1").decode() + ")" == '(team_l_start "é€")'
