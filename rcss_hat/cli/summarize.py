"""``rcss-hat summarize``: from demonstrations to a decision list."""

from __future__ import annotations

import json
from pathlib import Path

import click

from rcss_hat.cli.common import Target, deliver, plain_errors
from rcss_hat.cli.sets import load_demonstrations


@click.command()
@click.argument("demonstrations", nargs=-1, required=True, metavar="DEMONSTRATIONS...")
@click.option("--out", type=Target(), help="Write the decision list (.json or .txt).")
@click.option("--seed", type=click.IntRange(0), default=0, show_default=True, help="Of the rule learner.")
@click.option("--arff", type=Target(), help="Export the decisions for Weka.")
@click.option("--describe", is_flag=True, help="Describe the demonstrations as well.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def summarize(
    demonstrations: tuple[str, ...], out: Path | None, seed: int, arff: Path | None, describe: bool, as_json: bool
) -> None:
    """Learn a decision list (RIPPER) from one or more demonstrations.

    DEMONSTRATIONS are files, or sets of the package: A, B, C, B-fast, B-limited.

    \b
    Example:
      rcss-hat summarize demo.csv --out rules.json
      rcss-hat summarize a.csv b.csv --out both.json --describe
    """
    from rcss_hat.hat.demonstrations import combine
    from rcss_hat.hat.summarize import summarize as learn

    with plain_errors(ValueError):
        sets = [load_demonstrations(source) for source in demonstrations]
        pooled = sets[0] if len(sets) == 1 else combine(sets)
        summary = learn(pooled, seed)
    described = pooled.describe().to_text() + "\n\n" if describe else ""
    text = json.dumps(summary.to_dict()) if as_json else described + summary.to_text()
    deliver(text, (out, summary.decision_list.save), (arff, pooled.to_arff))
