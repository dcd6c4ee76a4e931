"""``rcss-hat record``: a recording relay between clients and a server."""

from __future__ import annotations

import asyncio
import contextlib
from pathlib import Path

import click

from rcss_hat.cli.common import Target, fail, plain_errors
from rcss_hat.cli.places import HostPort


@click.command()
@click.option("--server", type=HostPort(), default="localhost:6000", show_default=True, help="The server to relay to.")
@click.option(
    "--port", type=click.IntRange(0, 65535), default=6100, show_default=True, help="Clients connect here; 0: any."
)
@click.option("--bind", default="127.0.0.1", show_default=True, help="Address to listen on.")
@click.option("--out", type=Target(), required=True, help="Transcript (.jsonl.gz).")
@click.option("--seconds", type=float, default=None, help="Stop after so long.  [default: at Ctrl-C]")
def record(server: tuple[str, int], port: int, bind: str, out: Path, seconds: float | None) -> None:
    """Record everything said between clients and a server.

    Clients connect to the relay's port as they would to the server. The transcript can be served again with
    'fake-rcssserver replay'.

    \b
    Example:
      rcss-hat record --server localhost:6000 --port 6100 --out bug.jsonl.gz
      rcss-hat play --on localhost:6100 --keepers hand --episodes 5
    """
    from rcss_hat.stage.relay import Relay

    async def run() -> tuple[int, OSError | None]:
        async with Relay(server[0], server[1], out, port, bind) as relay:
            click.echo(f"Recording to {out}: connect clients to {bind}:{relay.port}; Ctrl-C stops.", err=True)
            with contextlib.suppress(asyncio.CancelledError):
                await asyncio.sleep(seconds if seconds is not None else 10**9)
        return relay.datagrams, relay.failure  # now that the file is closed

    with plain_errors():
        out.parent.mkdir(parents=True, exist_ok=True)
        datagrams, failure = asyncio.run(run())
        click.echo(f"{datagrams} datagrams in {out}")
    if failure is not None:
        fail(f"{out} was not written any further: {failure.strerror or failure}")
