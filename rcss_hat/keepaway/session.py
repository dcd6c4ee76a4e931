"""One Keepaway player, sans-IO: datagrams in, datagrams out.

In synch mode the server says ``(think)`` once per cycle and the player answers with its commands and ``(done)``. In
real time there is no such sign: the player decides when the see of the cycle has come, or when a part of the cycle
has gone by without one; the caller keeps the time and calls `deadline`.

The network between may lose, double, reorder and delay. A message that was doubled, or overtaken by a later one of its
kind, changes nothing. What a lost one would have told is taken from others: the end of an episode from team mates
(`Endings`), the kick-off from the cycles that go on, the turn to answer in synch mode from silence. That last remedy
begins only when something was seen to go wrong (`troubled`): where nothing does, a player sends what the server asks
for and nothing else.
"""

from __future__ import annotations

from bisect import insort

import numpy as np
from numpy.typing import NDArray

from rcss_hat.keepaway import agent as kernels
from rcss_hat.keepaway.decision import Decide, EpisodeEnd, Onlooker, legal_action
from rcss_hat.keepaway.endings import Endings
from rcss_hat.keepaway.moved import NEVER, forget_sightings, new_sightings, somebody_was_moved
from rcss_hat.keepaway.orders import Orders
from rcss_hat.keepaway.patience import KEPT, KEPT_BYTES, ON_THE_WAY, OVERDUE, OVERTAKEN, SILENT, WAIT_FOR_SEE
from rcss_hat.keepaway.state import n_state_variables
from rcss_hat.keepaway.warm_up import warm_up
from rcss_hat.keepaway.whereabouts import shares_corner
from rcss_hat.player.limits import check_limits
from rcss_hat.protocol import messages
from rcss_hat.protocol.commands import action_to_bytes
from rcss_hat.protocol.hear import HEARD_OTHER, HEARD_REFEREE, HEARD_TEAM_MATE, parse_hear_fast
from rcss_hat.protocol.params import ServerParams, Value
from rcss_hat.protocol.records import ACTION, HEARD, LEFT, RIGHT, SEE, SENSE_BODY, empty
from rcss_hat.protocol.see import parse_see
from rcss_hat.protocol.sense_body import parse_sense_body

DONE = b"(done)\0"
EPISODE_END, DROP_BALL = "training Keepaway 1", "drop_ball"
SHARED_CORNER = "one corner"
"""How `KeepawayPlayer.stopped_by` begins when the server counts fewer keepers than there are."""


