"""The command lines of the containers, given to the stand-in and to our own command line."""

from __future__ import annotations

import json
import re
from pathlib import Path

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


def test_compose_waits_for_a_server_that_answers() -> None:
    assert (DOCKER / "compose.yaml").read_text().count("condition: service_healthy") == 2
    assert "HEALTHCHECK" in (DOCKER / "server.Dockerfile").read_text()


@pytest.mark.parametrize("name", ["compose.yaml", "compose.host.yaml"])
def test_the_log_folder_belongs_to_the_servers_user_before_it_starts(name: str) -> None:
    services = yaml.safe_load((DOCKER / name).read_text())["services"]
    logs, server = services["logs"], services["server"]
    assert logs["entrypoint"] == ["chown", "1000", "/logs"] and logs["user"] == "0"
    assert logs["volumes"] == server["volumes"] == ["./logs:/logs"]
    assert server["depends_on"]["logs"]["condition"] == "service_completed_successfully"


def test_what_the_players_image_copies_is_not_ignored() -> None:
    """All else is: a virtual environment or results would make the build context large."""
    ignored = (DOCKER / "players.Dockerfile.dockerignore").read_text().splitlines()
    lines = (DOCKER / "players.Dockerfile").read_text().splitlines()
    copied = [name for line in lines if line.startswith("COPY ") for name in line.split()[1:-1]]
    assert ignored[0] == "*" and len(copied) == 6
    for name in copied:
        assert f"!{name}" in ignored and (DOCKER.parent / name).exists()
