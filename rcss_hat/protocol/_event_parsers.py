"""Server messages to events (19.0.0, src/serializer*.cpp; text forms of versions 7 to 19)."""

from __future__ import annotations

import re
from collections.abc import Callable

from rcss_hat.protocol import records
from rcss_hat.protocol._events import (
    BallState,
    ChangePlayerType,
    Error,
    Event,
    Fullstate,
    FullstatePlayer,
    GlobalPlayer,
    Hear,
    Init,
    InitOk,
    Msg,
    Ok,
    OkCheckBall,
    OkClang,
    OkCompression,
    OkTeamNames,
    PlayerParam,
    PlayerType,
    PlayMode,
    Reconnect,
    Score,
    See,
    SeeGlobal,
    SenseBody,
    ServerParam,
    Team,
    Think,
    Unknown,
    Warning,
)
from rcss_hat.protocol._groups import Group, Quoted, is_number, read_group
from rcss_hat.protocol._show import parse_show
from rcss_hat.protocol.errors import RemoteProtocolError
from rcss_hat.protocol.params import Value
from rcss_hat.protocol.records import MAX_PLAYERS
from rcss_hat.protocol.see import parse_see
from rcss_hat.protocol.sense_body import parse_sense_body

SIDES = ("l", "r")
_NAME = re.compile(rb"\(([a-z_]+)[ )]")


def parse(data: bytes, team: str = "") -> Event:
    """Read a message from a server.

    Parameters
    ----------
    data : bytes
        One datagram, with or without its NUL; or a line of a game log.
    team : str
        Name of the receiver's team; only see messages need it.

    Returns
    -------
    Event
        `Unknown` for a well-formed message of a kind not known here. Version 7's parameter lists, which have no names,
        and its fullstate are among those.

    Raises
    ------
    RemoteProtocolError
        When the message is malformed; names the place.
    """
    match = _NAME.match(data)
    name = match.group(1) if match else b""
    by_bytes = _BY_BYTES.get(name)
    if by_bytes is not None:
        return by_bytes(data, team)
    group = read_group(data)
    by_group = _BY_GROUP.get(name)
    if by_group is None or (name in _NAMELESS_IN_7 and is_number(group.items[1] if len(group.items) > 1 else None)):
        return Unknown(data=data)
    group.next = 1
    event = by_group(group)
    group.finish()
    return event


# --- every cycle ---------------------------------------------------------------------------------------------------
def _see(data: bytes, team: str) -> Event:
    record = records.empty(records.SEE)
    parse_see(data, team.encode("latin-1", "replace"), record)
    return See(record=record)


def _sense_body(data: bytes, team: str) -> Event:
    record = records.empty(records.SENSE_BODY)
    parse_sense_body(data, record)
    return SenseBody(record=record)


_SPOKEN = re.compile(rb"\(hear (?:referee )?(-?[0-9]{1,9}) ([^\0]+)\)[ \t\r\n]*(?:\0|$)")
_WITH_NAME = re.compile(r"(referee|self|coach|online_coach_left|online_coach_right) (.*)", re.DOTALL)
_BY_SIDE = re.compile(r'(?:(-?[0-9]{1,3}) )?(our|opp)(?: ([0-9]{1,2}))?(?: "([^"]*)")?')
_BY_DIRECTION = re.compile(r'(-?[0-9]{1,3}) "([^"]*)"')
_BY_PLAYER = re.compile(r'\(p "([^"]*)" ([0-9]{1,2})( goalie)?\) "([^"]*)"')


def _hear(data: bytes, team: str) -> Event:
    match = _SPOKEN.match(data)
    if match is None:
        raise RemoteProtocolError("bad hear message: expected (hear TIME SOURCE TEXT)", data, len(b"(hear "))
    time, said = int(match.group(1)), match.group(2).decode("latin-1")
    if data.startswith(b"(hear referee "):  # to trainers, who get the name before the time
        return Hear(time=time, source="referee", text=said)
    named = _WITH_NAME.fullmatch(said)
    if named:
        return Hear(time=time, source=named[1], text=_without_quotes(named[2]))
    by_side = _BY_SIDE.fullmatch(said)
    if by_side and (by_side[1] is None) == (by_side[4] is None):
        direction, unum = by_side[1], by_side[3]
        if (unum is not None and 1 <= int(unum) <= MAX_PLAYERS) == (by_side[2] == "our"):
            return Hear(
                time=time,
                source=by_side[2],
                text=by_side[4],
                direction=None if direction is None else float(direction),
                unum=None if unum is None else int(unum),
            )
    by_direction = _BY_DIRECTION.fullmatch(said)
    if by_direction:
        return Hear(time=time, source="player", text=by_direction[2], direction=float(by_direction[1]))
    by_player = _BY_PLAYER.fullmatch(said)
    if by_player and 1 <= int(by_player[2]) <= MAX_PLAYERS:
        speaker, unum, goalie, text = by_player.groups()
        return Hear(time=time, source="player", text=text, unum=int(unum), team=speaker, goalie=goalie is not None)
    raise RemoteProtocolError("bad hear message: unknown source", data, match.start(2))


