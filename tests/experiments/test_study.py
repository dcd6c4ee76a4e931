"""Studies in TOML: the shipped ones, and what is refused."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

import pytest

from rcss_hat.experiments.study import StudyError
from rcss_hat.experiments.study_file import load_study, parse_study, study_names
from rcss_hat.hat.transfer import PPR, ExtraAction, NoPrior, ValueBonus
from rcss_hat.learning.config import load_config

SMALL = """
title = "Small"
seed = 3
baseline = "none"

[defaults]
hours = 2
trials = 4

[demonstrations.A]
teacher = "A"
episodes = 3

[[condition]]
name = "none"

[[condition]]
name = "ppr"
method = "ppr"
settings = { decay = 0.99 }
learner = "cmac"
learner_settings = { epsilon = 0.02 }
demonstrations = "A"
size = "4v3"
trials = 2
"""


def small(text: str = "", replace: tuple[str, str] = ("", "")) -> str:
    return SMALL.replace(*replace) + text


def test_the_paper_s_study_has_all_its_conditions() -> None:
    study = load_study("paper")
    assert len(study.conditions) == 11 and study.baseline == "no-prior"
    assert all((c.trials, c.hours, c.evaluation_episodes) == (10, 30.0, 1000) for c in study.conditions.values())
    methods = [study.conditions[name].method for name in study.tables[0].conditions]
    assert methods == [NoPrior(), ValueBonus(10.0, 100), ExtraAction(100), PPR(0.999)]
    assert [len(t.conditions) for t in study.tables] == [4, 4, 5, 3]
    assert [f.name for f in study.figures] == ["figure-3", "figure-4", "figure-5", "figure-6"]
    assert study.conditions["AC-best-ppr"].published.total == 431
    assert study.sets["AC-best"].of == ("A", "C") and study.sets["AC-best"].episodes == 10
    assert len(study.claims) == 9


def test_every_shipped_study_is_valid() -> None:
    assert study_names() == ["methods", "paper", "real", "rounds", "sets", "size-4v3"]
    for name in study_names():
        assert load_study(name).title


def test_conditions_inherit_the_defaults_and_change_them() -> None:
    study = parse_study(SMALL, Path())
    none, ppr = study.conditions.values()
    assert (none.label, none.hours, none.trials, none.task.size, none.learner.name) == ("none", 2.0, 4, "3v2", "paper")
    assert (ppr.trials, ppr.task.field, ppr.learner.name, ppr.learner.epsilon) == (2, "30x30", "cmac", 0.02)
    assert ppr.method == PPR(decay=0.99)
    assert ppr.run_config(7).seed == 7


def test_seeds_depend_on_study_condition_and_trial_only() -> None:
    study, other = parse_study(SMALL, Path()), parse_study(small(replace=("seed = 3", "seed = 4")), Path())
    seeds = [study.trial_seed(name, k) for name in study.conditions for k in range(10)]
    assert len(set(seeds)) == 20 and min(seeds) >= 0
    assert study.trial_seed("ppr", 1) == study.chosen(("ppr",)).trial_seed("ppr", 1) != other.trial_seed("ppr", 1)


def test_scaling_keeps_the_share_of_rounds_and_the_trials_of_samples() -> None:
    study = load_study("rounds").scaled(trials=2, hours=3)
    assert [r.hour for r in study.conditions["more-4"].rounds] == pytest.approx([0.3, 0.6, 0.9])
    assert {c.trials for c in study.conditions.values()} == {2}
    sampled = load_study("sets").scaled(trials=3)
    assert sampled.conditions["no-prior"].trials == 3 and sampled.conditions["set-150"].trials == 1
    pools = [spec.of[0] for name, spec in sampled.sets.items() if name.startswith("set-")]
    assert {pool: pools.count(pool) for pool in pools} == dict.fromkeys(["A", "B", "C", "B-limited", "B-fast"], 30)


def test_another_learner_for_all_conditions() -> None:
    study = parse_study(SMALL, Path()).learned_by("best")
    assert {c.learner for c in study.conditions.values()} == {load_config("best")}
    with pytest.raises(StudyError, match="learner: no learner preset 'worst'; there are best, cmac, paper, printed"):
        study.learned_by("worst")


def test_some_conditions_can_be_chosen() -> None:
    study = load_study("paper").chosen(("no-prior", "A-ppr"))
    assert list(study.conditions) == ["no-prior", "A-ppr"]
    assert [claim.text.partition(":")[0] for claim in study.claims] == ["Sarsa alone learns"], "of No Prior alone"
    assert study.tables[0].conditions == ("no-prior", "A-ppr")
    assert load_study("paper").chosen(("A-ppr",)).baseline is None
    with pytest.raises(StudyError, match="--only: there is no condition 'x'"):
        study.chosen(("x",))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("title = ", "not valid TOML"),
        ("titel = 'x'", "the study has no entry 'titel'"),
        ("title = 'x'", r"no \[\[condition\]\]"),
        (small("[[condition]]\nname = 'none'"), "two conditions 'none'"),
        (small("[[condition]]\nname = 'a/b'"), "letters, digits"),
        (small("[[condition]]\nname = 'x'\nmethod = 'magic'"), "no transfer method 'magic'"),
        (small("[[condition]]\nname = 'x'\nmethod = 'ppr'"), "method ppr needs demonstrations"),
        (small("[[condition]]\nname = 'x'\ndemonstrations = 'A'"), "uses no demonstrations"),
        (small("[[condition]]\nname = 'x'\nsize = '3v'"), "condition 'x': size is written"),
        (small("[[condition]]\nname = 'x'\nlearner = 'wise'"), "no learner preset 'wise'"),
        (small("[[condition]]\nname = 'x'\nlearner_settings = {epsilon = 2}"), "epsilon must be"),
        (small("[[condition]]\nname = 'x'\nhours = 'long'"), "hours has a value of the wrong kind"),
        (small("[[condition]]\nname = 'x'\ntrials = 0"), "trials must be at least 1"),
        (small("[[condition]]\nname = 'x'\nextra = 1"), "condition 'x' has no entry 'extra'"),
        (small(replace=('demonstrations = "A"', 'demonstrations = "Z"')), "no demonstration set 'Z'"),
        (small(replace=('baseline = "none"', 'baseline = "nil"')), "baseline: there is no condition 'nil'"),
        (small(replace=('teacher = "A"', "")), "exactly one of"),
        (small(replace=("episodes = 3", "")), "a teacher needs a number"),
        (small("[demonstrations.B]\nof = ['B']"), "made of itself"),
        (small("[demonstrations.B]\nof = ['A']\npick = 'best'"), "needs 'of' and 'episodes'"),
        (small("[demonstrations.B]\nof = ['A']\npick = 'nicest'"), "pick must be one of"),
        (small("[demonstrations.B]\nof = ['A']\nepisodes = 0"), "at least 1"),
        (small("[[table]]\nname = 't'\ntitle = 't'\nconditions = ['zzz']"), "'t': there is no condition 'zzz'"),
        (small("[[figure]]\nname='f'\ntitle='f'\nconditions=['ppr']\nteachers=['Z']"), "figure 'f'"),
        (small("[[claim]]\ntext = 'x'"), "claim 1 needs a text and tests"),
        (
            small("[[claim]]\ntext='x'\ntests=[{test='better', metric='total', conditions=['ppr'], than=['none']}]"),
            "test must be one of",
        ),
        (
            small("[[claim]]\ntext='x'\ntests=[{test='higher', metric='total', conditions=['ppr']}]"),
            "needs either than or teachers",
        ),
        (
            small("[[claim]]\ntext='x'\ntests=[{test='higher', metric='total', conditions=['ppr'], teachers=['Z']}]"),
            "claim 'x': there is no demonstration set 'Z'",
        ),
        (
            small(
                "[[claim]]\ntext='x'\ntests=[{test='lower', metric='hours', conditions=['ppr'], than=['none'],"
                " than_metric='age'}]"
            ),
            "than_metric must be one of",
        ),
        (small("[sampling]\npools = []\nepisodes = [1]\nsets = 1"), "sampling needs pools"),
        (
            small("[[condition]]\nname='x'\nmethod='ppr'\ndemonstrations='A'\nrounds=[{hour=3, demonstrations='A'}]"),
            "before the end of the 2 hours",
        ),
        (
            small("[[condition]]\nname='x'\nmethod='ppr'\ndemonstrations='A'\nrounds=[{hour=1}]"),
            "either demonstrations or watch",
        ),
        ("titel = 'x'", "did you mean 'title'"),
        ("seed = -5", "seed must be a whole number from 0 to"),
        ("seed = " + "9" * 6000, "not valid TOML: an integer of more than 64 bits"),
        ("x = " + "[" * 3000 + "]" * 3000, "not valid TOML: nested more than"),
        (small("[[condition]]\nname = 'x'\nhours = nan"), "condition 'x': hours must be .* 0 to 10,000, not nan"),
        (small("[[condition]]\nname = 'x'\nhours = inf"), "condition 'x': hours must be .* 0 to 10,000, not inf"),
        (
            small("[[condition]]\nname = 'x'\nhours = 1e9"),
            "condition 'x': hours must be .* 0 to 10,000, not 1000000000",
        ),
        (small("[[condition]]\nname = 'x'\ntrials = 1000000000"), "trials must be at least 1 and at most 10,000, not"),
        (small("[[condition]]\nname = 'x'\ntrials = 9999"), "10,005 trials are more than a study can have: 10,000"),
        (small("[[condition]]\nname = 'x'\nlerner = 'x'"), "condition 'x' has no entry 'lerner'; .*'learner'?"),
        (small(replace=("decay = 0.99", "decay = 2")), "condition 'ppr': settings: decay must be a number from 0 to 1"),
        (small("[demonstrations.'../../evil']\nteacher = 'A'\nepisodes = 1"), "letters, digits.*'../../evil'"),
        (small("[demonstrations.B]\nname = '../x'\nteacher = 'A'\nepisodes = 1"), "no entry 'name'"),
        (small("[demonstrations.'A.rules']\nteacher = 'A'\nepisodes = 1"), "must not end in .rules"),
        (
            small("[[table]]\nname = '../t'\ntitle = 't'\nconditions = ['ppr']"),
            "table 1: name must be a name of letters",
        ),
        (small("[[figure]]\nname = '../t'\ntitle = 't'\nconditions = ['ppr']"), "figure 1: name must be a name of"),
        (small("[[table]]\nname='t'\ntitle='t'\nconditions=[]\n" * 2), "there are two tables 't'"),
        (small("[demonstrations.B]\nof = ['C']\n[demonstrations.C]\nof = ['B']"), "'B' is made of itself"),
        (small("[demonstrations.B]\nteacher = 'A'\nepisodes = 100000"), "at most 10,000"),
        (small("[sampling]\npools = ['A']\nepisodes = [1]\nsets = 1000000000"), "sampling: sets must be .* 1,000"),
        (
            small("[[condition]]\nname='x'\nmethod='ppr'\ndemonstrations='A'\nrounds=[{hour=1,watch='Z',episodes=1}]"),
            "condition 'x': rounds: there is no scripted teacher 'Z'",
        ),
        (
            small(
                "[demonstrations.R]\nrules = 'paper'\n[[condition]]\nname='x'\nmethod='ppr'\ndemonstrations='R'\n"
                "rounds=[{hour=1, watch='A', episodes=1}]"
            ),
            "condition 'x' needs demonstrations, and set 'R' is a decision list",
        ),
    ],
)
def test_errors_name_the_place(text: str, message: str) -> None:
    with pytest.raises(StudyError, match=message):
        parse_study(text, Path())


def test_other_numbers_have_the_same_limits() -> None:
    study = parse_study(SMALL, Path())
    for trials, hours, message in (
        (1_000_000_000, None, "2,000,000,000 trials are more than a study can have: 10,000"),
        (None, float("nan"), "hours must be 0 to 10,000, not nan"),
        (None, 1e9, "condition 'none': hours must be 0 to 10,000, not 1e\\+09"),
    ):
        with pytest.raises(StudyError, match=message):
            study.scaled(trials, hours)


@pytest.mark.parametrize(
    ("names", "n", "digest"),
    [
        (("methods", "paper", "rounds", "sets", "size-4v3"), 530, "1af24fe4c4631c0b"),
        (("real",), 60, "c5e69afd9b72e017"),
    ],
)
def test_settings_and_seeds_of_trials_stay_those_of_finished_ones(names: tuple[str, ...], n: int, digest: str) -> None:
    """A trial whose settings changed is refused: this digest holds what `config.json` of existing ones says."""
    settings = [
        condition.run_config(study.trial_seed(name, trial)).to_dict()
        for study in map(load_study, names)
        for name, condition in study.scaled().conditions.items()
        for trial in range(condition.trials)
    ]
    text = json.dumps(settings, sort_keys=True)
    assert (len(settings), hashlib.sha256(text.encode()).hexdigest()[:16]) == (n, digest)


def test_a_study_that_is_not_there_is_named() -> None:
    with pytest.raises(StudyError, match="no study 'nothing': there are methods, paper"):
        load_study("nothing")


SERVED = """
[defaults]
stage = "fake"

