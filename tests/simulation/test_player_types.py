from __future__ import annotations

import json

from simulation_samples import DATA, FREE, QUIET, World

from rcss_hat.protocol.params import ServerParams
from rcss_hat.simulation import cycle
from rcss_hat.simulation.player_types import PLAYER_TYPE, player_parameters, player_types
from rcss_hat.simulation.state import substitute


def test_a_seed_gives_the_types_of_the_real_server() -> None:
    recorded = json.loads((DATA / "player-types.json").read_text())
    params = ServerParams(stamina_inc_max=recorded["stamina_inc_max"])
    types = player_types(params, recorded["random_seed"])
    assert len(types) == len(recorded["types"]) == 18
    for k, entry in enumerate(recorded["types"]):
        for name, value in entry.items():
            assert float(f"{types[name][k]:g}") == value, (k, name)


def test_type_0_is_the_server_parameters() -> None:
    params = ServerParams(player_decay=0.5, effort_init=0.9)
    first = player_types(params, 1)[0]
    assert first["player_decay"] == 0.5
    assert first["effort_max"] == 0.9
    assert first["kick_rand"] == params["kick_rand"]
    assert first["catchable_area_l_stretch"] == 1.0


def test_types_differ_between_seeds_and_are_traded_off() -> None:
    params = ServerParams()
    a, b = player_types(params, 1), player_types(params, 2)
    assert (a["player_decay"][1:] != b["player_decay"][1:]).all()
    inertia = 5.0 + 25.0 * (a["player_decay"] - 0.4)
    assert abs(a["inertia_moment"] - inertia).max() < 1e-12
    top = 100.0 * a["dash_power_rate"] * a["effort_max"] / (1.0 - a["player_decay"])
    assert ((top > 0.75 - 1e-9) & (top < 1.05 + 1e-9)).all()


def test_version_11_has_seven_types() -> None:
    assert len(player_types(ServerParams("11.1"), 1)) == 7


def test_impossible_trades_give_the_default() -> None:
    types = player_types(
        ServerParams(), 1, {"new_dash_power_rate_delta_min": 1.0, "new_dash_power_rate_delta_max": 2.0}
    )
    assert (types["dash_power_rate"] == 0.006).all()
    assert set(player_parameters(ServerParams())) >= {"player_types", "subs_max"}
    assert PLAYER_TYPE.names is not None and PLAYER_TYPE.names[0] == "player_speed_max"


def test_a_substitute_runs_as_his_type_does() -> None:
    world = World("l1", **FREE, **QUIET).play().put("l1", 0.0, 0.0).put("b", 9.0, 9.0)
    world.match["stamina"][0, 0] = 10.0
    substitute(world.state, 0, 5)
    entry = world.types[5]
    assert world.match["stamina"][0, 0] == 8000.0
    world.command("l1", "(dash 100)")
    cycle.step(world.state)
    want = 100.0 * entry["dash_power_rate"] * entry["effort_max"] * entry["player_decay"]
    assert abs(world.match["vel"][0, 0, 0] - want) < 1e-12
