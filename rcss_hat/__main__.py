"""``python -m rcss_hat``: the command line."""

from rcss_hat.cli.main import main

main()
