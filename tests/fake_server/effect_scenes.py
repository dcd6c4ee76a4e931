"""Short scripted matches in which every parameter of the game has something to change."""

from __future__ import annotations

import hashlib
from collections.abc import Callable

import numpy as np

from fake_server.apply import apply
from fake_server.game import Game
from fake_server.options import ServerOptions
from fake_server.player_param import PlayerParams
from rcss_hat.protocol import commands as said
from rcss_hat.protocol.landmarks import N_LANDMARKS
from rcss_hat.protocol.params import ServerParams, Value
from rcss_hat.protocol.records import SEE, SENSE_BODY, empty
from rcss_hat.simulation import body, clock, hearing, vision
from rcss_hat.simulation.state import (
    FREE_KICK_LEFT,
    KICK_OFF_LEFT,
    MAX_MESSAGES,
    N_PLAYERS,
    PLAY_ON,
)

LEFT_GOALIE, LEFT, LEFT_TOO, RIGHT_GOALIE, RIGHT, RIGHT_TOO = PLAYERS = (0, 1, 2, 11, 12, 13)
NOTHING: dict[str, Value] = {}


class Scene:
    """A match of three against three, whose every bit goes into a digest.

    Parameters
    ----------
    server, player : dict
        Parameters that are not the default.
    version : int
        Protocol version of the players; from 18 on they see in step with the simulation.
    """

    def __init__(self, server: dict[str, Value], player: dict[str, Value] = NOTHING, version: int = 17) -> None:
        params = ServerParams(**server)
        self.game = Game(ServerOptions(params=params, player_params=PlayerParams(**player)), seed=1)
        self._hash = hashlib.sha256(self.game.types.tobytes())
        for k in range(6):
            self.game.join("AAABBB"[k], version, goalie=k % 3 == 0)
        self.match = self.game.match
        self._see, self._sense = empty(SEE), empty(SENSE_BODY)
        self._due = np.zeros(N_PLAYERS, dtype=np.uint8)
        self._landmarks = np.arange(N_LANDMARKS, dtype=np.uint8)

    def command(self, i: int, line: str) -> None:
        """Let a player command something."""
        for command in said.parse_commands(line.encode() + b"\0", self.game.params.profile)[0]:
            accepted = apply(self.game, self.game.world, i, command)
            self._note(accepted)
            if accepted and isinstance(command, said.Kick) and self.game.touch is not None:
                self.game.touch.touched(i, 1.0)

    def step(self) -> None:
        """Simulate a step, and let everybody perceive."""
        game = self.game
        self._note(game.step())
        clock.sees_before_think(self.match, game.kernel, self._due)
        self._note(self._due.tobytes())
        clock.sees_after_think(self.match, game.kernel, self._due)
        self._note(self._due.tobytes())
        for i in PLAYERS:
            vision.see(self.game.world, i, self._landmarks, True, self._see)
            self._note(self._see.tobytes())
            body.sense_body(self.game.world, i, self._sense)
            self._note(self._sense.tobytes())
            if self.match["n_heard"][0]:
                order = np.zeros((MAX_MESSAGES, 2), dtype=np.int32)
                n = hearing.deliver(self.game.world, i, order)
                self._note(order[:n].tobytes())
        self._note(self.match.tobytes())

    def _note(self, what: object) -> None:
        self._hash.update(what if isinstance(what, bytes) else repr(what).encode())

    def digest(self) -> str:
        """Return what has happened, as a number."""
        return self._hash.hexdigest()


def place(scene: Scene, *places: tuple[int, float, float, float]) -> None:
    """Put players somewhere: index, x, y, angle."""
    for i, x, y, angle in places:
        scene.game.move_player(i, x, y, angle, (0.0, 0.0))


def bodies(scene: Scene) -> None:
    """Dashes of all kinds, turns, necks, arms, fatigue, collisions."""
    place(scene, (LEFT, -10, 0, 0), (LEFT_TOO, -10, 20, 0), (RIGHT, 10, -20, 180), (RIGHT_TOO, 5, -30, 90))
    scene.game.change_mode(PLAY_ON)
    scene.match["stamina"][0, RIGHT_TOO] = 2500.0
    for cycle in range(40):
        scene.command(LEFT, f"(dash 150 {cycle * 11.3 - 200:.1f})")
        scene.command(LEFT_TOO, f"(dash {-150 if cycle % 2 else 40})(turn_neck {cycle * 30 - 300})")
        scene.command(RIGHT_TOO, "(dash 100)" if cycle < 25 else "(turn 0)")
        scene.command(RIGHT, f"(turn {cycle * 20 - 250})" if cycle % 3 else "(dash 60)")
        if cycle % 6 == 0:
            scene.command(RIGHT, f"(pointto {cycle} 40)")
        if cycle == 30:
            scene.match["stamina"][0, RIGHT_TOO] = 7000.0
        scene.step()


def _near(scene: Scene, i: int, distance: float, speed: float = 0.0, aside: float = 0.0) -> None:
    """Put the ball in front of a player."""
    x, y = scene.match["pos"][0, i]
    cos, sin = np.cos(scene.match["body"][0, i]), np.sin(scene.match["body"][0, i])
    place = (x + distance * cos - aside * sin, y + distance * sin + aside * cos)
    scene.game.move_ball(*place, (speed, 0.3 * speed))


