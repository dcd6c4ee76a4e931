"""Demonstrations as trajectories of Minari and imitation, complete: rewards, and what was seen at the end."""

from __future__ import annotations

import dataclasses
import sys
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from rcss_hat.arena.match import ArenaMatch
from rcss_hat.experiments.sets import package_demonstrations
from rcss_hat.hat.demonstration_writer import DemonstrationWriter
from rcss_hat.hat.demonstrations import DemonstrationInfo, DemonstrationSet
from rcss_hat.hat.exchange import ExchangeError, from_imitation, from_minari, to_imitation, to_minari, trajectory
from rcss_hat.hat.policy import load_policy, python_policy
from rcss_hat.hat.recorder import Recorder
from rcss_hat.inputs import FileFormatError
from rcss_hat.keepaway.task import Task
from rcss_hat.stage.place import ARENA, Place
from rcss_hat.stage.stages import Part, open_stage

INFO = DemonstrationInfo("hand", "arena", Task(), seed=3)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> DemonstrationSet:
    path = tmp_path_factory.mktemp("recorded") / "demo.csv"
    with DemonstrationWriter(path, INFO) as writer:
        recorder = Recorder(writer)
        with open_stage(Place(ARENA), Task(), 3, load_policy("random", 3, 2, 3)) as stage:
            stage.play(Part(4, None, lambda ended, cycle: [recorder.keep(e) for e in ended] == 0, recorder.decided))
    return DemonstrationSet.load(path)


@pytest.mark.compiled
def test_the_arena_records_what_was_seen_at_the_end(recorded: DemonstrationSet) -> None:
    keepaway_env = pytest.importorskip("rcss_hat.envs.keepaway_env")

    def act(state: Any, info: Any = None) -> int:
        return int(state[3] < 6.0)

    match = ArenaMatch(Task(), 8, python_policy(act, 3, 2), log_decisions=True)
    episodes = [e for part in match.advance(episodes=4) for e in part]
    env = keepaway_env.KeepawayEnv()
    seen, _ = env.reset(seed=8)
    finals = {}
    while len(finals) < 3:
        seen, _, over, _, info = env.step(act(seen))
        if over:
            finals[info["number"]] = seen
            seen, _ = env.reset()
    for episode in episodes:
        if episode.number in finals:
            assert episode.final is not None
            np.testing.assert_array_equal(np.array(episode.final, dtype=np.float32), finals[episode.number])
    assert all(d.episode.final is not None and d.episode.final != tuple(d.states[-1]) for d in recorded)


@pytest.mark.compiled
def test_rewards_of_a_trajectory_sum_up_to_the_duration(recorded: DemonstrationSet) -> None:
    for d in recorded:
        t = trajectory(d)
        assert t.rewards.sum() == d.episode.cycles and t.final_is_real
        assert t.observations.shape == (len(d) + 1, 13) and len(t.actions) == len(t.rewards) == len(d)
    d = package_demonstrations("A").episodes[0]
    old = trajectory(replace(d, episode=replace(d.episode, final=None)))  # as in a file of an earlier version
    assert not old.final_is_real
    np.testing.assert_array_equal(old.observations[-1], old.observations[-2])


def test_a_final_state_of_another_size_is_refused(tmp_path: Path) -> None:
    with DemonstrationWriter(tmp_path / "d.csv", INFO) as writer:
        writer.add(5, 1, np.ones(13), 0)
        with pytest.raises(FileFormatError, match="final state of episode 1 has 2 variables; in 3v2 it must be 13"):
            writer.end_episode(0, 20, "o", final=(1.0, 2.0))
        writer.end_episode(0, 20, "o", final=range(13))
    header = tmp_path / "d.json"
    for wrong, message in (('"x", 1.0', "'final' must be numbers"), ("1.0", "has 12 variables")):
        text = header.read_text()
        header.write_text(text.replace("0.0, 1.0", wrong))
        with pytest.raises(FileFormatError, match=message):
            DemonstrationSet.load(header)
        header.write_text(text)
    assert DemonstrationSet.load(header).episodes[0].episode.final == tuple(map(float, range(13)))


# --- Minari ---------------------------------------------------------------------------------------------------------


@pytest.fixture
def minari(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Any:
    found = pytest.importorskip("minari")
    pytest.importorskip("h5py")
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(tmp_path / "minari"))
    return found


