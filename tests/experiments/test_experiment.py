"""Whole experiments: sets, trials, resuming, a Dask cluster, and the report."""

from __future__ import annotations

import json
import shutil
import threading
import xml.etree.ElementTree as ET
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

from rcss_hat.cli.main import cli
from rcss_hat.experiments.execution import ClusterError, Work, run_locally, run_on_cluster
from rcss_hat.experiments.experiment import Experiment, ExperimentError
from rcss_hat.experiments.report_tables import result_table, tables_of
from rcss_hat.experiments.reporting import make_document, write_report
from rcss_hat.experiments.results import Results
from rcss_hat.experiments.run_folder import TrainingError
from rcss_hat.experiments.study import StudyError
from rcss_hat.experiments.training import TrainingRun
from rcss_hat.experiments.trial import run_trial
from rcss_hat.experiments.venue import Supply, read_matches
from rcss_hat.hat.decision_list import PAPER_RULES
from rcss_hat.hat.demonstrations import DemonstrationSet
from rcss_hat.stage.servers import find_executable
from rcss_hat.system.workers import WorkerDied

STUDY = Path(__file__).parent / "small.toml"


def run(folder: Path, study: Path = STUDY, **changes: object) -> Experiment:
    experiment = Experiment.create(str(study), folder, **changes)  # type: ignore[arg-type]
    experiment.prepare_sets()
    assert len(list(experiment.run(lambda work: run_locally(work, 1)))) >= 0
    return experiment


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Experiment:
    experiment = run(tmp_path_factory.mktemp("experiment") / "small")
    assert experiment.finished == experiment.n_trials == 8
    return experiment


def test_every_trial_keeps_weights_log_and_result(finished: Experiment) -> None:
    seeds = set()
    for name in finished.study.conditions:
        for trial in range(2):
            folder = finished.trial_folder(name, trial)
            result = json.loads((folder / "result.json").read_text())
            seeds.add(result["seed"])
            assert (result["condition"], result["trial"], result["hours"]) == (name, trial, 1.0)
            assert result["initial"]["episodes"] == result["greedy"]["episodes"] == 20
            assert result["cycles"] == 36_000 == TrainingRun.open(folder).cycles
    assert len(seeds) == 8
    rounds = TrainingRun.open(finished.trial_folder("rounds", 0))
    assert rounds.round == 2 and 0 < rounds.reuse_from < rounds.episodes
    watched = DemonstrationSet.load(finished.trial_folder("rounds", 0) / "watched-2.csv")
    assert len(watched) == 2 and watched.info.teacher == "A"


def test_sets_are_kept_with_their_rules_and_figures(finished: Experiment) -> None:
    everything, best = finished.sets.prepare("A"), finished.sets.prepare("best")
    assert everything.demonstrations is not None and best.demonstrations is not None
    assert len(everything.demonstrations) == 12 and len(best.demonstrations) == 8
    kept = sorted(everything.demonstrations.durations)[4:]
    assert sorted(best.demonstrations.durations) == pytest.approx(kept)
    assert best.figures["mean_s"] == pytest.approx(np.mean(kept))
    assert 0.0 < best.figures["pass_share"] < 1.0 and best.figures["episodes"] == 8
    assert finished.sets.prepare("printed").rules == PAPER_RULES
    assert (finished.folder / "sets" / "best.rules.txt").read_text().startswith(("if", "else"))


def test_a_finished_experiment_is_not_run_again_and_a_stopped_one_goes_on(finished: Experiment, tmp_path: Path) -> None:
    copy = tmp_path / "copy"
    shutil.copytree(finished.folder, copy)
    again = Experiment.create(str(STUDY), copy)
    assert list(again.missing()) == [] and list(again.run(lambda work: run_locally(work, 1))) == []
    lost = again.trial_folder("rounds", 1)
    before = (lost / "episodes.csv").read_bytes()
    shutil.rmtree(lost)
    [(job, folder)] = again.missing()
    assert (job["condition"], job["trial"], folder) == ("rounds", 1, lost)
    # A trial that was stopped between two rounds goes on there.
    partly = {**job, "rounds": job["rounds"][:1]}
    config = again.study.conditions["rounds"].run_config(job["config"]["seed"])
    started = TrainingRun.create(lost, config, again.sets.prepare("best").rules)
    started.train(until=round(partly["rounds"][0]["hour"] * 36_000))
    [result] = again.run(lambda work: run_locally(work, 1))
    assert result["condition"] == "rounds" and (lost / "episodes.csv").read_bytes() == before