[[condition]]
name = "a"

[[condition]]
name = "b"
stage = "arena"
baseline = "b"
"""


def test_a_study_says_what_is_played_where() -> None:
    study = parse_study('baseline = "a"\n' + SERVED, Path())
    assert [c.stage for c in study.conditions.values()] == ["fake", "arena"]
    assert (study.baseline_of("a"), study.baseline_of("b")) == ("a", "b")
    assert study.conditions["a"].run_config(1).stage == "fake"
    assert {c.stage for c in load_study("paper").played_on("real").conditions.values()} == {"real"}
    assert study.chosen(("a",)).conditions["a"].baseline is None


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('baseline = "a"\n' + SERVED.replace('baseline = "b"', ""), "condition 'b': baseline: 'a' is played on fake"),
        (SERVED.replace('"fake"', '"hear"'), r"'hear' is none of arena, fake, real, and not HOST:PORT"),
        (SERVED + '[[table]]\nname = "t"\ntitle = "T"\nconditions = ["a", "b"]\n', "have different baselines"),
        (SERVED + '[[comparison]]\nname = "c"\ntitle = "C"\npairs = [["a", "x"]]\nmargins = {}\n', "no condition 'x'"),
        (
            SERVED + '[[comparison]]\nname = "c"\ntitle = "C"\npairs = [["a", "b"]]\nmargins = { final = 0 }\n',
            "margins must be more than 0",
        ),
        ("missed_at_most = 2\n" + SERVED, "missed_at_most must be a share from 0 to 1"),
    ],
)
def test_stages_that_cannot_be_are_named(text: str, message: str) -> None:
    with pytest.raises(StudyError, match=message):
        parse_study(text, Path())
