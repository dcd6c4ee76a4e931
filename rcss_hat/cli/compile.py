"""``rcss-hat compile``."""

from __future__ import annotations

import click

from rcss_hat.cli.common import plain_errors, say


@click.command()
@click.option(
    "--for-all",
    is_flag=True,
    help="Into the installed package, for every user and every processor of this kind since about 2015.",
)
def compile(for_all: bool) -> None:
    """Compile all kernels now instead of when they are first needed, and print the folder they are in.

    Without options into the user's own cache, for this processor. Kernels that do not fit the installed version, numba,
    Python or the processor are never used: then they are compiled as if there were none.

    \b
    Example:
      rcss-hat compile
      RUN pip install rcss-hat && rcss-hat compile --for-all     (in a Dockerfile)
    """
    from rcss_hat.compile import CompilationFailed, compile_for_all, compile_here

    with plain_errors(CompilationFailed):
        click.echo(compile_for_all() if for_all else compile_here(say))
