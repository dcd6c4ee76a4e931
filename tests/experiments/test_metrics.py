from __future__ import annotations

import gzip
import math
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rcss_hat.experiments import metrics
from rcss_hat.keepaway.report import Episode

DATA = Path(__file__).parents[1] / "data" / "experiments"


def log_of(cycles: list[int]) -> pd.DataFrame:
    """Contiguous episodes of these durations."""
    ends = np.cumsum(cycles).tolist()
    return metrics.episode_frame(
        Episode(k, end - duration, end, "o") for k, (duration, end) in enumerate(zip(cycles, ends, strict=True), 1)
    )


@pytest.fixture(scope="module")
def kwy(tmp_path_factory: pytest.TempPathFactory) -> dict[str, pd.DataFrame]:
    logs = {}
    for name in ("hand", "learned-cmac"):
        path = tmp_path_factory.mktemp("kwy") / f"{name}.kwy"
        path.write_bytes(gzip.decompress((DATA / f"{name}-3v2-20x20.kwy.gz").read_bytes()))
        logs[name] = metrics.read_kwy(path)
    return logs


def test_logs_of_the_real_server(kwy: dict[str, pd.DataFrame]) -> None:
    log = kwy["hand"]
    assert list(log.columns) == ["episode", "start", "end", "duration", "reason", "psi", "hour", "seconds"]
    assert len(log) == 604
    assert log["seconds"].mean() == pytest.approx(10.94, abs=0.005)
    assert log["seconds"].std() == pytest.approx(7.16, abs=0.005)
    assert (log["start"].iloc[1:].to_numpy() == log["end"].iloc[:-1].to_numpy()).all()
    assert (log["reason"] == "o").mean() == pytest.approx(0.51, abs=0.005)
    assert log["hour"].iloc[-1] == log["end"].iloc[-1] / 36_000


def test_the_learning_curve_of_the_players_own_learner(kwy: dict[str, pd.DataFrame]) -> None:
    published = {0.5: 5.59, 1: 5.59, 2: 5.63, 3: 6.14, 4: 6.89, 5: 7.32, 6: 7.84, 7: 8.21, 8: 8.57, 9: 8.90, 10: 9.33}
    log = kwy["learned-cmac"]
    curve = metrics.learning_curve(log, list(published))
    assert curve == pytest.approx(list(published.values()), abs=0.006)
    assert metrics.total_reward(log, 10) == pytest.approx(sum(list(published.values())[1:]), abs=0.05)
    assert metrics.final_reward(log, 10) == curve[-1]
    assert metrics.early_reward(log) == pytest.approx(5.62, abs=0.006)
    hour = metrics.time_to_threshold(log, 7.0)
    assert 4.0 < hour < 4.5
    assert metrics.learning_curve(log, [hour])[0] >= 7.0


def test_a_file_that_is_no_log_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "a.kwy"
    path.write_text("1 2 3\n")
    with pytest.raises(ValueError, match=r"a\.kwy, line 1"):
        metrics.read_kwy(path)


def test_windowed_means() -> None:
    assert metrics.windowed_means([1, 3, 5, 7], window=2).tolist() == [1.0, 2.0, 4.0, 6.0]
    assert metrics.windowed_means([1, 3, 5, 7]).tolist() == [1.0, 2.0, 3.0, 4.0]
    with pytest.raises(ValueError, match="at least 1 episode, not 0"):
        metrics.windowed_means([1], window=0)


@given(st.lists(st.integers(1, 500), min_size=1, max_size=60), st.integers(1, 12))
def test_windowed_means_are_means_of_windows(cycles: list[int], window: int) -> None:
    expected = [np.mean(cycles[max(0, k - window) : k]) for k in range(1, len(cycles) + 1)]
    assert metrics.windowed_means(cycles, window) == pytest.approx(expected)


