from __future__ import annotations

import asyncio

import numpy as np
import pytest

from rcss_hat.hat.policy import TeamPolicy, load_policy
from rcss_hat.keepaway.task import Task
from rcss_hat.stage.place import ARENA, Place
from rcss_hat.stage.stages import open_stage
from rcss_hat.viewer.controls import KeyChannel
from rcss_hat.viewer.demonstrator import Demonstrator
from rcss_hat.viewer.episodes import EpisodeTracker
from rcss_hat.viewer.playback import Playback
from rcss_hat.viewer.situation import situation, state_variables
from rcss_hat.viewer.stage_game import StageGame
from rcss_hat.viewer.stage_reel import StageReel
from rcss_hat.viewer.values import values_of

from .audience import Remembering, played_by, until


def policy(name: str, task: Task, seed: int = 1) -> TeamPolicy:
    return load_policy(name, task.keepers, task.takers, seed)


@pytest.fixture(scope="module")
def reel() -> StageReel:
    task = Task()
    reel = StageReel(open_stage(Place(ARENA), task, 1, policy("hand", task)), episodes=12)

    async def play() -> None:
        while not reel.complete:
            await reel.grow()

    asyncio.run(play())
    return reel


def test_a_match_of_the_arena_is_a_reel(reel: StageReel) -> None:
    assert len(reel.episodes) == 12
    times = [scene.snapshot.time for scene in reel.scenes]
    assert times == list(range(times[0], times[0] + len(times))) and times[-1] == reel.episodes[-1].end
    assert {tuple(p.id for p in scene.snapshot.players) for scene in reel.scenes} == {("l1", "l2", "l3", "r1", "r2")}
    assert {scene.snapshot.mode for scene in reel.scenes} == {"play_on"}
    bodies = [p.body for scene in reel.scenes for p in scene.snapshot.players]
    assert max(bodies) <= 180.0 and min(bodies) >= -180.0 and max(bodies) > 90.0


def test_what_the_tracker_sees_is_what_the_referee_decided(reel: StageReel) -> None:
    tracker = EpisodeTracker(reel.setup)
    seen = [e for scene in reel.scenes if (e := tracker.see(scene.snapshot)) is not None]
    assert seen == reel.episodes
    for episode in reel.episodes:
        first = next(s for s in reel.scenes if s.snapshot.time > episode.start)
        assert (first.episode, first.start) == (episode.number, episode.start)


def test_thoughts_belong_to_the_keeper_with_the_ball(reel: StageReel) -> None:
    """What a keeper perceives is near the truth that the viewer computes, variable by variable."""
    differences = []
    for scene in reel.scenes:
        here = situation(scene.snapshot, reel.setup)
        thought = scene.thoughts.get(here.keepers[0].unum)
        if thought is None:
            continue
        true = state_variables(here)
        assert true is not None and thought.cycle == scene.snapshot.time
        differences.append(np.abs(np.array(thought.state) - true))
    assert len(differences) > 100
    assert (np.median(differences, axis=0)[:11] < 1.0).all()
    assert (np.median(differences, axis=0)[11:] < 10.0).all()


async def test_a_person_plays_the_arena_at_real_time_pace() -> None:
    task = Task()
    demonstration = Demonstrator(KeyChannel(), None, 4)
    game = StageGame(played_by(demonstration, 5, task), demonstration, speed=10.0)
    audience = Remembering()
    passing = False

    class Both(Remembering):
        """Shows frames to the demonstration as the page does."""

        def frame(self, frame):  # type: ignore[no-untyped-def]
            demonstration.observe(frame)
            if passing and demonstration.keys.taken is None:
                demonstration.keys.press(1)
            audience.frame(frame)

        def episode(self, episode):  # type: ignore[no-untyped-def]
            audience.episode(episode)

    assert not game.command("pause", 0)
    running = asyncio.create_task(game.run(Both()))
    await until(lambda: audience.frames, 300.0)
    loop = asyncio.get_running_loop()
    begun, first = loop.time(), audience.frames[-1]["time"]
    await until(lambda: audience.frames[-1]["time"] >= first + 50)
    assert 0.4 < loop.time() - begun < 1.5
    await until(lambda: any(f["seen"] for f in audience.frames))
    assert {f["action"] for f in audience.frames if f["seen"]} == {0}
    passing = True
    await until(lambda: demonstration.keys.taken)
    assert demonstration.keys.taken is not None and demonstration.keys.taken[1] == 1
    await until(lambda: demonstration.finished, 30.0)
    await running
    assert [e.number for e in audience.ended] == [1, 2, 3, 4] and demonstration.kept == 4


def test_only_learned_policies_have_values() -> None:
    task = Task()
    assert values_of(policy("hand", task)) is None


def test_values_of_a_learned_policy_are_those_it_plays_by() -> None:
    from rcss_hat.hat.policy import learners_policy
    from rcss_hat.hat.transfer import Learners, NoPrior
    from rcss_hat.learning.config import load_config

    learners = Learners.create(load_config("paper"), NoPrior(), seed=1)
    learners.weights[1, 2] += 0.125
    values = values_of(learners_policy(learners, None))
    assert values is not None
    before = learners.records.copy()
    state = np.linspace(2.0, 20.0, 13)
    found = values(2, state)
    assert found is not None and len(found) == 3 and found[2] > found[0] == found[1]
    assert values(1, state) == [0.0, 0.0, 0.0] and values(4, state) is None
    assert (learners.records == before).all()


async def test_a_growing_arena_match_is_played_back() -> None:
    task = Task()
    stage = open_stage(Place(ARENA), task, 2, policy("random", task, 2))
    playback = Playback(StageReel(stage, episodes=2), speed=100.0)
    audience = Remembering()
    running = asyncio.create_task(playback.run(audience))
    await until(lambda: not playback.playing, 300.0)
    running.cancel()
    await asyncio.gather(running, return_exceptions=True)
    assert len(audience.ended) == 2
    assert audience.frames[-1]["state"] is not None and audience.statuses[-1]["complete"]
