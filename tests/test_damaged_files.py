"""Every kind of file that is read, damaged 2,000 times each: it is read, or refused in one line, and nothing else."""

from __future__ import annotations

import gzip
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from damage import damaged

from fake_server.replay import TranscriptError, read_transcript
from rcss_hat.experiments.episode_log import EpisodeLogError, read_episode_log
from rcss_hat.experiments.run_folder import TrainingError, read_config
from rcss_hat.hat.decision_list import PAPER_RULES, DecisionList
from rcss_hat.hat.demonstrations import Demonstration, DemonstrationInfo, DemonstrationSet
from rcss_hat.inputs import FileFormatError
from rcss_hat.keepaway.report import TAKEN, Episode, read_kwy
from rcss_hat.protocol.keepaway_log import log_head, log_line
from rcss_hat.viewer.audience import WatchError
from rcss_hat.viewer.playback import Playback
from rcss_hat.viewer.recording import read_recording

TIMES = 2_000
RUNS = TIMES // 2
"""Damages of a checkpoint's file, and of numbers in a sound one."""
DATA = Path(__file__).parent / "data"
EXPECTED = (FileFormatError, EpisodeLogError, TrainingError, TranscriptError, WatchError)
"""The project's own errors of files, each of one line."""
JRIP = """JRIP rules:
===========

(state_11 >= 74.84) and (state_3 <= 5.99) => Action=1 (30.0/2.0)
 => Action=0 (9.0/1.0)

Number of Rules : 2
"""
EPISODES = """episode,start,duration,reason,psi,hour
1,0,31,o,0.999,0.00086
2,31,60,t,,0.00253
3,91,12,?,,0.00286
"""
CONFIG = """{"format": "rcss-hat training run", "version": 1,
"task": {"keepers": 3, "takers": 2, "length": 20.0, "width": 20.0, "vision": 360, "profile": "19.0"},
"learner": {"approximator": "rbf", "tilings": 32, "sigma": 0.25, "cutoff": 0.75},
"method": "ppr", "method_settings": {"decay": 0.99, "schedule": "episode"},
"seed": 1, "hours": 2.0, "stage": "arena", "source": "rules.json"}"""
KWY = log_head(3, 2, 20.0, 20.0) + log_line(1, 0, 31, "o") + log_line(2, 31, 60, "t")
TRANSCRIPT = """{"client": "a", "dir": "send", "text": "(init x (version 12))"}
{"client": "a", "dir": "recv", "text": "(init l 1 before_kick_off)"}
{"client": "m", "dir": "recv", "base64": "AAECAw=="}
"""


def demonstration(folder: Path) -> Path:
    states = np.random.default_rng(1).uniform(0.0, 20.0, (3, 13))
    made = Demonstration(
        Episode(1, 5, 60, TAKEN), "A", np.array([10, 20, 30]), np.array([1, 2, 1]), states, np.arange(3)
    )
    path = folder / "whole.csv"
    DemonstrationSet(DemonstrationInfo("A", "arena"), (made,)).save(path)
    return path


def use_demonstration(path: Path) -> None:
    DemonstrationSet.load(path).describe().to_text()


def use_rules(path: Path) -> None:
    rules = DecisionList.load(path)
    rules.to_arrays()
    rules.predict(np.random.default_rng(1).uniform(-5.0, 25.0, (20, len(rules.names))))


def use_recording(path: Path) -> None:
    recording = read_recording(path)
    playback = Playback(recording)
    for position in {0, len(recording.scenes) - 1}:
        playback.frame(position)


def short_log(name: str, shows: int = 3) -> bytes:
    lines = gzip.decompress((DATA / "viewer" / name).read_bytes()).split(b"\n")
    first = next(k for k, line in enumerate(lines) if b"show" in line[:8])
    return b"\n".join(lines[: first + shows]) + b"\n"


KINDS: dict[str, tuple[str, bytes, Callable[[Path], object]]] = {
    "rules.json": ("rules.json", PAPER_RULES.to_json().encode(), use_rules),
    "rules.txt": ("rules.txt", PAPER_RULES.format().encode(), use_rules),
    "jrip.txt": ("jrip.txt", JRIP.encode(), use_rules),
    "kwy": (
        "keepaway.kwy",
        KWY.encode(),
        read_kwy,
    ),
    "episodes.csv": ("episodes.csv", EPISODES.encode(), read_episode_log),
    "config.json": ("config.json", CONFIG.encode(), lambda path: read_config(path.parent)),
    "transcript": ("t.jsonl", TRANSCRIPT.encode(), read_transcript),
    "transcript.gz": ("t.jsonl.gz", gzip.compress(TRANSCRIPT.encode() * 9, mtime=0), read_transcript),
    "rcg4": ("game.rcg", short_log("sample-v4.rcg.gz"), use_recording),
    "rcg5": ("game.rcg", short_log("sample-v5.rcg.gz"), use_recording),
    "rcg6": ("game.rcg", short_log("sample-v6.rcg.gz"), use_recording),
    "rcg-json": ("game.rcg", short_log("sample-json.rcg.gz"), use_recording),
    "rcg.gz": ("game.rcg.gz", gzip.compress(short_log("sample-v5.rcg.gz"), mtime=0), use_recording),
}


def outcome(use: Callable[[Path], object], path: Path, seed: str) -> bool:
    """Whether a file was accepted; fails when it raised anything but one of the project's errors in one line."""
    try:
        use(path)
    except EXPECTED as error:
        message = str(error)
        assert "\n" not in message and "\x1b" not in message and len(message) < 1000, (seed, message)
        return False
    except Exception as error:
        raise AssertionError(f"{seed}: {type(error).__name__}: {error}") from error
    return True


@pytest.mark.parametrize("kind", KINDS)
def test_a_damaged_file_is_read_or_refused(kind: str, tmp_path: Path) -> None:
    name, data, use = KINDS[kind]
    path = tmp_path / name
    path.write_bytes(data)
    assert outcome(use, path, kind), "the whole file is read"
    accepted = 0
    for k in range(TIMES):
        seed = f"{kind} {k}"
        path.write_bytes(damaged(data, seed))
        accepted += outcome(use, path, seed)
    assert accepted < TIMES


@pytest.mark.parametrize("part", [".csv", ".json"])
def test_a_damaged_demonstration_is_read_or_refused(part: str, tmp_path: Path) -> None:
    path = demonstration(tmp_path)
    data = path.with_suffix(part).read_bytes()
    for k in range(TIMES):
        seed = f"demonstration{part} {k}"
        path.with_suffix(part).write_bytes(damaged(data, seed))
        outcome(use_demonstration, path, seed)


@pytest.mark.timeout(600)
def test_damaged_runs_are_refused_or_play_on(tmp_path: Path) -> None:
    """In a process of its own, so that a crash or an endless loop of compiled code is seen and not suffered."""
    script = Path(__file__).parent / "damaged_runs.py"
    done = subprocess.run(
        [sys.executable, script, tmp_path, str(RUNS)], capture_output=True, text=True, timeout=580, check=False
    )
    log = (tmp_path / "log.txt").read_text().splitlines()
    assert done.returncode == 0, (done.returncode, log[-1:], done.stderr[-2000:])
    refused, played = map(int, done.stdout.split())
    assert refused + played == 2 * RUNS
    assert refused > RUNS and played > RUNS // 10
