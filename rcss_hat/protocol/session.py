"""A player's side of the conversation with a server, without sockets.

The conversation has four states. In NEW nothing was sent; only ``(init ...)`` or ``(reconnect ...)`` may be. That leads
to JOINING: the server has been asked and answers with ``(init SIDE UNUM MODE)``, which leads to PLAYING, or with an
error, which leads back to NEW (another team name may be tried). The server sends its parameters right behind its
answer, so they arrive in PLAYING. ``(bye)`` is never answered; it leads to GONE, where nothing may be sent. Table
`NEXT` holds all of this; whatever is not in it is a mistake of the one who acts: ours is a LocalProtocolError, raised
before anything is sent; the server's is a RemoteProtocolError.
"""

from __future__ import annotations

import re
from enum import Enum

from rcss_hat.protocol import messages
from rcss_hat.protocol.commands import Bye, Command, Compression, Init, Reconnect, datagram
from rcss_hat.protocol.errors import LocalProtocolError, RemoteProtocolError
from rcss_hat.protocol.params import ServerParams
from rcss_hat.protocol.play_modes import PLAY_MODE_IDS


class State(Enum):
    """Where a conversation is."""

    NEW = "new"
    JOINING = "joining"
    PLAYING = "playing"
    GONE = "gone"


NEXT: dict[tuple[State, type], State] = {
    # what we send
    (State.NEW, Init): State.JOINING,
    (State.NEW, Reconnect): State.JOINING,
    (State.JOINING, Init): State.JOINING,  # again: the first may be lost
    (State.JOINING, Reconnect): State.JOINING,
    (State.PLAYING, Command): State.PLAYING,  # any of a player's
    (State.PLAYING, Bye): State.GONE,
    # what the server sends
    (State.JOINING, messages.Init): State.PLAYING,
    (State.JOINING, messages.Reconnect): State.PLAYING,
    (State.JOINING, messages.Error): State.NEW,
    (State.PLAYING, messages.Event): State.PLAYING,
    (State.GONE, messages.Event): State.GONE,  # what was under way when we left
}
_GOAL = re.compile(r"(goal_[lr])_[0-9]+")


class PlayerSession:
    """One player's conversation with a server.

    Parameters
    ----------
    profile : {"19.0", "11.1"}
        Whose defaults to assume for parameters the server does not tell.

    Attributes
    ----------
    state : State
    team : str
    side : str
        ``"l"`` or ``"r"``; empty before the server's answer.
    unum : int
        0 before the server's answer.
    mode : str
        The play mode, as far as the referee told.
    params : ServerParams or None
    player_param : PlayerParam or None
    player_types : dict of int to PlayerType
    types : dict of int to int
        Type of every team mate whose type was changed, by uniform number; all others have type 0.
    """

    def __init__(self, profile: str = "19.0") -> None:
        self.profile = profile
        self.state = State.NEW
        self.team = self.side = self.mode = ""
        self.unum = 0
        self.params: ServerParams | None = None
        self.player_param: messages.PlayerParam | None = None
        self.player_types: dict[int, messages.PlayerType] = {}
        self.types: dict[int, int] = {}

    def initialise(self, team: str, version: int = 11, goalie: bool = False) -> bytes:
        """Return the datagram that asks for a place in a team.

        Raises
        ------
        LocalProtocolError
            When the session has begun already, or an argument is illegal.
        """
        data = self.send(Init(team, version, goalie))
        self.team = team
        return data

    def reconnect(self, team: str, unum: int) -> bytes:
        """Return the datagram that asks for an old place; raises as `initialise`."""
        data = self.send(Reconnect(team, unum))
        self.team, self.unum = team, unum
        return data

    def send(self, *commands: Command) -> bytes:
        """Return the datagram of some commands.

        Raises
        ------
        LocalProtocolError
            When a command is illegal, or illegal now.
        """
        state = self.state
        for command in commands:
            if isinstance(command, Compression):
                raise LocalProtocolError("this session does not compress messages; leave compression off")
            state = self._next(state, command, LocalProtocolError)
        data = datagram(*commands)
        self.state = state
        return data

    def receive_data(self, data: bytes) -> messages.Event:
        """Take a datagram from the server and return what it says.

        Raises
        ------
        RemoteProtocolError
            When it is malformed, or when the server must not send it now.
        """
        event = messages.parse(data, self.team)
        self.state = self._next(self.state, event, RemoteProtocolError)
        if isinstance(event, messages.Hear):
            self._hear(event)
        elif isinstance(event, messages.Init):
            self.side, self.unum, self.mode = event.side, event.unum, event.mode
        elif isinstance(event, messages.Reconnect):
            self.side, self.mode = event.side, event.mode
        elif isinstance(event, messages.ServerParam):
            self.params = event.to_params(self.profile)
        elif isinstance(event, messages.PlayerParam):
            self.player_param = event
        elif isinstance(event, messages.PlayerType):
            self.player_types[event.id] = event
        elif isinstance(event, messages.ChangePlayerType) and event.player_type is not None:
            self.types[event.unum] = event.player_type
        return event

    def _next(
        self, state: State, message: Command | messages.Event, error: type[LocalProtocolError | RemoteProtocolError]
    ) -> State:
        general: type = Command if isinstance(message, Command) else messages.Event
        following = NEXT.get((state, type(message)))
        if following is None and not (isinstance(message, Command) and message.alone):  # those are for others to send
            following = NEXT.get((state, general))
        if following is None:
            allowed = sorted(kind.__name__ for at, kind in NEXT if at is state and issubclass(kind, general))
            name = type(message).__name__
            raise error(f"{name} is not allowed in state {state.value}; allowed: {', '.join(allowed) or 'nothing'}")
        return following

    def _hear(self, event: messages.Hear) -> None:
        if event.source != "referee" or event.text is None:
            return
        goal = _GOAL.fullmatch(event.text)
        mode = goal[1] if goal else event.text
        if mode in PLAY_MODE_IDS:
            self.mode = mode