def test_other_settings_need_another_folder(finished: Experiment, tmp_path: Path) -> None:
    for old, new, message in (
        ('learner = "cmac"', 'learner = "paper"', "other settings"),
        ("episodes = 8", "episodes = 7", "another definition of demonstration set 'best'"),
    ):
        changed = tmp_path / "changed.toml"
        changed.write_text(STUDY.read_text().replace(old, new))
        with pytest.raises(ExperimentError, match=message):
            Experiment.create(str(changed), finished.folder)
    [(job, _)] = Experiment.create(str(STUDY), tmp_path / "one", trials=1, only=("no-prior",)).missing()
    with pytest.raises(TrainingError, match="other settings"):
        run_trial({**job, "evaluation_episodes": 3}, finished.trial_folder("no-prior", 0))
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "file").touch()
    with pytest.raises(ExperimentError, match="not empty"):
        Experiment.create(str(STUDY), tmp_path / "full")
    with pytest.raises(ExperimentError, match="not the folder of an experiment"):
        Experiment.open(tmp_path / "full")


def test_damaged_files_of_an_experiment_are_named(finished: Experiment, tmp_path: Path) -> None:
    copy = tmp_path / "copy"
    shutil.copytree(finished.folder, copy)
    damages = ("", "{", "[]", "{}", "[" * 5000, "\xe9".encode("latin-1"))
    for path in (copy / "sets" / "A.figures.json", copy / "trials" / "replay" / "00" / "result.json"):
        before = path.read_bytes()
        for damage in damages:
            path.write_bytes(damage if isinstance(damage, bytes) else damage.encode())
            with pytest.raises(ExperimentError, match=f"{path.name} is damaged: .*; delete it"):
                Experiment.create(str(STUDY), copy)
        path.write_bytes(before)
    info = json.loads((copy / "experiment.json").read_text())
    for change in ({"trials": 10**9}, {"hours": "long"}, {"only": 3}, {"base": None}, {"machine": []}):
        (copy / "experiment.json").write_text(json.dumps({**info, **change}))
        with pytest.raises(ExperimentError, match=rf"experiment.json: {next(iter(change))}"):
            Experiment.open(copy)
    (copy / "experiment.json").write_text("[" * 5000)
    with pytest.raises(ExperimentError, match=r"experiment.json is not valid"):
        Experiment.open(copy)


def test_more_trials_are_added_to_what_is_there(finished: Experiment, tmp_path: Path) -> None:
    shutil.copytree(finished.folder, tmp_path / "more")
    more = Experiment.create(str(STUDY), tmp_path / "more", trials=3)
    assert [(job["condition"], job["trial"]) for job, _ in more.missing()] == [(n, 2) for n in more.study.conditions]


def test_sets_that_cannot_be_had_are_named(tmp_path: Path) -> None:
    for source, message in (
        ("package = 'nothing'", "no demonstration set 'nothing' ships"),
        ("file = 'nothing.csv'", "nothing"),
        ("teacher = 'Nobody'\nepisodes = 1", "no scripted teacher 'Nobody'"),
        ("rules = 'nothing.json'", "no such decision list"),
    ):
        study = tmp_path / "study.toml"
        text = f"[demonstrations.X]\n{source}\n[[condition]]\nname = 'x'\nmethod = 'ppr'\ndemonstrations = 'X'\n"
        study.write_text(text)
        experiment = Experiment.create(str(study), tmp_path / source.replace("/", "").replace("\n", "")[:12])
        with pytest.raises(StudyError, match=message):
            experiment.prepare_sets()


# -- report ------------------------------------------------------------------------------------------------------------


