"""Scripted teachers: strategy, reaction time and human error, each in a scene where it alone decides."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rcss_hat.hat.teachers import MAX_DELAY, STYLES, ScriptedTeacher, Teacher, style, teach

CALM = Teacher(
    delay=4.0, delay_spread=0.0, anticipation=0.0, misjudgement=0.0, pass_distance=5.0, panic_distance=1.0, open=40.0,
    space_weight=2.0,
)  # fmt: skip
"""Reacts after exactly four cycles and makes no error."""

KEEPERS = np.array([[0.0, 0.0], [10.0, 0.0], [0.0, 12.0]])
BALL = np.array([0.4, 0.0])
FAR = np.array([[-12.0, -9.0], [-12.0, -8.0]])
NEAR_BEHIND = np.array([[-3.0, -1.0], [-12.0, -8.0]])  # both lanes open
ON_NEAR_LANE = np.array([[4.0, 0.0], [-12.0, -8.0]])  # the lane to the nearer mate is closed
ON_BOTH_LANES = np.array([[4.0, 0.0], [0.0, 4.0]])


def keys(teacher: ScriptedTeacher, takers: np.ndarray, cycles: range, keepers: np.ndarray = KEEPERS) -> list[int]:
    """Keys pressed while nothing moves."""
    return [teacher(cycle, BALL, keepers, takers) for cycle in cycles]


def settled(teacher: Teacher, takers: np.ndarray, keepers: np.ndarray = KEEPERS, seed: int = 0) -> int:
    """The key pressed after looking at an unchanging scene for long."""
    return keys(ScriptedTeacher(teacher, seed), takers, range(60), keepers)[-1]


# --- strategy ---------------------------------------------------------------------------------------------------


def test_holds_while_takers_are_far() -> None:
    assert settled(CALM, FAR) == 0


def test_passes_into_the_open_lane_when_pressed() -> None:
    assert settled(CALM, ON_NEAR_LANE) == 2
    mirrored = ON_NEAR_LANE[:, ::-1] * 1.0
    assert settled(CALM, mirrored) == 1


def test_keys_are_near_and_far_whatever_the_numbers() -> None:
    for order in itertools.permutations(range(3)):
        keepers = KEEPERS[list(order)]
        assert settled(CALM, ON_NEAR_LANE, keepers) == 2


def test_holds_when_no_lane_is_open_until_panic() -> None:
    assert settled(CALM, ON_BOTH_LANES) == 0
    anxious = Teacher(delay=4.0, delay_spread=0.0, misjudgement=0.0, panic_distance=4.5)
    assert settled(anxious, ON_BOTH_LANES) != 0


@pytest.mark.parametrize(("distance", "key"), [(2.9, 0), (3.3, 2)])
def test_late_and_early_passers(distance: float, key: int) -> None:
    takers = np.array([[3.2, 0.0], [-12.0, -8.0]])
    teacher = Teacher(pass_distance=distance, misjudgement=0.0, panic_distance=0.5)
    assert settled(teacher, takers) == key


def test_a_team_mate_wide_open_gets_the_ball_at_once() -> None:
    assert settled(Teacher(wide_open=100.0, misjudgement=0.0), FAR) != 0
    assert settled(Teacher(wide_open=400.0, misjudgement=0.0), FAR) == 0


def test_preference_for_far_or_near_team_mates() -> None:
    for bonus, key in ((200.0, 2), (-200.0, 1)):
        assert settled(Teacher(far_bonus=bonus, misjudgement=0.0), NEAR_BEHIND) == key


def test_limited_teacher_never_passes_to_the_farther_one() -> None:
    limited = CALM.limited()
    assert settled(limited, ON_NEAR_LANE) == 0  # the only lane allowed is closed
    assert settled(limited, NEAR_BEHIND) == 1


# --- reaction ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("delay", [0, 1, 4, 20, MAX_DELAY])
def test_reaction_time(delay: int) -> None:
    teacher = ScriptedTeacher(Teacher(delay=delay, delay_spread=0.0, anticipation=0.0, misjudgement=0.0), 0)
    assert not any(keys(teacher, FAR, range(100)))
    answers = keys(teacher, ON_NEAR_LANE, range(100, 200))
    assert answers == [0] * delay + [2] * (100 - delay)


def test_nothing_is_pressed_before_the_first_picture_has_sunk_in() -> None:
    assert keys(ScriptedTeacher(CALM, 0), ON_NEAR_LANE, range(6)) == [0, 0, 0, 0, 2, 2]


def test_the_receiver_of_a_pass_is_known_but_not_what_has_happened_around_him_since() -> None:
    teacher = ScriptedTeacher(CALM, 0)
    keys(teacher, ON_NEAR_LANE, range(10))
    takers = np.array([[10.0, 3.0], [-12.0, -8.0]])
    on_its_way = [teacher(10 + k, np.array([2.0 + 2.0 * k, 0.0]), KEEPERS, takers) for k in range(3)]
    received = [teacher(13 + k, np.array([9.6, 0.0]), KEEPERS, takers) for k in range(10)]
    assert on_its_way == [2, 2, 2]  # the hand is still busy with what it saw before
    assert received[0] == 0  # four cycles ago nobody was near the receiver
    assert all(received[1:])


@pytest.mark.parametrize("delay", [2, 5, 8])
def test_anticipation_makes_up_for_the_reaction_time(delay: int) -> None:
    """Against a taker who runs straight, one who anticipates fully reacts as if at once."""

    def first_key(anticipation: float) -> int:
        habits = Teacher(
            delay=delay, delay_spread=0.0, anticipation=anticipation, misjudgement=0.0, pass_distance=4.0, open=0.0
        )
        teacher = ScriptedTeacher(habits, 0)
        pressed = []
        for cycle in range(60):
            takers = np.array([[-20.0 + 0.5 * cycle, 0.1], [-12.0, -8.0]])
            pressed.append(teacher(cycle, BALL, KEEPERS, takers))
        return next(cycle for cycle, key in enumerate(pressed) if key)

    assert first_key(1.0) == 33  # the first cycle in which he is nearer than 4 m
    assert first_key(0.0) == 33 + delay
    assert 33 < first_key(0.5) < 33 + delay


def test_reaction_times_differ_between_possessions() -> None:
    habits = Teacher(delay=5.0, delay_spread=2.0, misjudgement=0.0)
    delays = {keys(ScriptedTeacher(habits, seed), ON_NEAR_LANE, range(20)).index(2) for seed in range(60)}
    assert delays == {3, 4, 5, 6, 7}


def test_fast_simulator_multiplies_the_reaction_time() -> None:
    fast = CALM.fast()
    assert fast.delay == 20.0
    assert keys(ScriptedTeacher(fast, 0), ON_NEAR_LANE, range(40)).index(2) == 20


def test_a_cycle_shown_twice_counts_once() -> None:
    one, two = ScriptedTeacher("C", 3), ScriptedTeacher("C", 3)
    for cycle in range(40):
        key = one(cycle, BALL, KEEPERS, ON_NEAR_LANE)
        assert two(cycle, BALL, KEEPERS, ON_NEAR_LANE) == key
        assert two(cycle, BALL, KEEPERS, FAR) == key
    assert one.memory.tobytes() == two.memory.tobytes()


def test_new_episode_forgets_the_old_pictures() -> None:
    teacher = ScriptedTeacher(CALM, 0)
    assert keys(teacher, ON_NEAR_LANE, range(20))[-1] == 2
    teacher.new_episode()
    assert keys(teacher, FAR, range(20, 30)) == [0] * 10


# --- human error ------------------------------------------------------------------------------------------------


def test_slip_presses_another_key() -> None:
    clumsy = Teacher(misjudgement=0.0, slip=1.0)
    assert settled(clumsy, ON_NEAR_LANE) == 1
    assert settled(clumsy.limited(), NEAR_BEHIND) == 1  # there is only one key to press
    five = np.array([[0.0, 0.0], [6.0, 0.0], [0.0, 7.0], [0.0, -8.0], [9.0, 9.0]])
    right = settled(Teacher(misjudgement=0.0), np.array([[3.0, 0.0], [-9.0, 0.0]]), five)
    wrong = {settled(clumsy, np.array([[3.0, 0.0], [-9.0, 0.0]]), five, seed) for seed in range(60)}
    assert wrong == {1, 2, 3, 4} - {right}


def test_lapse_delays_the_key() -> None:
    dreamy = Teacher(delay=4.0, delay_spread=0.0, anticipation=0.0, misjudgement=0.0, lapse=1.0, lapse_cycles=12.0)
    first = []
    for seed in range(100):
        teacher = ScriptedTeacher(dreamy, seed)
        for cycle in range(20):
            teacher(cycle, KEEPERS[1], KEEPERS, FAR)
        first.append(keys(teacher, ON_NEAR_LANE, range(20, 60)).index(2))
    assert (min(first), max(first)) == (4, 12)


def test_who_is_not_ready_when_play_begins_is_so_later() -> None:
    sleepy = Teacher(delay=4.0, delay_spread=0.0, misjudgement=0.0, unready=1.0, lapse_cycles=12.0)
    first, second = set(), set()
    for seed in range(100):
        teacher = ScriptedTeacher(sleepy, seed)
        first.add(keys(teacher, ON_NEAR_LANE, range(40)).index(2))
        teacher(40, KEEPERS[1], KEEPERS, ON_NEAR_LANE)
        second.add(keys(teacher, ON_NEAR_LANE, range(41, 60)).index(2))
    assert (min(first), max(first)) == (4, 12)
    assert len(second) == 1  # in the next possession he attends


def test_misjudgement_varies_between_but_not_within_possessions() -> None:
    habits = Teacher(delay=2.0, delay_spread=0.0, pass_distance=4.0, panic_distance=0.0, misjudgement=0.2)
    outcomes = []
    for seed in range(200):
        pressed = keys(ScriptedTeacher(habits, seed), ON_NEAR_LANE, range(30))[2:]
        assert len(set(pressed)) == 1
        outcomes.append(pressed[0] != 0)
    # The taker stands exactly at the pass distance: judged nearer or farther equally often
    assert 0.35 < np.mean(outcomes) < 0.65


@given(st.sampled_from(sorted(STYLES)), st.integers(0, 10**6), st.sampled_from([(3, 2), (4, 3), (5, 4)]))
def test_keys_are_legal_and_seeded(name: str, seed: int, size: tuple[int, int]) -> None:
    n, m = size
    draw = np.random.default_rng(seed)
    keepers, takers = draw.uniform(-10, 10, (40, n, 2)), draw.uniform(-10, 10, (40, m, 2))
    keepers[1:] = keepers[0] + draw.normal(0, 0.2, (39, n, 2))
    balls = keepers[:, seed % n] + draw.uniform(-0.9, 0.9, (40, 2))
    runs = []
    for _ in range(2):
        teacher = ScriptedTeacher(name, seed)
        runs.append([teacher(cycle, balls[cycle], keepers[cycle], takers[cycle]) for cycle in range(40)])
    assert runs[0] == runs[1]
    assert set(runs[0]) <= set(range(2 if name == "B-limited" else n))


def _angle(u: np.ndarray, v: np.ndarray) -> float:
    return math.degrees(math.acos(np.clip(u @ v / (np.linalg.norm(u) * np.linalg.norm(v)), -1.0, 1.0)))


@given(st.integers(0, 10**6), st.sampled_from([(3, 2), (5, 4)]))
def test_best_lane_is_chosen(seed: int, size: tuple[int, int]) -> None:
    """Against the definition, one team mate after the other."""
    n, m = size
    draw = np.random.default_rng(seed)
    keepers, takers = draw.uniform(-10, 10, (n, 2)), draw.uniform(-10, 10, (m, 2))
    habits = Teacher(delay=0.0, delay_spread=0.0, misjudgement=0.0, panic_distance=100.0, far_bonus=5.0)
    teacher = ScriptedTeacher(habits, 0)
    key = teacher(1, keepers[0], keepers, takers)
    worths = {}
    mates = sorted(range(1, n), key=lambda i: math.dist(keepers[i], keepers[0]))
    for rank, i in enumerate(mates, start=1):
        lanes = [_angle(keepers[i] - keepers[0], taker - keepers[0]) for taker in takers]
        worths[rank] = min(lanes) + 4.0 * min(math.dist(keepers[i], t) for t in takers) + 5.0 * (rank > 1)
    assert worths[key] == pytest.approx(max(worths.values()))


# --- the rest ---------------------------------------------------------------------------------------------------


def test_styles_differ_as_described() -> None:
    a, b, c = STYLES["A"], STYLES["B"], STYLES["C"]
    assert a.pass_distance < b.pass_distance
    assert c.far_bonus < a.far_bonus < b.far_bonus
    assert c.misjudgement > max(a.misjudgement, b.misjudgement)
    assert c.slip > max(a.slip, b.slip)
    assert STYLES["B-fast"] == b.fast(5.0)
    assert STYLES["B-limited"] == b.limited()


def test_style_by_name() -> None:
    assert style("b-Fast") is STYLES["B-fast"]
    with pytest.raises(ValueError, match="there is no scripted teacher 'D'; known are A, B, C, B-fast, B-limited"):
        style("D")


@pytest.mark.parametrize(
    ("habits", "message"),
    [
        ({"delay": 1.0, "delay_spread": 2.0}, "delay - delay_spread must be 0 or more"),
        ({"delay": 61.0}, "at most 61 cycles, not 61 and 1"),
        ({"slip": 1.5}, "slip is a probability from 0 to 1, not 1.5"),
        ({"lapse": -0.1}, "lapse is a probability"),
        ({"open": -1.0}, "open must be 0 or more, not -1"),
        ({"anticipation": 1.5}, "anticipation is a share from 0 to 1, not 1.5"),
        ({"max_action": 0}, r"max_action must be 1 \(Hold and PASS1\) to 10, not 0"),
    ],
)
def test_impossible_habits_are_errors(habits: dict[str, float], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Teacher(**habits)  # type: ignore[arg-type]


def test_kernel_is_compiled_once_for_all_teachers_and_sizes() -> None:
    for name in STYLES:
        settled(style(name), ON_NEAR_LANE)
    signatures = getattr(teach, "signatures", None)
    if signatures is not None:
        assert len(signatures) == 1
