"""``python -m fake_server``: the fake-rcssserver command."""

from fake_server.cli import main

main()
