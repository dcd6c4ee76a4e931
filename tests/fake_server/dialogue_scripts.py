"""What is said in the dialogues: soccer with a trainer, Keepaway, a match that monitors run; half of it by chance."""

from __future__ import annotations

import random

from dialogues import GONE, Dialogue

from rcss_hat.protocol.play_modes import PLAY_MODES

_COUNTED_ON = ("goal_l", "goal_r", "offside", "back_pass_r", "catch_fault_r")
"""When a trainer sets these, the original goes on counting from the last stoppage of the kind (fake_server.md)."""
_JUDGED_ELSEWHERE = ("penalty", "illegal_defense", "null", "max", "pause", "human", "first_half")


def soccer() -> Dialogue:
    """Every kind of stoppage and set play, catches, speech, collisions, goals; trainer and three monitors."""
    clients = {
        "trainer": "(init (version 19))", "monitor5": "(dispinit version 5)", "monitorj": "(dispinit version -1)",
        "monitor2": "(dispinit version 2)", "l1": "(init left (version 19) (goalie))",
        "r1": "(init right (version 16) (goalie))",
    }  # fmt: skip
    clients |= {f"l{k}": f"(init left (version {v}))" for k, v in ((2, 8), (3, 11), (4, 13), (5, 18), (6, 12))}
    clients |= {f"r{k}": f"(init right (version {v}))" for k, v in ((2, 10), (3, 14), (4, 15), (5, 17), (6, 9))}
    server = {"coach_w_referee": True, "fullstate_l": True, "fullstate_r": False}
    d = Dialogue("soccer", server, clients)
    d.then(trainer=["(ear on)", "(eye on)"])
    _line_up(d)
    _catches(d)
    _speech(d)
    _collisions(d)
    _starts(d)
    _goals(d)
    _lines(d)
    _set_plays(d)
    _stoppages(d)
    _departures(d)
    return d


def _line_up(d: Dialogue) -> None:
    """Put everybody somewhere, far from each other and from the ball."""
    names = [(f"left {k}", -30.0 + 2.0 * k, -30.0 + 3.0 * k) for k in range(1, 7)]
    names += [(f"right {k}", 30.0 - 2.0 * k, 30.0 - 3.0 * k) for k in range(1, 7)]
    d.then(trainer=["(move (ball) 0 25)", *(f"(move (player {who}) {x:g} {y:g} 0 0 0)" for who, x, y in names)])


def _catches(d: Dialogue) -> None:
    def place(ball: float, goalie: float, who: str = "left 1", angle: int = 0) -> list[str]:
        return [
            "(change_mode play_on)", f"(move (ball) {ball} 0 0 0 0)", f"(move (player {who}) {goalie} 0 {angle} 0 0)",
        ]  # fmt: skip

    d.then(trainer=place(-45.0, -46.0)).then(l1="(catch 0)", idle=2)
    d.then(l1="(move -44 5)", l2="(move -20 0)").then(l1="(move -43 -5)").then(l1="(move -42 5)", idle=1)
    d.then(l1="(turn 30)").then(l1="(dash 100)", idle=1).then(l1="(kick 60 0)", l2="(kick 10 0)", idle=3)
    d.then(trainer=place(0.8, 0.0)).then(l1="(catch 0)", idle=2).then(l1="(kick 50 0)", r2="(tackle 0)", idle=31)
    d.then(r2="(kick 30 0)", idle=1)
    d.then(trainer=place(-36.5, -37.0)).then(l1="(catch 0)", idle=1).then(l1="(dash 100)", idle=3)
    d.then(l1="(move -10 0)", idle=3)
    _line_up(d)
    d.then(trainer=place(45.0, 46.0, "right 1", 180)).then(r1=["(catch 0)", "(kick 50 0)"], idle=1)
    d.then(r1="(catch 0)").then(r1="(tackle 0)", idle=2)
    d.then(trainer=place(-45.0, -46.0)).then(l1="(catch 90)", l2="(catch 0)", idle=1).then(l1="(catch 0)", idle=6)
    d.then(l1=["(catch 0)"], trainer=["(change_mode free_kick_l)", "(change_mode play_on)"], idle=1)
    _line_up(d)


def _speech(d: Dialogue) -> None:
    everybody = {f"l{k}": f'(say "m{k}")' for k in range(2, 6)}
    d.then(idle=1, **everybody)
    d.then(idle=1, **everybody, r2='(say "r2")', r3='(say "r3")')
    d.then(l1=["(attentionto our 3)", "(attentionto our 1)", "(attentionto nobody 3)"]).then(idle=1, **everybody)
    d.then(l1="(attentionto off)", l2="(ear (on partial))", l6="(ear (on our partial))", r1="(ear (off))")
    d.then(idle=1, l3='(say "one")', l4='(say "two")', r4='(say "three")', r5='(say "four")')
    d.then(r1="(ear (on opp complete))", l2="(ear (off our c))", l6="(ear (off opp))", l1="(ear (on opp p))")
    d.then(idle=1, l3='(say "one")', l4='(say "two")', r4='(say "three")', r5='(say "four")')
    d.then(r2="(ear (on nobody))", l1="(ear (off) (on))", r3="(ear (off left partial))", trainer="(say to all)")
    d.then(l1='(say "12345678901")', l2="(say unquoted)", l3='(say "")', l4='(say "a b")', idle=1)