def test_the_report_has_tables_figures_verdicts_and_seeds(finished: Experiment, tmp_path: Path) -> None:
    markdown, page = write_report(finished, tmp_path)
    text, html = markdown.read_text(), page.read_text()
    for part in ("Something certain", "**reproduced**", "**not reproduced**", "p, Welch + Holm", "± "):
        assert part in text
    for seed in Results(finished).seeds("replay"):
        assert str(seed) in text and str(seed) in html
    assert html.count("<svg") == 1 and "src=" not in html and "<link" not in html and "<script" not in html
    ET.fromstring(html[html.index("<svg") : html.index("</svg>") + 6])
    assert (tmp_path / "figures" / "curves.png").stat().st_size > 10_000
    table = pd.read_csv(tmp_path / "tables" / "conditions.csv")
    assert table["Method"].tolist() == ["No Prior", "printed", "replay", "rounds"]
    assert table["Total Reward, paper"].tolist() == ["–", "411", "–", "–"]
    trials = pd.read_csv(tmp_path / "trials.csv")
    assert len(trials) == 8 and trials["total"].notna().all()
    again = write_report(finished, tmp_path / "again")
    assert again[1].read_text() == html and again[0].read_text() == text


def test_claims_compare_other_metrics_and_teachers(finished: Experiment) -> None:
    results = Results(finished)
    verdict = results.verdicts()[2]
    hours, initial, teacher = verdict.evidence
    assert results.sample("printed", "hours").tolist() == [1.0, 1.0], "no window of 1,000 episodes in an hour"
    assert hours.holds and initial.holds
    mean = finished.sets.prepare("A").figures["mean_s"]
    assert teacher.comparison is not None
    assert teacher.comparison.difference == pytest.approx(results.value("no-prior", "final")[0] - mean)
    text = make_document(results).to_markdown()
    assert "No Prior: final lower than the demonstrations' mean, Subject A" in text
    assert "printed: hours to threshold similar to No Prior" in text
    assert "No Prior: initial policy similar to initial policy of No Prior" in text


def test_measures_agree_with_the_logs(finished: Experiment) -> None:
    results = Results(finished)
    logs = [record.log for record in finished.trials("printed")]
    expected = [log["seconds"].tail(1000).mean() for log in logs if log is not None]
    assert results.sample("printed", "final") == pytest.approx(expected)
    assert results.sample("printed", "total") == pytest.approx(expected)  # one hour: one term
    initial = [finished.trials(name) for name in ("printed", "no-prior")]
    means = [np.mean([record.result["initial"]["mean_s"] for record in records]) for records in initial]
    assert results.value("printed", "jumpstart")[0] == pytest.approx(means[0] - means[1])
    assert np.isnan(results.value("no-prior", "jumpstart")[0])
    assert results.threshold == round(results.value("no-prior", "final")[0] - 0.3, 1)
    frame = result_table(results, tables_of(results)[0])
    assert frame.loc[1, "Jumpstart, paper"] == "**-0.30**" and frame.loc[1, "Final, paper"] == "15.2"


def test_without_a_finished_trial_there_is_no_report(tmp_path: Path) -> None:
    experiment = Experiment.create(str(STUDY), tmp_path / "new")
    with pytest.raises(ExperimentError, match="no trial"):
        write_report(experiment)


# -- Dask --------------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def cluster() -> Iterator[str]:
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, host="127.0.0.1"
    ) as found:
        yield found.scheduler_address


@pytest.mark.slow
def test_a_dask_cluster_of_processes_gives_the_same_numbers(finished: Experiment, cluster: str, tmp_path: Path) -> None:
    experiment = Experiment.create(str(STUDY), tmp_path / "dask", only=("no-prior", "rounds"))
    experiment.prepare_sets()
    results = list(experiment.run(lambda work: run_on_cluster(work, cluster)))
    assert len(results) == 4 and list(experiment.missing()) == []
    for name in ("no-prior", "rounds"):
        for trial in range(2):
            mine, theirs = (e.trial_folder(name, trial) for e in (finished, experiment))
            assert (mine / "episodes.csv").read_bytes() == (theirs / "episodes.csv").read_bytes()
            a, b = (json.loads((folder / "result.json").read_text()) for folder in (mine, theirs))
            assert {**a, "wall_s": 0} == {**b, "wall_s": 0}
            assert TrainingRun.open(theirs).done


@pytest.mark.slow
def test_a_dask_cluster_that_is_not_there_is_named(finished: Experiment, tmp_path: Path) -> None:
    pytest.importorskip("distributed")
    experiment = Experiment.create(str(STUDY), tmp_path / "none", trials=1, only=("no-prior",))
    with pytest.raises(ClusterError, match=r"no Dask scheduler answers at tcp://127\.0\.0\.1:9"):
        list(experiment.run(lambda work: run_on_cluster(work, "tcp://127.0.0.1:9")))
    assert threading.active_count() < 50


