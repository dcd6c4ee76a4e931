"""The command lines of the containers, given to the stand-in and to our own command line."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest
import yaml

from fake_server.options import parse_options
from rcss_hat.cli.main import cli
from rcss_hat.keepaway.task import Task

DOCKER = Path(__file__).parents[2] / "docker"


def server_command() -> list[str]:
    text = (DOCKER / "server.Dockerfile").read_text().replace("\\\n", " ")
    found = re.search(r"^CMD (\[\"server.*\])$", text, re.MULTILINE)
    assert found is not None
    command: list[str] = json.loads(found[1])
    return command


def test_the_stand_in_takes_the_servers_command_line() -> None:
    options = parse_options(server_command())
    for name, value in Task().server_values().items():
        assert options.params[name] == value, name
    assert options.params["keepaway_log_dir"] == "/logs"


def test_the_server_does_not_run_as_root() -> None:
    for name in ("server.Dockerfile", "players.Dockerfile"):
        lines = (DOCKER / name).read_text().splitlines()
        assert "USER 1000" in lines
        entry = next(k for k, line in enumerate(lines) if line.startswith("ENTRYPOINT"))
        assert lines.index("USER 1000") < entry


@pytest.mark.parametrize("service", ["keepers", "takers"])
def test_compose_starts_the_players_with_commands_that_exist(service: str) -> None:
    text = (DOCKER / "compose.yaml").read_text()
    found = re.search(rf"command: (\[\"{service}\".*\])", text)
    assert found is not None
    arguments = json.loads(found[1])
    command = cli.get_command(None, arguments[0])  # type: ignore[arg-type]
    assert command is not None
    context = command.make_context(arguments[0], arguments[1:], resilient_parsing=False)
    assert context.params["address"] == ("server", 6000)


def services(name: str) -> dict[str, Any]:
    content: dict[str, Any] = yaml.safe_load((DOCKER / name).read_text())
    assert set(content) == {"services", "volumes"}, "older programs refuse name:, newer ones version:"
    found: dict[str, Any] = content["services"]
    return found


def test_compose_waits_for_a_server_that_answers() -> None:
    found = services("compose.yaml")
    assert found["keepers"]["depends_on"] == {"server": {"condition": "service_healthy"}}
    assert found["takers"]["depends_on"] == {"keepers": {"condition": "service_started"}}
    assert "HEALTHCHECK" in (DOCKER / "server.Dockerfile").read_text()


def test_no_service_has_to_end_before_another_begins() -> None:
    """Not every compose program can wait for that."""
    for name in ("compose.yaml", "compose.host.yaml"):
        assert "service_completed_successfully" not in (DOCKER / name).read_text()


def test_the_log_folder_belongs_to_the_servers_user() -> None:
    """A new named volume takes the owner of the image's folder, which a folder of the host does not."""
    assert "chown --recursive rcss:rcss /home/rcss /logs" in (DOCKER / "server.Dockerfile").read_text()
    for name in ("compose.yaml", "compose.host.yaml"):
        assert services(name)["server"]["volumes"] == ["logs:/logs"]


def test_the_players_image_is_built_once() -> None:
    found = services("compose.yaml")
    assert found["keepers"]["image"] == found["takers"]["image"]
    assert "build" in found["keepers"] and "build" not in found["takers"]
    assert found["takers"]["pull_policy"] == "never"


def test_the_match_of_compose_has_an_end() -> None:
    """The keepers end it for everybody; takers count for themselves, and the server exits when it is over."""
    found = services("compose.yaml")
    for team in ("keepers", "takers"):
        command = found[team]["command"]
        assert command[command.index("--episodes") + 1] == "100"
    assert "--end-match" in found["keepers"]["command"]
    assert {
        "server::coach_w_referee=1", "server::auto_mode=1", "server::nr_extra_halfs=0", "server::game_over_wait=1"
    } <= set(server_command())  # fmt: skip


def test_the_kernels_are_compiled_for_whoever_runs_the_image() -> None:
    lines = (DOCKER / "players.Dockerfile").read_text().splitlines()
    assert lines.index(" && rcss-hat compile --for-all") < lines.index("USER 1000")
    assert not any("RCSS_HAT_CACHE" in line for line in lines)


def test_what_the_players_image_copies_is_not_ignored() -> None:
    """All else is: a virtual environment or results would make the build context large."""
    ignored = (DOCKER.parent / ".dockerignore").read_text().splitlines()
    lines = (DOCKER / "players.Dockerfile").read_text().splitlines()
    copied = [name for line in lines if line.startswith("COPY ") for name in line.split()[1:-1]]
    assert ignored[0] == "*" and len(copied) == 6
    for name in copied:
        assert f"!{name}" in ignored and (DOCKER.parent / name).exists()