def balls(scene: Scene) -> None:
    """Kicks, tackles and fouls, a ball that runs into a player and into a post."""
    place(scene, (LEFT, -10, 0, 30), (RIGHT, 10, -20, 140), (RIGHT_TOO, 20, 20, 0))
    scene.game.change_mode(PLAY_ON)
    for cycle in range(36):
        if cycle % 9 == 0:
            _near(scene, LEFT, 0.75)
            scene.command(LEFT, f"(kick {20 * cycle - 100} {cycle * 17})")
        elif cycle % 9 == 2:
            _near(scene, RIGHT, 1.1 if cycle < 20 else -0.3, aside=0.5)
            scene.command(RIGHT, f"(tackle {70 if cycle < 12 else -70 if cycle < 20 else 250})")
        elif cycle % 9 == 6:
            _near(scene, RIGHT_TOO, -1.0, 3.5)
        scene.step()
    place(scene, (LEFT, 0, 0, 0), (RIGHT, 1.8, 0.5, 180))
    _near(scene, LEFT, 0.7)
    scene.command(RIGHT, "(tackle 60 on)")
    scene.step()
    for x, y in ((52.4, 7.0), (52.4, 7.2)):
        scene.game.move_ball(x, y, (0.9, 0.02))
        scene.step()


def catches(scene: Scene) -> None:
    """A goalie reaches to all sides, and moves with the ball."""
    for cycle, angle in enumerate((-60, -20, 20, 60, 100, 0, 0)):
        scene.game.change_mode(PLAY_ON)
        place(scene, (LEFT_GOALIE, -45, 3, 0))
        scene.match["catch_ban"][0, LEFT_GOALIE] = 0
        reach = 0.6 + 0.1 * cycle if angle > 0 else 1.1
        x, y = reach * np.cos(np.deg2rad(angle)), reach * np.sin(np.deg2rad(angle))
        scene.game.move_ball(-45 + x, 3 + y + 0.3, (0.0, 0.0))
        scene.command(LEFT_GOALIE, f"(catch {angle})")
        scene.step()
        for k in range(3):
            scene.command(LEFT_GOALIE, f"(move {-40 + k} 5)")
            scene.step()
        scene.command(LEFT_GOALIE, f"(catch {angle})")
        scene.step()


def words(scene: Scene) -> None:
    """Messages near and far, from one and from several, and views."""
    place(scene, (LEFT, 0, 0, 0), (LEFT_TOO, 5, 0, 90), (RIGHT, 2, 1, 180))
    place(scene, (RIGHT_TOO, 45, 30, 0), (RIGHT_GOALIE, 30, 0, 0))
    scene.game.change_mode(PLAY_ON)
    scene.command(LEFT_GOALIE, "(change_view narrow)(change_focus 5 10)(gaussian_see)")
    scene.command(LEFT, "(gaussian_see)")
    for cycle in range(14):
        for i in PLAYERS:
            if (cycle + i) % 3:
                scene.command(i, '(say "0123456789")')
        scene.step()


def stoppages(scene: Scene) -> None:
    """Players in the others' half before the match, set plays that nobody takes, a ball at rest."""
    place(scene, (LEFT, 10, 0, 0), (RIGHT, -12, 5, 0), (RIGHT_TOO, 3, 0, 0))
    for _ in range(3):
        scene.step()
    scene.game.change_mode(KICK_OFF_LEFT)
    for _ in range(4):
        scene.step()
    scene.game.change_mode(FREE_KICK_LEFT)
    for _ in range(110):
        scene.step()
    place(scene, (LEFT, 12, 10, 0), (RIGHT, 14, 10, 0))
    scene.game.change_mode(PLAY_ON)
    scene.game.move_ball(13, 10, (0.0, 0.0))
    for _ in range(110):
        scene.step()


def corners(scene: Scene) -> None:
    """The ball leaves the field everywhere."""
    for x, y, angle in ((51.0, 20.0, 0), (51.0, 7.05, 0), (-51.0, 20.0, 180), (10.0, 32.5, 90)):
        scene.game.change_mode(PLAY_ON)
        place(scene, (LEFT, x, y, angle))
        _near(scene, LEFT, 0.7)
        scene.command(LEFT, "(kick 100 0)")
        for _ in range(40 if x < 0.0 else 12):
            scene.step()


def halves(scene: Scene) -> None:
    """The end of every half of a drawn match, and of an extra half that somebody leads."""
    for time in (2999, 5999, 6999, 7200, 7999, 8999):
        if scene.game.mode != PLAY_ON:
            scene.game.change_mode(PLAY_ON)
        scene.match["time"] = time
        for _ in range(4):
            scene.step()
        if time == 6999:
            scene.match["score"] = 1, 0


def keepers(scene: Scene) -> None:
    """Keepaway: the takers come, the ball leaves."""
    scene.game.kick_off()
    for cycle in range(30):
        scene.command(LEFT, "(dash 60)")
        scene.command(RIGHT, "(dash 100)")
        if cycle == 12:
            scene.game.move_ball(9.9, 0.0, (1.0, 0.0))
        scene.step()


SCENES: dict[str, Callable[[Scene], None]] = {
    scene.__name__: scene for scene in (bodies, balls, catches, words, stoppages, corners, halves, keepers)
}


def digest_of(scene: str, server: dict[str, Value] = NOTHING, player: dict[str, Value] = NOTHING) -> str:
    """Play a scene with parameters; returns its digest."""
    fixed: dict[str, Value] = {"keepaway": True} if scene == "keepers" else {}
    played = Scene(fixed | server, {"random_seed": 7} | player, 19 if scene == "words" else 17)
    SCENES[scene](played)
    return played.digest()