def test_other_workers_go_on_when_some_are_killed_but_not_for_ever(finished: Experiment, tmp_path: Path) -> None:
    experiment = Experiment.create(str(STUDY), tmp_path / "killed", only=("no-prior",))
    calls = []

    def runner(work: Work, succeed_at: int) -> Iterator[dict[str, Any]]:
        calls.append(len(list(work)))
        if len(calls) < succeed_at:
            raise WorkerDied("a worker process was killed")
        yield {"condition": "no-prior", "trial": 0}

    assert len(list(experiment.run(lambda work: runner(work, 3)))) == 1 and calls == [2, 2, 2]
    with pytest.raises(ExperimentError, match="10 times in a row a worker process was killed"):
        list(experiment.run(lambda work: runner(work, 99)))


@pytest.mark.slow
@pytest.mark.parametrize("stage", ["fake", "real"])
def test_dask_workers_start_their_own_servers(cluster: str, tmp_path: Path, stage: str) -> None:
    if stage == "real" and find_executable() is None:
        pytest.skip("no rcssserver is on the PATH")
    text = STUDY.with_name("served.toml").read_text().replace('stage = "fake"', f'stage = "{stage}"')
    (tmp_path / "study.toml").write_text(text)
    experiment = Experiment.create(str(tmp_path / "study.toml"), tmp_path / "dask", only=("no-prior",))
    results = list(experiment.run(lambda work: run_on_cluster(work, cluster, Supply())))
    assert len(results) == 2 and list(experiment.missing()) == []
    for trial in range(2):
        folder = experiment.trial_folder("no-prior", trial)
        notes = read_matches(folder)
        assert [note.server for note in notes] == [stage] * 3 and all(note.seed for note in notes)
        assert (folder / "servers" / "001" / "keepaway.kwy").exists() and TrainingRun.open(folder).done
    seeds = [seed for result in results for seed in result["servers"]["seeds"]]
    assert len(set(seeds)) == 6


# -- command line ------------------------------------------------------------------------------------------------------


def test_the_command_runs_resumes_and_reports(tmp_path: Path) -> None:
    arguments = ["experiment", str(STUDY), "--trials", "1", "--only", "no-prior", "--jobs", "1"]
    out = ["--out", str(tmp_path / "run")]
    first = CliRunner().invoke(cli, [*arguments, *out, "--json"])
    assert first.exit_code == 0, first.output
    summary = json.loads(first.stdout)
    assert (summary["trials"], summary["finished"]) == (1, 1)
    assert all(Path(page).exists() for page in summary["report"])
    again = CliRunner().invoke(cli, [*arguments, *out, "--no-report"])
    assert again.exit_code == 0 and "1 of 1 trials" in again.stdout
    report = CliRunner().invoke(cli, ["report", str(tmp_path / "run"), "--out", str(tmp_path / "there")])
    assert report.exit_code == 0 and (tmp_path / "there" / "report.html").exists()
    as_json = CliRunner().invoke(cli, ["report", str(tmp_path / "run"), "--json"])
    assert json.loads(as_json.stdout)["finished"] == 1


def test_the_command_says_what_is_wrong(tmp_path: Path) -> None:
    unknown = CliRunner().invoke(cli, ["experiment", "nothing", "--out", str(tmp_path / "x")])
    assert unknown.exit_code == 2 and "no study 'nothing'" in unknown.stderr
    for text, message in (
        ("[demonstrations.'../../evil']\nteacher = 'A'\nepisodes = 1", "'../../evil'"),
        ("[[condition]]\nname = 'x'\ntrials = 1000000000", "trials must be at least 1 and at most 10,000"),
        ("x = " + "[" * 5000, "nested more than"),
    ):
        (tmp_path / "study.toml").write_text(text)
        wrong = CliRunner().invoke(cli, ["experiment", str(tmp_path / "study.toml"), "--out", str(tmp_path / "x")])
        assert wrong.exit_code == 2 and message in wrong.stderr and not (tmp_path / "x").exists()
    empty = CliRunner().invoke(cli, ["report", str(tmp_path)])
    assert empty.exit_code == 1 and "not the folder of an experiment" in empty.stderr
