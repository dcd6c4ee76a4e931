"""Keepaway for PettingZoo: every keeper an agent, with its own perception; on demand every taker, too.

``keepaway_v0.env(...)`` and ``keepaway_v0.parallel_env(...)`` take the options of
`rcss_hat.envs.keepaway_env.KeepawayEnv` that say what is played (``size``, ``field``, ``vision``, ``profile``,
``stage``, ``takers``, ``hold_cycles``, ``max_cycles``, ``normalize``), and those of `rcss_hat.envs.agents.Agents`.
"""

from __future__ import annotations

from typing import Any

from pettingzoo.utils.conversions import parallel_to_aec
from pettingzoo.utils.env import AECEnv
from pettingzoo.utils.wrappers import OrderEnforcingWrapper

from rcss_hat.envs.agents import TAKER_CYCLES, TEAM, Agents
from rcss_hat.envs.options import PER_CYCLE, PER_DECISION, Options
from rcss_hat.envs.parallel import KeepawayParallelEnv
from rcss_hat.envs.turns import KeepawayTurnsEnv

__all__ = ["env", "parallel_env"]


def parallel_env(
    reward: str = TEAM,
    taker_agents: bool = False,
    taker_cycles: int = TAKER_CYCLES,
    render_mode: str | None = None,
    **options: Any,
) -> KeepawayParallelEnv:
    """Return Keepaway with all agents acting at once: a step is one cycle.

    Agents are ``keeper_1`` .. ``keeper_n``, and with ``taker_agents`` ``taker_1`` .. ``taker_m``. Who has to decide in
    a cycle has an ``info["action_mask"]`` with more than the action 0; the others' actions do nothing. An agent that
    decides observes its state variables of this cycle, the others observe what they believed at the end of the last;
    before somebody knows where everybody is, all is as far as can be.

    Parameters
    ----------
    reward, taker_agents, taker_cycles, render_mode
        See `rcss_hat.envs.agents.Agents`.
    **options
        See the module.

    Raises
    ------
    ValueError
        Naming what would be right; with ``taker_agents`` on servers, where `env` with ``per="decision"`` plays.
    """
    return KeepawayParallelEnv(Agents(Options(**options), reward, taker_agents, taker_cycles, True, render_mode))


def env(
    reward: str = TEAM,
    taker_agents: bool = False,
    taker_cycles: int = TAKER_CYCLES,
    per: str = PER_CYCLE,
    render_mode: str | None = None,
    **options: Any,
) -> AECEnv[str, Any, int]:
    """Return Keepaway turn by turn.

    Parameters
    ----------
    reward, taker_agents, taker_cycles, render_mode
        See `rcss_hat.envs.agents.Agents`.
    per : {"cycle", "decision"}
        ``"cycle"``: in every cycle all agents take their turn, as in `parallel_env`. ``"decision"``: only those who
        have to decide do, which is the paper's view, and much faster.
    **options
        See the module.
    """
    if per == PER_DECISION:
        return KeepawayTurnsEnv(Agents(Options(**options), reward, taker_agents, taker_cycles, False, render_mode))
    chosen = Options(per=per, **options)
    agents = Agents(chosen, reward, taker_agents, taker_cycles, True, render_mode)
    return OrderEnforcingWrapper(parallel_to_aec(KeepawayParallelEnv(agents)))