def _collisions(d: Dialogue) -> None:
    d.then(trainer=["(move (ball) 0 10 0 0 0)", "(move (player left 2) -1.2 10 0 0 0)"], l2="(dash 100)")
    d.then(idle=2, l2="(dash 100)")
    d.then(trainer=["(move (player left 3) 10 20 0 0 0)", "(move (player right 3) 10.3 20 0 0 0)"], idle=1)
    d.then(trainer="(move (player right 4) 10.3 20 0 0 0)", l3=["(sense_body)", "(dash 50)"], idle=2)
    d.then(trainer="(move (ball) 0 25 0 0 0)")


def _starts(d: Dialogue) -> None:
    d.then(trainer="(start)", idle=1).then(trainer=["(start)", "(start)"], monitor5="(dispstart)", idle=1)
    d.then(trainer="(change_mode before_kick_off)", idle=1).then(l4="(move -10 -3)", l5="(move 5 5)", idle=1)
    d.then(trainer="(change_mode kick_off_l)", idle=1)
    d.then(trainer="(move (player left 4) -0.6 0 0 0 0)").then(l4="(kick 20 0)", idle=1)
    d.then(monitor5="(start)", monitorj="(start)", monitor2="(dispstart)", idle=1)


def _goals(d: Dialogue) -> None:
    _line_up(d)
    for mode, x, v in (("play_on", 52.0, 2.0), ("play_on", -52.0, -2.0), ("drop_ball", 52.0, 2.0)):
        d.then(trainer=[f"(change_mode {mode})", f"(move (ball) {x} 0 0 {v} 0)"], idle=1)
        d.then(l2="(move -5 -5)", l3="(kick 10 0)", r2="(move -9 3)", r3='(say "goal")', idle=25)
        d.then(l2="(score)", r2="(score)", idle=26)
        d.then(trainer=["(check_ball)", "(change_mode play_on)"], idle=1)
        _line_up(d)
    d.then(trainer=["(change_mode indirect_free_kick_l)", "(move (ball) 52 0 0 2 0)"], idle=3)


def _lines(d: Dialogue) -> None:
    for x, y, vx, vy in ((10, 33.5, 0, 2), (-10, -33.5, 0, -2), (52, 20, 2, 0), (-52, -20, -2, 0)):
        _line_up(d)
        put = ["(change_mode play_on)", f"(move (ball) {x} {y} 0 0 0)", f"(move (player left 2) {x - 0.6} {y} 0 0 0)"]
        d.then(trainer=put)
        d.then(l2="(kick 5 0)", idle=1)
        d.then(trainer=["(move (player left 2) 0 0)", f"(move (ball) {x} {y} 0 {vx} {vy})"], idle=2)
        d.then(r2="(kick 50 0)", idle=1)
    _line_up(d)


def _set_plays(d: Dialogue) -> None:
    kinds = ("kick_off", "kick_in", "free_kick", "corner_kick", "goal_kick", "indirect_free_kick")
    for n, kind in enumerate(kinds):
        for side, team in (("l", "left"), ("r", "right")):
            x = -20.0 + 6.0 * n
            put = [f"(move (ball) {x:g} 5 0 0 0)", f"(move (player {team} 4) {x - 0.6:g} 5 0 0 0)"]
            d.then(trainer=[*put, f"(change_mode {kind}_{side})"], idle=1)
            d.then(l4="(kick 15 0)", r4="(tackle 0)", idle=1).then(l4="(kick 15 0)", r4="(kick 15 0)", idle=1)
            aside = f"(move (player {team} 4) {-5 if side == 'l' else 5} -9)"
            d.then(trainer=["(change_mode play_on)", "(move (ball) 0 25 0 0 0)", aside])
    d.then(trainer=["(move (ball) -48 5 0 0 0)", "(change_mode goal_kick_l)"], idle=1)
    d.then(trainer="(move (player left 4) -48.6 5 0 0 0)").then(l4="(kick 20 0)", idle=1).then(
        l4="(kick 100 0)", idle=8
    )
    _line_up(d)


