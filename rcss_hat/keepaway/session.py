"""One Keepaway player, sans-IO: datagrams in, datagrams out.

In synch mode the server says ``(think)`` once per cycle and the player answers with its commands and ``(done)``. In
real time there is no such sign: the player decides when the see of the cycle has come, or when a part of the cycle
has gone by without one; the caller keeps the time and calls `deadline`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rcss_hat.keepaway import agent as kernels
from rcss_hat.keepaway.decision import Decide, EpisodeEnd
from rcss_hat.keepaway.state import n_state_variables
from rcss_hat.player.limits import check_limits
from rcss_hat.protocol import messages
from rcss_hat.protocol.commands import action_to_bytes
from rcss_hat.protocol.errors import RemoteProtocolError
from rcss_hat.protocol.hear import HEARD_OTHER, HEARD_REFEREE, parse_hear_fast
from rcss_hat.protocol.params import ServerParams
from rcss_hat.protocol.records import ACTION, HEARD, LEFT, RIGHT, SEE, SENSE_BODY, empty
from rcss_hat.protocol.see import parse_see
from rcss_hat.protocol.sense_body import parse_sense_body
from rcss_hat.protocol.warm_up import warm_up

DONE = b"(done)\0"
EPISODE_END = "training Keepaway 1"
WAIT_FOR_SEE, ON_THE_WAY = 0.75, 0.008
"""Part of a real-time cycle after which a player no longer waits for a see message; seconds of the cycle that must be
left then for the commands to come in time, but not more than half of it."""


class KeepawayPlayer:
    """A keeper or taker that reads server messages and gives commands.

    Parameters
    ----------
    team : str
        Team name; decides who is a team mate.
    n_keepers, n_takers : int
    seed : int
        Of the whole match; the player's own stream is drawn from it, its side and its number.
    decide : callable
        The policy; not called for takers.
    episode_ended : callable, optional
        Called once per episode end, before the first decision that follows it.
    hold_cycles : int
        Cycles from a keeper's Hold to his next decision.

    Attributes
    ----------
    episodes : list of (int, bool)
        Cycle of every episode end heard, and whether this player's own view of the last cycles says "taken".
    first_cycle : int
        When the match, or this player's part in it, began.
    missed : int
        Real time: cycles in which no command could be sent in time.
    """

    def __init__(
        self,
        team: str,
        n_keepers: int,
        n_takers: int,
        seed: int,
        decide: Decide,
        episode_ended: EpisodeEnd | None = None,
        hold_cycles: int = 1,
    ) -> None:
        self.team = team
        self.n_keepers, self.n_takers, self.seed = n_keepers, n_takers, seed
        self.decide, self.episode_ended, self.hold_cycles = decide, episode_ended, hold_cycles
        self.params = ServerParams()
        self.side, self.unum, self.mode = 0, 0, ""
        self.cycle, self.first_cycle, self.missed = 0, 0, 0
        self.synch = False
        self.playing = False
        self.episodes: list[tuple[int, bool]] = []
        self.unknown: list[bytes] = []
        self._team = team.encode()
        self._record = self.params.record()
        self._sense, self._see, self._heard, self._action = empty(SENSE_BODY), empty(SEE), empty(HEARD), empty(ACTION)
        self._heard["time"][0] = -1
        self._agent: NDArray[np.void] | None = None
        self._state = np.zeros(n_state_variables(n_keepers, n_takers))
        self._has_see = self._has_sense = self._episode_started = self._acted = False

    @property
    def name(self) -> str:
        """Who this is, for messages."""
        return f"{self.team} {self.unum}" if self.unum else self.team

    # -- before the match ---------------------------------------------------------------------------------------------
    def initialised(self, event: messages.Event) -> None:
        """Take the reply to ``(init ...)``.

        Raises
        ------
        RemoteProtocolError
            When the server refused.
        """
        if isinstance(event, messages.Error):
            raise RemoteProtocolError(f"the server refuses {self.team!r}: {event.text}")
        if not isinstance(event, messages.Init):
            raise RemoteProtocolError(f"expected the reply to init, received {event!r}")
        self.side = LEFT if event.side == "l" else RIGHT
        self.unum, self.mode = event.unum, event.mode
        self.playing = self._episode_started = event.mode == "play_on"

    def _take_params(self, params: ServerParams) -> None:
        check_limits(params)
        self.params = params
        self._record = params.record()
        self.synch = bool(params["synch_mode"])

    def prepare(self) -> None:
        """Compile and run every kernel once, before a server waits for an answer."""
        agent = kernels.new_agent(LEFT, 1, self.n_keepers, self.n_takers, self._record, 0)
        self._heard["time"][0] = -1
        kernels.perceive(agent, self._record, self._sense, self._see, True, self._heard, True)
        kernels.decide(agent, self._record, self._state)
        kernels.act(agent, self._record, 0, self._action)
        taker = kernels.new_agent(RIGHT, 1, self.n_keepers, self.n_takers, self._record, 0)
        kernels.perceive(taker, self._record, self._sense, self._see, True, self._heard, True)
        kernels.act(taker, self._record, 0, self._action)
        action_to_bytes(self._action)
        warm_up()

    # -- messages -----------------------------------------------------------------------------------------------------
    def receive(self, data: bytes) -> list[bytes]:
        """Take one datagram from the server.

        Returns
        -------
        list of bytes
            Datagrams to send, in this order; usually none, in synch mode the answer to ``(think)``.

        Raises
        ------
        RemoteProtocolError
            When the datagram is malformed.
        """
        if data.startswith(b"(see "):
            parse_see(data, self._team, self._see)
            self._has_see = True
        elif data.startswith(b"(sense_body "):
            self._begin_cycle(data)
        elif data.startswith(b"(think"):
            return [*self._answer(), DONE]
        elif data.startswith(b"(hear "):
            self._hear(data)
        else:
            self._other(data)
        return []

    def _begin_cycle(self, data: bytes) -> None:
        if not self.synch and self._has_sense and self.playing and not self._acted:
            self.missed += 1
        parse_sense_body(data, self._sense)
        self.cycle = int(self._sense["time"][0])
        self._has_sense, self._acted = True, False

    def _hear(self, data: bytes) -> None:
        kind = parse_hear_fast(data, self._heard)
        if kind in (HEARD_REFEREE, HEARD_OTHER):
            event = messages.parse(data)
            if isinstance(event, messages.Hear) and event.source == "referee":
                self._referee(event)
            elif isinstance(event, messages.Hear) and event.source == "coach":
                self._end_episode(event.time)  # whatever a trainer says means this, as to the original players

    def _end_episode(self, cycle: int) -> None:
        taken = self._agent is not None and bool(self._agent["taken_guess"][0])
        self.episodes.append((cycle, taken))
        self._episode_started = True

    def _referee(self, event: messages.Hear) -> None:
        if event.text == EPISODE_END:
            self._end_episode(event.time)
        elif event.text == "play_on":
            if not self.playing:
                self._episode_started = True
                self._has_see = False  # what was seen before the kick-off is of no use
                self._heard["time"][0] = -1
                self.first_cycle = event.time if not self.episodes else self.first_cycle
            self.playing, self.mode = True, "play_on"
        elif event.text is not None:
            self.mode = event.text
            self.playing = event.text == "drop_ball"

    def _other(self, data: bytes) -> None:
        event = messages.parse(data)
        if isinstance(event, messages.ServerParam):
            self._take_params(event.to_params())
        elif isinstance(event, (messages.Unknown, messages.Error, messages.Warning)):
            self.unknown.append(data)

    # -- acting -------------------------------------------------------------------------------------------------------
    def wait(self) -> float | None:
        """Real time: seconds to wait from now before `deadline` must be called; 0: now; None: nothing to do yet."""
        if self.synch or not self._has_sense or self._acted or not self.playing:
            return None
        if self._has_see and int(self._see["time"][0]) == self.cycle:
            return 0.0
        step = self.params.number("simulator_step") / 1000.0
        return max(min(WAIT_FOR_SEE * step, step - ON_THE_WAY), 0.5 * step)

    def deadline(self) -> list[bytes]:
        """Real time: decide with what is known; returns datagrams to send."""
        return [] if self._acted else self._answer()

    def _answer(self) -> list[bytes]:
        self._acted = True
        if not self.playing or not self._has_sense:
            return []
        if self._agent is None:
            self._agent = kernels.new_agent(
                self.side, self.unum, self.n_keepers, self.n_takers, self._record, self.seed, self.hold_cycles
            )
        agent, record = self._agent, self._record
        kernels.perceive(agent, record, self._sense, self._see, self._has_see, self._heard, self._episode_started)
        self._has_see = self._episode_started = False
        self._heard["time"][0] = -1
        choice = self._choose(agent, record) if self.side == LEFT else 0
        kernels.act(agent, record, choice, self._action)
        commands = action_to_bytes(self._action)
        return [commands] if commands else []

    def _choose(self, agent: NDArray[np.void], record: NDArray[np.void]) -> int:
        status = kernels.decide(agent, record, self._state)
        if agent["ended"][0] and self.episode_ended is not None:
            self.episode_ended(self.cycle, bool(agent["ended_acted"][0]), float(agent["final_reward"][0]))
        if status in (kernels.FIRST, kernels.STEP):
            return self.decide(self.cycle, status, float(agent["reward"][0]), self._state)
        return 0