def _without_quotes(text: str) -> str:
    return text[1:-1] if len(text) > 1 and text[0] == text[-1] == '"' else text


def _think(group: Group) -> Event:
    return Think()


# --- joining -------------------------------------------------------------------------------------------------------
def _init(group: Group) -> Event:
    if group.peek() == "ok":
        group.word()
        return InitOk()
    return Init(side=group.word(*SIDES), unum=group.integer(1, MAX_PLAYERS), mode=group.word())


def _reconnect(group: Group) -> Event:
    return Reconnect(side=group.word(*SIDES), mode=group.word())


_NAMELESS_IN_7 = (b"server_param", b"player_param", b"player_type")


def _values(group: Group) -> dict[str, Value]:
    values: dict[str, Value] = {}
    while group.more:
        pair = group.group()
        name = pair.word()
        values[name] = _value(pair)
        pair.finish()
    return values


def _value(pair: Group) -> Value:
    item = pair.peek()
    if isinstance(item, Quoted):
        return pair.text()
    value = pair.number()
    return int(value) if isinstance(item, str) and item.lstrip("-").isdigit() else value


def _server_param(group: Group) -> Event:
    return ServerParam(values=_values(group))


def _player_param(group: Group) -> Event:
    return PlayerParam(values=_values(group))


def _player_type(group: Group) -> Event:
    values = _values(group)
    identity = values.get("id")
    if not isinstance(identity, int) or identity < 0:
        group.fail("expected (id N) among the values")
    return PlayerType(id=identity, values=values)


def _change_player_type(group: Group) -> Event:
    side = group.word(*SIDES) if group.peek() in SIDES else None
    unum = group.integer(1, MAX_PLAYERS)
    return ChangePlayerType(unum=unum, player_type=group.integer(0) if group.more else None, side=side)


# --- fullstate -----------------------------------------------------------------------------------------------------
def _ball(group: Group) -> BallState:
    entry = group.group()
    entry.group("b").finish()
    ball = BallState(x=entry.number(), y=entry.number(), vx=entry.number(), vy=entry.number())
    entry.finish()
    return ball


def _fullstate(group: Group) -> Event:
    time = group.integer()
    mode = group.group("pmode")
    view = group.group("vmode")
    if not group.has_group("count"):  # version 7
        group.next = len(group.items)
        return Unknown(data=group.data)
    counts = group.group("count").numbers()
    arm = group.group("arm")
    score = group.group("score")
    event = Fullstate(
        time=time,
        mode=mode.word(),
        quality=view.word("high", "low"),
        width=view.word("narrow", "normal", "wide"),
        counts=tuple(int(count) for count in counts),
        arm=_own_arm(arm),
        score=(score.integer(), score.integer()),
        ball=_ball(group),
        players=tuple(_fullstate_player(group.group()) for _ in range(len(group.items) - group.next)),
    )
    for part in (mode, view, arm, score):
        part.finish()
    return event


def _own_arm(arm: Group) -> tuple[float, float, float, float, float]:
    movable, expires = arm.group("movable").number(), arm.group("expires").number()
    target = arm.group("target")
    distance, direction = target.number(), target.number()
    return movable, expires, distance, direction, arm.group("count").number()


def _fullstate_player(entry: Group) -> FullstatePlayer:
    name = entry.group("p")
    side, unum = name.word(*SIDES), name.integer(1, MAX_PLAYERS)
    goalie = name.peek() == "g"
    if goalie:
        name.word()
    player_type = name.integer(0) if name.more else None
    name.finish()
    x, y, vx, vy, body, neck, *arm = _counted(entry, 6, 8)
    focus_point = _pair(entry.group("focus_point")) if entry.has_group("focus_point") else None
    stamina = entry.group("stamina")
    energy = _counted(stamina, 3, 4)
    return FullstatePlayer(
        side=side,
        unum=unum,
        goalie=goalie,
        player_type=player_type,
        x=x,
        y=y,
        vx=vx,
        vy=vy,
        body=body,
        neck=neck,
        arm=(arm[0], arm[1]) if arm else None,
        focus_point=focus_point,
        stamina=energy[0],
        effort=energy[1],
        recovery=energy[2],
        capacity=energy[3] if len(energy) == 4 else None,
        marks=_marks(entry),
    )


def _counted(group: Group, *allowed: int) -> list[float]:
    values = group.numbers()
    if len(values) not in allowed:
        group.fail(f"expected {' or '.join(map(str, allowed))} numbers, not {len(values)}")
    return values