class KeepawayPlayer:
    """A keeper or taker that reads server messages and gives commands.

    Parameters
    ----------
    team : str
        Team name; decides who is a team mate.
    n_keepers, n_takers : int
    seed : int
        Of the whole match; the player's own stream is drawn from it, its side and its number.
    decide : callable or None
        The policy of a keeper, or of a taker; None: the hand-coded taker.
    episode_ended : callable, optional
        Called once per episode end, before the first decision that follows it.
    hold_cycles : int
        Cycles from a keeper's Hold to his next decision, or from one decision of a taker to the next.
    endings : Endings, optional
        Shared by the players of a process.

    Attributes
    ----------
    episodes : list of (int, bool)
        Cycle of every episode end this player knows of, and whether its own view of the last cycles, or that of the
        team mate who heard of it, says "taken".
    first_cycle : int
        When the match, or this player's part in it, began.
    missed : int
        Cycles of play in which this player was not asked, or could send no command in time.
    troubled : bool
        Whether the network was seen to lose, double or reorder.
    unknown : int
        Messages received that a player does not know, and refusals; the first few of them are in ``odd``.
    odd : list of bytes
    told : dict of str to Value
        The server's parameters as it told them.
    stopped_by : str
        What the referee said that has stopped play after it had begun, and when; empty while play goes on.
    news : bool
        Set when something came that is of interest to others: anything but see, ``(think)`` and what players say.
    onlooker : Onlooker or None
        Who looks over this player's shoulder.
    """

    def __init__(
        self,
        team: str,
        n_keepers: int,
        n_takers: int,
        seed: int,
        decide: Decide | None,
        episode_ended: EpisodeEnd | None = None,
        hold_cycles: int = 1,
        endings: Endings | None = None,
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
        self.told: dict[str, Value] = {}
        self.stopped_by = ""
        self.news = False
        self.onlooker: Onlooker | None = None
        self.endings = Endings() if endings is None else endings
        self.troubled = False
        self.unknown = 0
        self.odd: list[bytes] = []
        self._team = team.encode()
        self._record = self.params.record()
        self._sense, self._see, self._heard, self._action = empty(SENSE_BODY), empty(SEE), empty(HEARD), empty(ACTION)
        self._next_sense, self._next_see = empty(SENSE_BODY), empty(SEE)  # read into, then taken when they are newer
        self._heard["time"][0] = -1
        self._see_time = self._listened = self._mode_time = self._begun = -1
        self._sees: list[bytes] = []  # of the newest time: a player may see twice in a cycle
        self._agent: NDArray[np.void] | None = None
        self._sightings = new_sightings()
        self._state = np.zeros(n_state_variables(n_keepers, n_takers))
        self._orders = Orders(n_keepers, n_takers, hold_cycles)
        self._has_see = self._has_sense = self._episode_started = self._acted = self._asked_twice = False

    @property
    def name(self) -> str:
        """Who this is, for messages."""
        return f"{self.team} {self.unum}" if self.unum else self.team

    @property
    def beliefs(self) -> NDArray[np.void] | None:
        """What this player believes; see `rcss_hat.keepaway.decision.Believer`."""
        return self._agent

    # -- before the match ---------------------------------------------------------------------------------------------
    def initialised(self, event: messages.Init) -> None:
        """Take the place that the server has given."""
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
        warm_up(self.n_keepers, self.n_takers, self._record)

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
            self._look(data)
        elif data.startswith(b"(sense_body "):
            self._feel(data)
            self.news = True
        elif data.startswith(b"(think"):
            return self._think()
        elif data.startswith(b"(hear "):
            self._hear(data)
        else:
            self._other(data)
            self.news = True
        return []

    def _look(self, data: bytes) -> None:
        """Take a see unless it was taken before, or a newer one was."""
        see = self._next_see
        parse_see(data, self._team, see)
        time = int(see["time"][0])
        if time > self._see_time or time < self._see_time - OVERTAKEN:
            self._see_time, self._sees = time, [data]
        elif self.playing and (time < self._see_time or data in self._sees):
            self.troubled = True
            return
        else:
            self._sees = [*self._sees[-KEPT:], data]
        self._see, self._next_see = see, self._see
        self._has_see = True

    def _feel(self, data: bytes) -> None:
        """Take a sense_body unless it was taken before, or a newer one was; time stands still only before play."""
        sense = self._next_sense
        parse_sense_body(data, sense)
        time, before = int(sense["time"][0]), self.cycle
        if self._has_sense and time != before + 1 and not self._in_order(time):
            return
        if self._has_sense and not self.playing and self.mode == "before_kick_off" and time > before:
            self._kick_off(before)  # cycles are counted from the kick-off on
        elif self._has_sense and self.playing and not self._acted and not (self.synch and before == self._begun):
            self.missed += 1
            self.troubled |= self.synch
        self._sense, self._next_sense = sense, self._sense
        self.cycle = time
        self._has_sense, self._acted = True, False
        if len(self.endings.cycles) != len(self.episodes):
            self._learn_of_ends()

    def _in_order(self, time: int) -> bool:
        """Whether a sense_body that is not the next one is to be taken; counts the cycles that were lost before it."""
        ahead = time - self.cycle
        if self.playing:
            self.troubled = True
            self.missed += max(0, ahead - 1)
        return ahead > 0 or ahead < -OVERTAKEN or (ahead == 0 and not self.playing)

    def _think(self) -> list[bytes]:
        """Answer ``(think)``, once per cycle of play: it has no number, and one that was doubled is no new one."""
        if self._acted and self.playing:
            self.troubled = self._asked_twice = True
            return []
        self._asked_twice = False
        return self._answer_with_done()

    def _hear(self, data: bytes) -> None:
        kind = parse_hear_fast(data, self._heard)
        if kind == HEARD_TEAM_MATE:
            if (
                self.playing and -OVERTAKEN < self._heard["time"][0] - self._listened <= 0
            ):  # of a cycle in which one has acted
                self._heard["time"][0] = -1
                self.troubled = True
        elif kind in (HEARD_REFEREE, HEARD_OTHER):
            self.news = True
            event = messages.parse(data)
            if isinstance(event, messages.Hear) and event.source == "referee":
                self._referee(event)
            elif isinstance(event, messages.Hear) and event.source == "coach":
                self._end_episode(event.time)  # whatever a trainer says means this, as to the original players

    def _learn_of_ends(self) -> None:
        """Learn from team mates of ends that this player was not told of."""
        for cycle in self.endings.cycles[-KEPT:]:
            if self.first_cycle < cycle <= self.cycle and not self._knows(cycle):
                self.troubled = True
                self._begin_episode(cycle, self.endings.taken(cycle))

    def _knows(self, end: int) -> bool:
        return any(known == end for known, _ in self.episodes[-2 * KEPT :])

    def _end_episode(self, cycle: int) -> None:
        if self._knows(cycle):
            return
        taken = self._agent is not None and bool(self._agent["taken_guess"][0])
        self.endings.add(cycle, taken)
        self._begin_episode(cycle, taken)

    def _begin_episode(self, cycle: int, taken: bool) -> None:
        insort(self.episodes, (cycle, taken))
        self._episode_started = True
        self._orders.forget()
        if self.onlooker is not None:
            self.onlooker.ended(self, cycle, taken)

    def _referee(self, event: messages.Hear) -> None:
        if event.text == DROP_BALL:
            self.endings.drop(event.time)
        if event.text == EPISODE_END:
            self._end_episode(event.time)
        elif event.text is not None and not -OVERTAKEN < event.time - self._mode_time < 0:
            self._mode_time = event.time
            if event.text == "play_on":
                self._kick_off(event.time)
            else:
                if self.playing and event.text != DROP_BALL:
                    self.stopped_by = f"{event.text} in cycle {event.time}"
                self.mode = event.text
                self.playing = event.text == DROP_BALL

    def _kick_off(self, cycle: int) -> None:
        """Play begins, or goes on."""
        if not self.playing:
            self._episode_started = True
            self._has_see = False  # what was seen before the kick-off is of no use
            self._see_time = self._listened = -1
            forget_sightings(self._sightings)
            self._begun = cycle  # after the server has asked for commands, perhaps
            self._heard["time"][0] = -1
            self.first_cycle = cycle if not self.episodes else self.first_cycle
        self.playing, self.mode, self.stopped_by = True, "play_on", ""

    def _other(self, data: bytes) -> None:
        event = messages.parse(data)
        if isinstance(event, messages.ServerParam):
            self._take_params(event.to_params())
            self.told = dict(event.values)
        elif isinstance(event, (messages.Unknown, messages.Error, messages.Warning)):
            self.unknown += 1
            self.odd += [data[:KEPT_BYTES]] if len(self.odd) < KEPT else []

    # -- acting -------------------------------------------------------------------------------------------------------
    def wait(self) -> float | None:
        """Seconds to wait from now before `deadline` must be called; 0: now; None: nothing to do yet.

        In synch mode there is something to do only on a network that was seen to make mistakes.
        """
        if not self._has_sense or not self.playing:
            return None
        if self.synch:
            return self._patience() if self.troubled else None
        if self._acted:
            return None
        if self._has_see and int(self._see["time"][0]) == self.cycle:
            return 0.0
        step = self.params.number("simulator_step") / 1000.0
        return max(min(WAIT_FOR_SEE * step, step - ON_THE_WAY), 0.5 * step)

    def _patience(self) -> float:
        """Synch mode: how long to be silent; short when a ``(think)`` came that may be one that overtook others."""
        overtaken = self._asked_twice and (not self._acted or self._see_time > self.cycle)
        return OVERDUE if overtaken else SILENT

    def deadline(self) -> list[bytes]:
        """Decide with what is known; returns datagrams to send.

        In synch mode ``(think)`` or an answer to it was lost: the server waits, and is answered, perhaps again.
        """
        self._asked_twice = False
        if self._acted:
            return [DONE] if self.synch else []
        return self._answer_with_done() if self.synch else self._answer()

    def _answer_with_done(self) -> list[bytes]:
        """Decide; returns one datagram for the commands and ``(done)``, which a server reads one after the other."""
        answers = self._answer()
        return [answers[0][:-1] + DONE] if answers else [DONE]

    def _answer(self) -> list[bytes]:
        self._acted = True
        self._listened = self.cycle
        if not self.playing or not self._has_sense:
            return []
        if self._agent is None:
            self._agent = kernels.new_agent(
                self.side, self.unum, self.n_keepers, self.n_takers, self._record, self.seed, self.hold_cycles
            )
        agent, record = self._agent, self._record
        kernels.perceive(agent, record, self._sense, self._see, self._has_see, self._heard, self._episode_started)
        if self._has_see:
            self._look_for_ends(agent)
            self._look_at_corners(agent)
        self._has_see = self._episode_started = False
        self._heard["time"][0] = -1
        if self.side == LEFT:
            status, choice = self._choose(agent)
        else:
            status, choice = kernels.NO_DECISION, self._orders.told(self.decide, self.cycle, agent)
        kernels.act(agent, record, status, choice, self._action)
        if self.onlooker is not None:
            self.onlooker.acted(self)
        commands = action_to_bytes(self._action)
        return [commands] if commands else []

    def _look_for_ends(self, agent: NDArray[np.void]) -> None:
        """File it when somebody was moved, as at the end of an episode, and no end is known that explains it."""
        seen = int(self._see["time"][0])
        if seen > self._begun:  # what was seen before is where players waited
            since = somebody_was_moved(agent, self._record, self._see, self._sightings)
            if since != NEVER:
                self.endings.suspect(since, seen)

    def _look_at_corners(self, agent: NDArray[np.void]) -> None:
        """Stop when the server has put two keepers into one corner: it counts fewer than there are."""
        if self.side != LEFT or not self.episodes or not self.params["keepaway"]:
            return
        begun = self.episodes[-1][0]
        if 0 <= int(self._see["time"][0]) - begun <= 1:
            record = self._record
            other = shares_corner(agent, (record["keepaway_length"][0], record["keepaway_width"][0]))
            if other is not None:
                self.stopped_by = f"{SHARED_CORNER} for keepers {self.unum} and {other} in cycle {begun}"

    def _choose(self, agent: NDArray[np.void]) -> tuple[int, int]:
        """Return what `act` wants to know: whether the policy was asked, and its answer."""
        point = kernels.decide(agent, self._state)
        if point.ended and self.episode_ended is not None:
            self.episode_ended(self.cycle, point.acted, point.final_reward)
        if point.status not in (kernels.FIRST, kernels.STEP):
            return point.status, 0
        assert self.decide is not None, "a keeper has a policy"
        choice = self.decide(self.cycle, point.status, point.reward, self._state)
        return point.status, legal_action(choice, self.n_keepers)
