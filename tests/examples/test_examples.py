"""Every program in examples/ runs, with small settings, and says what it promises."""

from __future__ import annotations

import importlib.util
import json
import runpy
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[2] / "examples"
NEEDS = {"deep_q_and_ppo": "stable_baselines3", "study_on_dask": "distributed"}
RUNS = [
    ("own_policy", "--episodes 2", "the same episodes in the arena and on the stand-in: True"),
    ("train_and_plot", "--hours 0.05 --out plots", "plots/curves.png"),
    ("own_method", "--hours 0.05 --out method", "Trust: D with 0.999 ** episodes"),
    ("ripper_on_any_table", "", "(petal_width >= 1.7) => class=virginica"),
    ("watch_a_learner", "--render ansi --lessons 2 --hours 0.02", "mean of training"),
    ("replayed_bug", "", "mended: has read everything"),
    ("in_turns", "keepers --episodes 4 --window 2", "in-turns-keepers: 2: "),
    ("in_turns", "takers --episodes 4 --window 2", "in-turns-takers: 2: "),
]
SLOW = [
    ("cloning", "--rounds 1 --decisions 80 --save tree.joblib", "the expert: "),
    ("deep_q_and_ppo", "ppo --steps 2048 --points 1", "ppo: 0: "),
    ("deep_q_and_ppo", "dqn --steps 600 --points 1", "dqn: 0: "),
    ("deep_q_and_ppo", "jsrl --steps 600 --points 1", "jsrl: 0: "),
    ("study_on_dask", "--hours 0.05 --trials 1 --evaluations 5 --workers 1 --out dask", "3 of 3 trials"),
]
NOTEBOOKS = [
    ("hat_in_a_notebook", {"HOURS, EPISODES = 5, 200": "HOURS, EPISODES = 0.1, 10"}, "learned, without exploration: "),
    ("environments", {"STEPS = 2000": "STEPS = 400"}, "PASS2: "),
]
pytestmark = pytest.mark.compiled


@pytest.fixture(autouse=True)
def somewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Programs write where they are started; pictures are not shown."""
    matplotlib = pytest.importorskip("matplotlib")
    matplotlib.use("Agg")
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(EXAMPLES)


def run(name: str, arguments: str, monkeypatch: pytest.MonkeyPatch) -> None:
    if name in NEEDS and importlib.util.find_spec(NEEDS[name]) is None:
        pytest.skip(f"needs {NEEDS[name]}")
    monkeypatch.setattr(sys, "argv", [f"{name}.py", *arguments.split()])
    try:
        runpy.run_path(str(EXAMPLES / f"{name}.py"), run_name="__main__")
    except SystemExit as end:
        assert end.code in (0, None)


@pytest.mark.parametrize(("name", "arguments", "said"), RUNS, ids=lambda part: str(part)[:30])
def test_the_program_runs(
    name: str, arguments: str, said: str, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    run(name, arguments, monkeypatch)
    assert said in capfd.readouterr().out


@pytest.mark.slow
@pytest.mark.parametrize(("name", "arguments", "said"), SLOW, ids=lambda part: str(part)[:30])
def test_the_longer_program_runs(
    name: str, arguments: str, said: str, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    run(name, arguments, monkeypatch)
    assert said in capfd.readouterr().out


@pytest.mark.slow
@pytest.mark.parametrize(("name", "smaller", "said"), NOTEBOOKS, ids=lambda part: str(part)[:30])
def test_the_notebook_runs(name: str, smaller: dict[str, str], said: str, capfd: pytest.CaptureFixture[str]) -> None:
    cells = json.loads((EXAMPLES / f"{name}.ipynb").read_text())["cells"]
    names: dict[str, object] = {"__name__": "notebook"}
    sources = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    for long, short in smaller.items():
        assert any(long in source for source in sources)
        sources = [source.replace(long, short) for source in sources]
    for number, source in enumerate(sources, 1):
        exec(compile(source, f"{name}, cell {number}", "exec"), names)
    assert said in capfd.readouterr().out


def test_the_bug_is_in_the_recording(monkeypatch: pytest.MonkeyPatch) -> None:
    example = runpy.run_path(str(EXAMPLES / "replayed_bug.py"))
    assert "AttributeError" in example["first_fault"](example["naive"])
    assert example["first_fault"](example["mended"]) is None
    distances = [example["mended"](said) for said in example["recorded"](example["RECORDING"])]
    assert any(distance is not None and distance < 1.0 for distance in distances)  # the ball at his feet


def test_every_program_is_listed_and_run() -> None:
    programs = {file.stem for file in EXAMPLES.glob("*.py")} - {"curves"}
    notebooks = {file.stem for file in EXAMPLES.glob("*.ipynb")}
    assert programs == {name for name, *_ in [*RUNS, *SLOW]}
    assert notebooks == {name for name, *_ in NOTEBOOKS}
    listed = (EXAMPLES / "README.md").read_text()
    files = [file.name for file in EXAMPLES.iterdir() if file.stem in programs | notebooks and file.suffix != ".gz"]
    assert [name for name in files if f"({name})" not in listed] == []
