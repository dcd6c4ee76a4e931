"""``rcss-hat sets``: choose from demonstrations, join and split them, and describe what they hold."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from rcss_hat.cli.common import Target, deliver, fail, packed, plain_errors, say

if TYPE_CHECKING:
    from rcss_hat.hat.demonstrations import DemonstrationSet, Description

FILE = Target()
MINARI = "minari:"
"""How a data set of Minari is named among files."""


def load_demonstrations(source: str) -> DemonstrationSet:
    """Load a file, or a set that ships with the package.

    Raises
    ------
    ValueError
        When there is neither.
    """
    from rcss_hat.experiments.sets import package_demonstrations
    from rcss_hat.hat.demonstrations import DemonstrationSet
    from rcss_hat.hat.exchange import from_minari

    if source.startswith(MINARI):
        return from_minari(source.removeprefix(MINARI))
    if Path(source).suffix in (".csv", ".json") or Path(source).is_file():
        return DemonstrationSet.load(source)
    return package_demonstrations(source)


@dataclass(frozen=True)
class Files:
    """What ``sets`` writes."""

    out: Path | None
    rest: Path | None
    arff: Path | None
    minari: str | None


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
@click.option("--minari", metavar="ID", help="Write the chosen episodes as a local data set of Minari.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
@packed(Files)
def sets(
    demonstrations: tuple[str, ...],
    pick: str | None,
    episodes: int | None,
    seed: int,
    options: Files,
    as_json: bool,
) -> None:
    """Choose episodes of demonstrations, join them, split them, and describe them.

    DEMONSTRATIONS are files, sets of the package (A, B, C, B-fast, B-limited), or minari:ID, a data set of Minari.

    \b
    Example:
      rcss-hat sets A                                              # describe
      rcss-hat sets A C --pick best --episodes 10 --out best.csv   # the ten longest of each
      rcss-hat sets mine.csv --pick random --episodes 15 --seed 1 --out train.csv --rest test.csv
      rcss-hat sets A --minari keepaway/A-v0                       # for learners of others
      rcss-hat sets minari:keepaway/A-v0 --out again.csv
    """
    from rcss_hat.hat.demonstrations import combine

    if (pick is None) != (episodes is None):
        raise click.UsageError("--pick and --episodes go together: which episodes, and how many")
    if options.rest is not None and pick is None:
        raise click.UsageError("--rest needs --pick and --episodes: without them nothing is left over")
    for path in (options.out, options.rest):
        if path is not None and path.exists():
            fail(f"{path} exists already; give another name")
    with plain_errors(ValueError):
        loaded = [load_demonstrations(source) for source in demonstrations]
        parts = [each.split(episodes or len(each), pick or "first", seed) for each in loaded]
        chosen, left = (combine(side) for side in zip(*parts, strict=True))
        if options.minari is not None:
            _write_minari(chosen, options.minari)
    description = chosen.describe()
    text = json.dumps(_figures(description)) if as_json else description.to_text()
    deliver(text, (options.out, chosen.save), (options.rest, left.save), (options.arff, chosen.to_arff))


def _write_minari(chosen: DemonstrationSet, dataset: str) -> None:
    from rcss_hat.hat.exchange import to_minari

    left_out = to_minari(chosen, dataset)
    unknown = sum(d.episode.final is None for d in chosen if len(d))
    if left_out:
        say(f"{left_out} episodes without a decision are not in {dataset}")
    if unknown:
        say(f"the ends of {unknown} episodes were not recorded; their last observations stand in for them")


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
