"""A wrapper that writes the game log (``.rcg``) of what is played in the arena, as a server would."""

from __future__ import annotations

from pathlib import Path
from typing import Any, BinaryIO

import gymnasium
import numpy as np
from numpy.typing import NDArray

from rcss_hat.envs.keepaway_env import KeepawayEnv, Observation
from rcss_hat.keepaway.task import Task
from rcss_hat.protocol.digits import ascii_bytes
from rcss_hat.protocol.messages import PlayerType, PlayMode, ServerParam, Team
from rcss_hat.protocol.messages.show import MAX_SHOW, write_show
from rcss_hat.protocol.params import SERVER_PARAMETERS
from rcss_hat.protocol.play_modes import PLAY_MODES
from rcss_hat.simulation.clock import view_angle
from rcss_hat.simulation.player_types import PLAYER_TYPE
from rcss_hat.simulation.state import F_STAND, N_PLAYERS
from rcss_hat.simulation.world import World
from rcss_hat.stage.place import ARENA

VERSION = 5
"""Of the log."""
_NO_HEAD = ascii_bytes("")


class GameLog:
    """One match as text of version 5: `rcss-hat watch`, rcssmonitor and rcsslogplayer show it.

    Parameters
    ----------
    path : Path
    task : Task
    """

    def __init__(self, path: Path, task: Task) -> None:
        self._file: BinaryIO = path.open("wb")
        self._task, self._buffer = task, np.zeros(MAX_SHOW, dtype=np.uint8)
        self._begun = False

    def show(self, match: NDArray[np.void], world: World) -> None:
        """Write a cycle: a record of MATCH, and what does not change."""
        if not self._begun:
            self._begin(match, world)
        flags = np.where(match["enabled"][0] != 0, match["flags"][0] | F_STAND, 0).astype(np.int64)
        angles = np.array([view_angle(match, world.params, i) for i in range(N_PLAYERS)])
        size = write_show(match, flags, angles, VERSION - 1, _NO_HEAD, self._buffer)
        self._file.write(self._buffer[:size].tobytes() + b"\n")

    def _begin(self, match: NDArray[np.void], world: World) -> None:
        params, time = self._task.params(), int(match["time"][0])
        head = [f"ULG{VERSION}", ServerParam(values={p.name: params[p.name] for p in SERVER_PARAMETERS}).to_text()]
        for k, kind in enumerate(world.types):
            values = {"id": k, **{name: float(kind[name]) for name in PLAYER_TYPE.names or ()}}
            head.append(PlayerType(id=k, values=values).to_text())
        head.append(PlayMode(time=time, mode=PLAY_MODES[int(match["mode"][0])]).to_text())
        team = Team(left="keepers", right="takers", left_score=0, right_score=0, time=time)
        self._file.write("\n".join([*head, team.to_text(), ""]).encode())
        self._begun = True

    def close(self) -> None:
        """Put the file down."""
        self._file.close()


class RecordGameLog(gymnasium.Wrapper[Observation, np.int64, Observation, np.int64]):
    """Writes the game log of every match that begins: ``x.rcg``, of further ones ``x-2.rcg`` and so on.

    Parameters
    ----------
    env : gymnasium.Env
        A `KeepawayEnv` in the arena, wrapped or not, which has not been reset yet.
    path : str or Path

    Raises
    ------
    ValueError
        For another environment: servers write their game logs themselves (``server::game_logging=1``).
    """

    def __init__(self, env: Any, path: str | Path) -> None:
        super().__init__(env)
        inner = env.unwrapped
        if not isinstance(inner, KeepawayEnv) or inner.setting.place.name != ARENA:
            raise ValueError("a game log is written of a KeepawayEnv in the arena; servers write their own")
        self._task, self._path, self._matches = inner.options.task, Path(path), 0
        self._log: GameLog | None = None
        self._time = -1
        inner.watch(self._seen)

    def _seen(self, match: NDArray[np.void], world: World) -> None:
        time = int(match["time"][0])
        if self._log is None or time <= self._time:
            self._put_down()
            self._matches += 1
            stem = self._path.stem if self._matches == 1 else f"{self._path.stem}-{self._matches}"
            self._log = GameLog(self._path.with_stem(stem), self._task)
        self._time = time
        self._log.show(match, world)

    def _put_down(self) -> None:
        if self._log is not None:
            self._log.close()
            self._log = None

    def close(self) -> None:
        """Put the file down, and close the environment."""
        self._put_down()
        super().close()