def _stoppages(d: Dialogue) -> None:
    for mode in PLAY_MODES.values():
        if mode == "time_over" or mode.startswith((*_JUDGED_ELSEWHERE, *_COUNTED_ON)):
            continue
        d.then(trainer=["(move (ball) 0 25 0 0 0)", f"(change_mode {mode})"], idle=1)
        d.then(l3="(kick 50 0)", r3="(tackle 10)", l4="(move -3 -3)", l1="(catch 0)", idle=1)
        if mode.startswith(("foul", "offside", "back_pass", "free_kick_fault", "catch_fault")):
            d.then(idle=30)
    for text in ("(dispfoul 10 10 1)", "(dispfoul -100 50 -1)", "(dispfoul 50 50 0)", "(dispfoul 1 1)", "(dispfoul x)"):
        d.then(monitor5=text, idle=1)
    d.then(monitor5="(dispplayer 1 3 10 -10 90)", monitorj="(dispplayer -1 3 20 -10 0)", idle=1)


def _departures(d: Dialogue) -> None:
    d.then(monitor5="(dispcard 1 2 yellow)", idle=1).then(monitor5="(dispcard 1 2 blue)", idle=1)
    d.then(monitor5="(dispcard 1 2 yellow)", l2=GONE, idle=1)
    d.then(monitor5="(dispcard -1 2 red)", r2=GONE, idle=1)
    d.then(monitor5=["(dispdiscard 1 3)", "(dispdiscard 1 9)", "(dispcard 1 9 red)"], l3=GONE, idle=1)
    d.then(monitor5="(dispcard -1 3 yellow)", idle=1)
    d.then(trainer="(change_player_type right 3 2)", idle=1)
    d.then(monitor5="(dispcard -1 3 yellow)", r4="(bye)", idle=1)
    d.then(trainer="(change_mode free_kick_l)").then(again="(reconnect left 3)", idle=1)
    d.then(again2="(reconnect left 2)", again3="(init left (version 19) (goalie))", again4="(init third (version 9))")
    d.then(again5="(reconnect right 12)", again6="(init left (version 18))", idle=1)


def keepaway() -> Dialogue:
    """Keepaway: what players do by chance, and a trainer who places them and ends episodes."""
    clients = {"trainer": "(init (version 11))", "monitor4": "(dispinit version 4)", "monitor1": "(dispinit)"}
    clients |= {f"l{k}": f"(init keepers (version {v}))" for k, v in ((1, 8), (2, 12), (3, 19))}
    clients |= {f"r{k}": f"(init takers (version {v}))" for k, v in ((1, 11), (2, 14))}
    server = {
        "keepaway": True, "keepaway_start": -1, "coach_w_referee": True, "visible_angle": 360.0, "half_time": -1,
        "forbid_kick_off_offside": False, "stamina_inc_max": 3500.0,
    }  # fmt: skip
    d = Dialogue("keepaway", server, clients)
    d.then_drawn(1, trainer=["(ear on)", "(eye on)", "(start)", *_keepaway_places()])
    d.then(trainer=_keepaway_places())
    chance = random.Random(7)
    for _ in range(12):
        d.then(trainer=[f"(move (ball) {5.0:g} {0:g} 0 0 0)", *_keepaway_places()])
        for _ in range(5):
            d.then(**{name: [_by_chance(chance)] for name in clients if name[0] in "lr"})
    d.then(trainer=["(move (ball) 0 0 0 0 0)", "(move (player takers 1) 0.5 0 0 0 0)"], idle=3)
    d.then_drawn(4)
    d.then_drawn(2, trainer=["(start)", "(change_mode play_on)", *_keepaway_places()], monitor4="(dispfoul 10 10 0)")
    d.then_drawn(2, trainer=["(move (ball) 20 0 0 0 0)"])
    return d


def _keepaway_places() -> list[str]:
    places = {
        "keepers 1": (-8, -8),
        "keepers 2": (8, -8),
        "keepers 3": (8, 8),
        "takers 1": (-8, 8),
        "takers 2": (-5, 8),
    }
    return [f"(move (player {who}) {x} {y} 0 0 0)" for who, (x, y) in places.items()]


def monitored() -> Dialogue:
    """A match of two short halves that monitors start, without a trainer."""
    clients = {"monitor3": "(dispinit version 3)", "monitorj": "(dispinit version -1)"}
    clients |= {f"l{k}": f"(init left (version {v}))" for k, v in ((1, 15), (2, 17))}
    clients |= {f"r{k}": f"(init right (version {v}))" for k, v in ((1, 13), (2, 16))}
    clients["trainer"] = "(init (version 19))"
    server = {"half_time": 3, "extra_half_time": 2, "nr_extra_halfs": 2, "penalty_shoot_outs": False}
    d = Dialogue("monitored", server, clients)
    chance = random.Random(3)
    players = [name for name in clients if name[0] in "lr"]
    d.then(l1="(move -10 -10)", l2="(move -20 -5)", r1="(move -10 -10)", r2="(move -20 -5)", monitor3="(start)", idle=1)
    d.then(monitor3="(dispstart)", idle=1).then(monitor3="(dispstart)", monitorj="(dispstart)", idle=1)
    for _ in range(30):
        d.then(**{name: [_by_chance(chance)] for name in players})
    d.then(monitorj="(dispstart)", idle=32).then(monitor3="(dispstart)", idle=22)
    d.then(monitor3="(dispstart)", idle=24).then(monitor3=["(dispstart)", "(dispfoul 1 1 1)"], l1="(kick 10 0)", idle=2)
    return d


