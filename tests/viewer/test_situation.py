from __future__ import annotations

import math

import pytest

from rcss_hat.keepaway.decision import Decision, overheard
from rcss_hat.viewer.frames import Setup
from rcss_hat.viewer.narrator import Insight, Narrator, choices, make_frame
from rcss_hat.viewer.situation import around, arrow_keys, believed_mates, situation, state_variables

from .audience import SETUP, player, snapshot

PLACES = {"l1": (0.0, 0.0), "l2": (3.0, 4.0), "l3": (-6.0, 8.0), "r1": (0.0, 2.0), "r2": (4.0, 3.0)}


def test_state_variables_in_the_players_order() -> None:
    here = situation(snapshot(1, (0.5, 0.0), **PLACES), SETUP)
    assert [p.id for p in here.keepers] == ["l1", "l2", "l3"]
    assert [p.id for p in here.takers] == ["r1", "r2"]
    assert here.holder is not None and here.holder.id == "l1"
    angle_k2 = math.degrees(math.atan2(4, 3) - math.atan2(3, 4))
    angle_k3 = math.degrees(math.atan2(8, -6)) - 90.0
    want = [0, 5, 10, 2, 5, 5, 10, 2, 5, math.sqrt(2), math.hypot(6, 6), angle_k2, angle_k3]
    assert state_variables(here) == pytest.approx(want)


def test_the_angle_is_the_smaller_one_across_the_turn() -> None:
    places = {"l1": (0.0, 0.0), "l2": (-5.0, 0.1), "r1": (-5.0, -0.1)}
    state = state_variables(situation(snapshot(1, (0.0, 0.0), **places), SETUP))
    assert state is not None and state[-1] == pytest.approx(2 * math.degrees(math.atan2(0.1, 5.0)))


@pytest.mark.parametrize("places", [{}, {"l1": (0.0, 0.0)}, {"r1": (0.0, 0.0)}, {"l1": (0.0, 0.0), "r1": (1.0, 0.0)}])
def test_without_a_team_mate_or_a_taker_there_is_no_state(places: dict[str, tuple[float, float]]) -> None:
    assert state_variables(situation(snapshot(1, (0.0, 0.0), **places), SETUP)) is None


def test_a_keeper_in_reach_holds_before_a_nearer_taker() -> None:
    def holder(ball: tuple[float, float]) -> str | None:
        found = situation(snapshot(1, ball, l1=(0.0, 0.0), l2=(9.0, 9.0), r1=(2.0, 0.0)), SETUP).holder
        return found.id if found else None

    assert holder((1.05, 0.0)) == "l1"
    assert holder((1.5, 0.0)) == "r1"
    assert holder((-1.085, 0.0)) is None


def test_arrows_point_to_team_mates_one_each() -> None:
    def arrows(**mates: tuple[float, float]) -> dict[str, str]:
        me = player("l1", 0.0, 0.0)
        return arrow_keys(around(me, [me, *(player(name, *place) for name, place in mates.items())], None))

    assert arrows(l2=(9.0, 0.0), l3=(0.0, 9.0)) == {"l2": "ArrowRight", "l3": "ArrowDown"}
    assert arrows(l2=(-9.0, 1.0), l3=(1.0, -9.0)) == {"l2": "ArrowLeft", "l3": "ArrowUp"}
    # Both to the right: the one that is more to the right keeps that arrow.
    assert arrows(l2=(9.0, 1.0), l3=(9.0, 6.0)) == {"l2": "ArrowRight", "l3": "ArrowDown"}
    assert arrows(l2=(9.0, 0.0), l3=(9.0, 0.5)) == {"l2": "ArrowRight"}


def test_believed_order_follows_the_keepers_own_view() -> None:
    me, mates = player("l1", 0.0, 0.0), (player("l2", 6.0, 0.0), player("l3", 0.0, 6.1))
    takers = (player("r1", 3.0, 1.0), player("r2", 8.0, -2.0))
    here = around(me, [me, *mates, *takers], None)
    assert [p.id for p in here.mates] == ["l2", "l3"]
    true = state_variables(here)
    assert true is not None
    assert believed_mates(here, true) == ["l2", "l3"]
    # The keeper takes l2 for half a metre farther than it is, so that l3 is the first for it.
    nearer = around(me, [me, player("l2", 6.5, 0.0), mates[1], *takers], None)
    believed = state_variables(nearer)
    assert believed is not None and [p.id for p in nearer.mates] == ["l3", "l2"]
    assert believed_mates(here, believed) == ["l3", "l2"]
    # A state of another task says nothing.
    assert believed_mates(here, believed[:-1]) == ["l2", "l3"]
    shown = choices(here, Decision(3, 1, tuple(believed), 0))
    assert [(c["action"], c["name"], c["mate"]) for c in shown] == [(1, "PASS1", "l3"), (2, "PASS2", "l2")]


def test_a_frame_tells_true_positions_unless_the_keeper_is_known() -> None:
    shot = snapshot(10, (0.5, 0.0), **PLACES)
    frame = make_frame(shot, SETUP, 3, 4)
    assert (frame["holder"], frame["keepers"], frame["takers"]) == ("l1", ["l1", "l2", "l3"], ["r1", "r2"])
    assert (frame["episode"], frame["start"], frame["seen"], frame["action"]) == (3, 4, False, None)
    assert frame["state"] is not None and frame["state"][1] == 5.0 and frame["values"] is None
    own = tuple(float(k) for k in range(13))
    insight = Insight(values=lambda keeper, state: [keeper, sum(state), 0.0])
    insight.decided(Decision(9, 1, tuple(own), 2))
    known = make_frame(shot, SETUP, 3, 4, insight.thought, insight.values)
    assert (known["seen"], known["action"], known["state"]) == (True, 2, list(own))
    assert known["values"] == [1.0, 78.0, 0.0]


def test_an_old_thought_is_not_shown() -> None:
    insight = Insight()
    insight.decided(Decision(9, 1, (1.0,), 0))
    assert insight.thought(1, 8) is None
    assert insight.thought(1, 9) is not None
    assert insight.thought(1, 12) is None
    assert insight.thought(2, 9) is None


def test_insight_notes_the_decisions_of_a_policy_and_changes_none() -> None:
    import numpy as np

    ended = object()

    def policy(number: int):  # type: ignore[no-untyped-def]
        return (lambda cycle, status, reward, state: number + 1), ended

    insight = Insight()
    decide, after = overheard(policy, insight.decided)(1)
    assert after is ended
    assert decide(5, 1, 1.0, np.array([1.0, 2.0])) == 2
    thought = insight.thought(2, 5)
    assert thought == Decision(5, 2, (1.0, 2.0), 2)


def test_an_ordinary_match_has_a_holder_and_nothing_of_keepaway() -> None:
    setup = Setup("match", keepaway=False, length=105.0, width=68.0)
    frame, ended = Narrator(setup).tell(snapshot(1, (0.5, 0.0), **PLACES))
    assert frame["holder"] == "l1" and ended is None
    assert frame["keepers"] is None and frame["state"] is None and frame["choices"] == []