@pytest.mark.compiled
def test_a_data_set_of_minari_holds_everything(minari: Any, recorded: DemonstrationSet) -> None:
    assert to_minari(recorded, "keepaway/hand-v0") == 0
    assert from_minari("keepaway/hand-v0") == recorded
    dataset = minari.load_dataset("keepaway/hand-v0")
    for episode, d in zip(dataset, recorded, strict=True):
        assert episode.rewards.sum() == d.episode.cycles
        assert episode.terminations[-1] and not episode.terminations[:-1].any() and not episode.truncations.any()
        assert dataset.observation_space.contains(episode.observations[-1])
    with pytest.raises(ExchangeError, match="there is a data set 'keepaway/hand-v0' already"):
        to_minari(recorded, "keepaway/hand-v0")


def test_old_sets_come_back_as_they_were(minari: Any) -> None:
    shipped = package_demonstrations("A")
    to_minari(shipped, "A-v0")
    assert from_minari("A-v0") == shipped
    with pytest.raises(ExchangeError, match="Minari has no data set 'B-v0' here"):
        from_minari("B-v0")


@pytest.mark.compiled
@pytest.mark.filterwarnings("ignore:.* is set to None:UserWarning", "ignore:env_spec is None:UserWarning")
def test_what_was_collected_from_the_environment_is_read(minari: Any) -> None:
    env = pytest.importorskip("rcss_hat.envs.keepaway_env").KeepawayEnv()
    buffer = minari.data_collector.EpisodeBuffer
    seen, info = env.reset(seed=2)
    columns: dict[str, list[Any]] = {"observations": [seen], "actions": [], "rewards": [], "ends": []}
    infos = {"cycle": [info["cycle"]], "keeper": [info["keeper"]]}
    over = False
    while not over:
        seen, reward, over, _, info = env.step(0)
        for name, value in zip(columns, (seen, 0, reward, over), strict=True):
            columns[name].append(value)
        for name, values in infos.items():
            values.append(info[name])
    n = len(columns["actions"])
    for name, kept in (("told-v0", {k: np.array(v) for k, v in infos.items()}), ("bare-v0", {})):
        minari.create_dataset_from_buffers(
            name,
            [
                buffer(
                    0, observations=np.array(columns["observations"]), actions=np.array(columns["actions"]),
                    rewards=columns["rewards"], terminations=columns["ends"], truncations=[False] * n, infos=kept,
                )
            ],
            observation_space=env.observation_space, action_space=env.action_space,
        )  # fmt: skip
    (read,) = from_minari("told-v0")
    assert (read.episode.start, read.episode.cycles) == (0, info["duration"])
    np.testing.assert_array_equal(trajectory(read).observations, columns["observations"])
    with pytest.raises(ExchangeError, match="bare-v0 lacks 'cycle' of an episode's infos"):
        from_minari("bare-v0")


# --- imitation ------------------------------------------------------------------------------------------------------


@dataclasses.dataclass
class TrajectoryWithRew:
    """What imitation calls so."""

    obs: np.ndarray
    acts: np.ndarray
    infos: np.ndarray
    terminal: bool
    rews: np.ndarray


@pytest.mark.compiled
def test_trajectories_of_imitation_come_and_go(recorded: DemonstrationSet, monkeypatch: pytest.MonkeyPatch) -> None:
    types = ModuleType("imitation.data.types")
    types.TrajectoryWithRew = TrajectoryWithRew  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "imitation", ModuleType("imitation"))
    monkeypatch.setitem(sys.modules, "imitation.data", ModuleType("imitation.data"))
    monkeypatch.setitem(sys.modules, "imitation.data.types", types)
    made = to_imitation(recorded)
    assert [t.rews.sum() for t in made] == [d.episode.cycles for d in recorded]
    assert all(t.terminal and len(t.obs) == len(t.acts) + 1 == len(t.infos) + 1 for t in made)
    back = from_imitation(made, INFO)
    np.testing.assert_array_equal(back.y, recorded.y)
    np.testing.assert_array_equal(back.durations, recorded.durations)
    made[0].rews = made[0].rews * 0.5
    with pytest.raises(ExchangeError, match="rewards must be cycles"):
        from_imitation(made, INFO)


def test_a_library_that_is_missing_is_named(recorded: DemonstrationSet, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "imitation.data.types", None)
    with pytest.raises(ExchangeError, match=r"this needs imitation, .*: pip install imitation"):
        to_imitation(recorded)