def random_commands() -> Dialogue:
    """Soccer in which everybody says something by chance, also what is illegal, in play modes by chance."""
    d = soccer()
    d.name, d.cycles = "chance", []
    d.clients["monitor1"] = d.clients.pop("monitor2").replace(" version 2", " version 1")
    chance = random.Random(11)
    d.then(trainer=["(ear on)"])
    for mode in chance.sample(
        ["play_on", "free_kick_l", "kick_in_r", "before_kick_off", "drop_ball", "corner_kick_l"], 6
    ):
        _line_up(d)
        d.then(trainer=[f"(change_mode {mode})", "(recover)"])
        for _ in range(12):
            d.then(
                **{
                    name: [_by_chance(chance) for _ in range(chance.randint(0, 2))]
                    for name in d.clients
                    if name[0] in "lr"
                }
            )
            d.cycles[-1] |= {"trainer": [_trainer_by_chance(chance)], "monitor5": [_monitor_by_chance(chance)]}
    return d


_NUMBERS = (
    "0",
    "1",
    "-1",
    "30",
    "-30.5",
    "100",
    "1e2",
    "-100",
    "180",
    "-181",
    "1000",
    "0.001",
    "+5",
    ".5",
    "5.",
    "nan",
    "x",
)


def _by_chance(chance: random.Random) -> str:
    a, b = chance.choice(_NUMBERS), chance.choice(_NUMBERS)
    return chance.choice((
        f"(dash {a})", f"(dash {a} {b})", f"(dash (l {a} {b}))", f"(dash (l {a}) (r {b} 5))", f"(turn {a})",
        f"(turn_neck {a})", f"(kick {a} {b})", f"(tackle {a})", f"(tackle {a} true)", f"(tackle {a} off)",
        f"(catch {a})", f"(move {a} {b})",
        "(change_view wide)", "(change_view narrow low)", "(change_view normal high)", f"(change_view {a})",
        f"(pointto 10 {chance.choice((0, 33, -41, 'x'))})", "(pointto off)", "(attentionto our 2)",
        "(attentionto opp 2)", "(attentionto off)",
        f"(change_focus {a} {b})", f'(say "{a[:5]}")', "(sense_body)", "(score)", f"(clang (ver {a} {b}))",
        "(synch_see)",
        f"(turn {a})(turn_neck {b})", f"(turn_neck {a})(kick {b} 0)", f"(dash {a}", "(turn)", f"(kick {a})", "()", "",
        "(gaussian_see)", "(ear (on))", "(ear (off opp partial))", f"(turn {a}) (dash {b})", "(nonsense)", "(look)",
        f"(compression {a})" if a == "1000" else "(score)", "(start)", "(change_mode play_on)", "turn 5",
    ))  # fmt: skip


def _trainer_by_chance(chance: random.Random) -> str:
    a, b = chance.choice(_NUMBERS[:-2]), chance.choice(_NUMBERS)
    return chance.choice((
        "(check_ball)", "(look)", "(team_names)", f"(say {a})", "(ear maybe)", "(eye x)", "(recover)",
        "(change_mode x)",
        f"(move (ball) {a})", f"(move (player left 3) {a} 0 {b})", f"(move (player nobody 3) {a} 0)", "(nonsense)",
        "()",
        f"(change_player_type left 2 {a})", f"(change_player_type left {a} 2)", "(change_player_type nobody 1 1)", "",
        "(change_player_type right 3)", "(move (player right 12) 0 0)", "(move (player left))", "(dash 100)", "(init)",
    ))  # fmt: skip


def _monitor_by_chance(chance: random.Random) -> str:
    a = chance.choice(_NUMBERS)
    return chance.choice((
        "(dispstart", "(dispfoul 1 2 7)", f"(dispplayer 1 4 {a} 5 30)", "(dispplayer 3 4 1 5 30)", "(dispdiscard 1 11)",
        f"(dispdiscard {a})", "(dispcard 1 11 red)", "(dispcard 1 3 green)", "(recover)", "(look)", "(nonsense)", "",
        "(move (ball) 1", "(change_mode x)", "(check_ball)", "(change_player_type left 2 3)", "(say hello)", "(ear on)",
    ))  # fmt: skip


DIALOGUES = (soccer, keepaway, monitored, random_commands)