def test_a_curve_takes_the_episodes_finished_by_its_hours() -> None:
    log = log_of([9_000, 27_000, 36_000])  # ends at 0.25, 1 and 2 hours
    curve = metrics.learning_curve(log, [0.1, 0.25, 0.9999, 1.0, 1.5, 2.0, 50.0])
    assert math.isnan(curve[0])
    assert curve[1:] == pytest.approx([900.0, 900.0, 1800.0, 1800.0, 2400.0, 2400.0])
    assert metrics.learning_curve(log, [2.0], window=1).tolist() == [3600.0]


def test_total_reward_is_the_sum_over_whole_hours() -> None:
    # 360 episodes of 10 s, then 180 of 20 s, then 360 of 10 s: the means at hours 1 and 2 are 10 and 40/3.
    log = log_of([100] * 360 + [200] * 180 + [100] * 360)
    assert metrics.total_reward(log, 1) == pytest.approx(10.0)
    assert metrics.total_reward(log, 2) == pytest.approx(10.0 + 7200 / 540)
    assert metrics.total_reward(log, 3) == pytest.approx(10.0 + 7200 / 540 + 10800 / 900)
    assert metrics.total_reward(log, 3, window=360) == pytest.approx(10.0 + (180 * 20 + 180 * 10) / 360 + 10.0)


def test_total_reward_of_a_constant_player() -> None:
    assert metrics.total_reward(log_of([120] * 9_000), 30) == pytest.approx(30 * 12.0)


def test_logs_that_are_too_short_are_refused_but_not_for_the_last_episode() -> None:
    log = log_of([1_000] * 35)  # the next episode was being played at 1 h
    assert metrics.total_reward(log, 1) == pytest.approx(100.0)
    assert metrics.final_reward(log, 1) == pytest.approx(100.0)
    for measure in (metrics.total_reward, metrics.final_reward):
        with pytest.raises(ValueError, match=r"ends after 0\.97 of 2 simulated hours"):
            measure(log, 2)
    with pytest.raises(ValueError, match=r"whole hours, at least 1, not 1\.5"):
        metrics.total_reward(log, 1.5)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="empty"):
        metrics.final_reward(log_of([]))
    with pytest.raises(ValueError, match="empty"):
        metrics.early_reward(log_of([]))
    with pytest.raises(ValueError, match="needs a column 'duration'; there are a"):
        metrics.final_reward(pd.DataFrame({"a": [1]}))


def test_final_and_early_rewards() -> None:
    log = log_of([100] * 1000 + [150] * 500 + [200] * 500)
    assert metrics.final_reward(log) == pytest.approx(17.5)
    assert metrics.early_reward(log) == pytest.approx(10.0)
    assert metrics.final_reward(log, window=500) == pytest.approx(20.0)


def test_time_to_threshold() -> None:
    log = log_of([200, *[100] * 9, *[200] * 20])
    # Windows of 4: the first to reach 17.5 s has one episode of 10 s left. The first episode alone does not count.
    expected = (200 + 900 + 3 * 200) / 36_000
    assert metrics.time_to_threshold(log, 17.5, window=4) == pytest.approx(expected)
    assert metrics.time_to_threshold(log, 20.0, window=4) == pytest.approx(expected + 200 / 36_000)
    assert math.isnan(metrics.time_to_threshold(log, 20.1, window=4))
    assert math.isnan(metrics.time_to_threshold(log, 1.0, window=31)), "there never is a full window"
    assert metrics.time_to_threshold(log, 1.0, window=30) == pytest.approx(log["hour"].iloc[-1])


def test_curves_over_trials() -> None:
    logs = [log_of([100] * 360), log_of([200] * 180), log_of([300] * 120)]
    curves = metrics.learning_curves(logs, [0.5, 1.0])
    assert curves.mean == pytest.approx([20.0, 20.0])
    assert curves.standard_error == pytest.approx([10.0 / math.sqrt(3)] * 2)
    assert np.isnan(metrics.learning_curves(logs[:1], [1.0]).standard_error).all()
    with pytest.raises(ValueError, match="at least one"):
        metrics.learning_curves([], [1.0])