def _pair(group: Group) -> tuple[float, float]:
    first, second = _counted(group, 2)
    group.finish()
    return first, second


def _marks(entry: Group) -> tuple[str, ...]:
    marks = []
    while entry.more:
        marks.append(entry.word("t", "k", "f", "r", "y"))
    return tuple(marks)


# --- answers -------------------------------------------------------------------------------------------------------
def _ok(group: Group) -> Event:
    command = group.word()
    if command == "look":
        return _global(group, answer=True)
    if command == "clang":
        versions = group.group("ver")
        return OkClang(minimum=versions.integer(), maximum=versions.integer())
    if command == "compression":
        return OkCompression(level=group.integer())
    if command == "check_ball":
        return OkCheckBall(time=group.integer(), where=group.word())
    if command == "team_names":
        names: dict[str, str] = {}
        while group.more:
            team = group.group("team")
            side = team.word(*SIDES)
            names[side] = team.text()
        return OkTeamNames(left=names.get("l"), right=names.get("r"))
    return Ok(command=command, text=_rest(group))


def _rest(group: Group) -> str:
    """Take all that is left as it was written."""
    if not group.more:
        return ""
    start = group.positions[group.next]
    end = group.data.rindex(b")")
    group.next = len(group.items)
    return group.data[start:end].decode("latin-1").rstrip()


def _error(group: Group) -> Event:
    return Error(text=_rest(group))


def _warning(group: Group) -> Event:
    return Warning(text=_rest(group))


def _score(group: Group) -> Event:
    return Score(time=group.integer(), ours=group.integer(), theirs=group.integer())


# --- trainer -------------------------------------------------------------------------------------------------------
def _see_global(group: Group) -> Event:
    return _global(group, answer=False)


def _global(group: Group, answer: bool) -> Event:
    time = group.integer()
    goals = {}
    for _ in SIDES:
        entry = group.group()
        goal = entry.group("g")
        goals[goal.word(*SIDES)] = _pair(entry)
        goal.finish()
    ball = _ball(group)
    players = tuple(_global_player(group.group()) for _ in range(len(group.items) - group.next))
    return SeeGlobal(time=time, answer=answer, goals=goals, ball=ball, players=players)


def _global_player(entry: Group) -> GlobalPlayer:
    name = entry.group("p")
    team, unum = name.text(), name.integer(1, MAX_PLAYERS)
    goalie = name.more and name.word("goalie") == "goalie"
    name.finish()
    x, y, vx, vy, body, neck, *pointing = _counted(entry, 6, 7)
    return GlobalPlayer(
        team=team,
        unum=unum,
        goalie=goalie,
        x=x,
        y=y,
        vx=vx,
        vy=vy,
        body=body,
        neck=neck,
        pointing=pointing[0] if pointing else None,
        marks=_marks(entry),
    )


# --- monitor and game log ------------------------------------------------------------------------------------------
def _show(data: bytes, team: str) -> Event:
    return parse_show(data)


def _team(group: Group) -> Event:
    time, left, right = group.integer(), group.text(), group.text()
    ours, theirs, *penalties = (int(score) for score in _counted(group, 2, 6))
    return Team(time=time, left=left, right=right, left_score=ours, right_score=theirs, penalties=tuple(penalties))


def _playmode(group: Group) -> Event:
    return PlayMode(time=group.integer(), mode=group.word())


_MSG = re.compile(rb'\(msg (-?[0-9]{1,9}) ([0-9]{1,3}) "([^\0]*)"\)[ \t\r\n]*(?:\0|$)')


def _msg(data: bytes, team: str) -> Event:
    match = _MSG.match(data)
    if match is None:
        raise RemoteProtocolError('bad msg message: expected (msg TIME BOARD "TEXT")', data, len(b"(msg "))
    return Msg(time=int(match[1]), board=int(match[2]), text=match[3].decode("latin-1"))


# Read from the bytes: what comes often, and speech, which may hold anything, parentheses too.
_BY_BYTES: dict[bytes, Callable[[bytes, str], Event]] = {
    b"see": _see, b"sense_body": _sense_body, b"hear": _hear, b"msg": _msg, b"show": _show,
}  # fmt: skip
_BY_GROUP: dict[bytes, Callable[[Group], Event]] = {
    b"think": _think, b"init": _init, b"reconnect": _reconnect, b"server_param": _server_param,
    b"player_param": _player_param, b"player_type": _player_type, b"change_player_type": _change_player_type,
    b"ok": _ok, b"error": _error, b"warning": _warning, b"score": _score, b"fullstate": _fullstate,
    b"see_global": _see_global, b"team": _team, b"playmode": _playmode,
}  # fmt: skip
