"""Every recorded game is played again, decision for decision, in the arena and over UDP."""

from __future__ import annotations

import platform
import sys

import pytest
from recorded_games import GAMES, Game, in_arena, over_udp, recorded

pytestmark = [
    pytest.mark.compiled,
    pytest.mark.skipif(
        sys.platform != "linux" or platform.machine() != "x86_64",
        reason="the last bit of exp and atan2 is the C library's; the digests are of Linux on x86-64",
    ),
]
OVER_UDP = [game for game in GAMES if game.policy == "random" and game.vision == 360] + [
    game for game in GAMES if (game.size, game.profile) == ("3v2", "19.0") and game.policy in ("hand", "rules", "ppr")
]
"""A part; ``python tests/stage/recorded_games.py --udp`` plays all."""


@pytest.mark.parametrize("game", GAMES, ids=lambda game: game.name)
def test_the_arena_plays_the_recorded_game(game: Game) -> None:
    assert in_arena(game) == recorded()[game.name]


@pytest.mark.slow
@pytest.mark.parametrize("game", OVER_UDP, ids=lambda game: game.name)
def test_the_recorded_game_is_played_over_udp(game: Game) -> None:
    assert over_udp(game) == recorded()[game.name]["first"]
