"""Choosing, joining, splitting and describing demonstrations from the command line."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from rcss_hat.cli.main import cli
from rcss_hat.cli.sets import sets
from rcss_hat.hat.demonstrations import PICKS, DemonstrationSet


def invoke(*arguments: str) -> Result:
    return CliRunner().invoke(cli, ["sets", *arguments])


def test_a_set_of_the_package_is_described() -> None:
    result = invoke("A")
    assert result.exit_code == 0, result.output
    assert "20 episodes, mean 10.76 s" in result.output
    assert "state_12 min_ang(K3,K1,T)" in result.output
    figures = json.loads(invoke("A", "--json").stdout)
    assert (figures["episodes"], figures["decisions"]) == (20, 1151)
    assert sum(figures["action_shares"]) == pytest.approx(1.0, abs=1e-3)


def test_the_best_of_two_teachers_and_what_is_left(tmp_path: Path) -> None:
    best, rest, arff = tmp_path / "new" / "best.csv", tmp_path / "rest.csv", tmp_path / "best.arff"
    result = invoke(
        "A", "C", "--pick", "best", "--episodes", "10", "--out", str(best), "--rest", str(rest), "--arff", str(arff)
    )
    assert result.exit_code == 0, result.output
    chosen, left = DemonstrationSet.load(best), DemonstrationSet.load(rest)
    assert (len(chosen), len(left)) == (20, 20)
    for half in (slice(0, 10), slice(10, 20)):
        assert chosen.durations[half].min() >= left.durations[half].max()
    assert arff.read_text().count("\n") > chosen.n_decisions
    again = invoke(str(best), "--pick", "first", "--episodes", "1", "--out", str(best))
    assert again.exit_code == 1 and "best.csv exists already" in again.output


def test_all_ways_to_pick_are_offered() -> None:
    """They are written out for the command, so that its help needs no compiler."""
    pick = next(option for option in sets.params if option.name == "pick")
    assert tuple(pick.type.choices) == PICKS  # type: ignore[attr-defined]


def test_random_picks_are_decided_by_the_seed(tmp_path: Path) -> None:
    picks = []
    for name, seed in (("a", "6"), ("b", "6"), ("c", "7")):
        out = tmp_path / f"{name}.csv"
        assert invoke("A", "--pick", "random", "--episodes", "10", "--seed", seed, "--out", str(out)).exit_code == 0
        picks.append(out.read_text())
    assert picks[0] == picks[1] != picks[2]


@pytest.mark.parametrize(
    ("arguments", "code", "message"),
    [
        (("Z",), 1, "no demonstration set 'Z' ships with the package; there are A, B, B-fast, B-limited, C"),
        (("no.csv",), 1, "no.csv: there is no such demonstration"),
        (("A", "--pick", "best"), 2, "--pick and --episodes go together"),
        (("A", "--rest", "r.csv"), 2, "--rest needs --pick"),
        (("A", "--pick", "best", "--episodes", "21"), 1, "has 20 episodes; cannot take 21 of them"),
    ],
)
def test_what_cannot_be_is_named(arguments: tuple[str, ...], code: int, message: str) -> None:
    result = invoke(*arguments)
    assert result.exit_code == code
    assert message in result.output and "Traceback" not in result.output
