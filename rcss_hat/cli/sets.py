"""``rcss-hat sets``: choose from demonstrations, join and split them, and describe what they hold."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rcss_hat.cli.common import fail, plain_errors

if TYPE_CHECKING:
    from rcss_hat.hat.demonstrations import DemonstrationSet, Description

FILE = click.Path(dir_okay=False, path_type=Path)


def load_demonstrations(source: str) -> DemonstrationSet:
    """Load a file, or a set that ships with the package.

    Raises
    ------
    ValueError
        When there is neither.
    """
    from rcss_hat.experiments.sets import package_demonstrations
    from rcss_hat.hat.demonstrations import DemonstrationSet

    if Path(source).suffix in (".csv", ".json") or Path(source).is_file():
        return DemonstrationSet.load(source)
    return package_demonstrations(source)


@click.command()
@click.argument("demonstrations", nargs=-1, required=True, metavar="DEMONSTRATIONS...")
@click.option(
    "--pick", type=click.Choice(["first", "best", "worst", "random"]), help="Which episodes of each; best: the longest."
)
@click.option("--episodes", type=click.IntRange(1), help="How many of each, with --pick.")
@click.option("--seed", type=click.IntRange(0), default=0, show_default=True, help="With --pick random.")
@click.option("--out", type=FILE, help="Write the chosen episodes of all, x.csv (and x.json).")
@click.option("--rest", type=FILE, help="Write the episodes that were not picked.")
@click.option("--arff", type=FILE, help="Export the chosen decisions for Weka.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def sets(
    demonstrations: tuple[str, ...],
    pick: str | None,
    episodes: int | None,
    seed: int,
    out: Path | None,
    rest: Path | None,
    arff: Path | None,
    as_json: bool,
) -> None:
    """Choose episodes of demonstrations, join them, split them, and describe them.

    DEMONSTRATIONS are files, or sets of the package: A, B, C, B-fast, B-limited.

    \b
    Example:
      rcss-hat sets A                                              # describe
      rcss-hat sets A C --pick best --episodes 10 --out best.csv   # the ten longest of each
      rcss-hat sets mine.csv --pick random --episodes 15 --seed 1 --out train.csv --rest test.csv
    """
    from rcss_hat.hat.demonstrations import combine

    if (pick is None) != (episodes is None):
        raise click.UsageError("--pick and --episodes go together: which episodes, and how many")
    if rest is not None and pick is None:
        raise click.UsageError("--rest needs --pick and --episodes: without them nothing is left over")
    for path in (out, rest):
        if path is not None and path.exists():
            fail(f"{path} exists already; give another name")
    with plain_errors(ValueError):
        loaded = [load_demonstrations(source) for source in demonstrations]
        parts = [each.split(episodes or len(each), pick or "first", seed) for each in loaded]
        chosen, left = (combine(side) for side in zip(*parts, strict=True))
        for path, demonstration in ((out, chosen), (rest, left)):
            if path is not None:
                path.parent.mkdir(parents=True, exist_ok=True)
                demonstration.save(path)
        if arff is not None:
            chosen.to_arff(arff)
    description = chosen.describe()
    click.echo(json.dumps(_figures(description)) if as_json else description.to_text())


def _figures(description: Description) -> dict[str, Any]:
    info, seconds = description.info, description.durations
    return {
        "teacher": info.teacher,
        "size": info.task.size,
        "episodes": len(seconds),
        "mean_s": float(seconds.mean()),
        "shortest_s": float(seconds.min()),
        "longest_s": float(seconds.max()),
        "decisions": int(description.action_counts.sum()),
        "action_shares": [round(float(share), 4) for share in description.action_shares],
        "coverage": {n: float(c) for n, c in zip(info.variable_names, description.coverage, strict=True)},
    }
