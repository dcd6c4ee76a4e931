"""Compiling what a player does before a server waits for an answer."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from rcss_hat.keepaway import agent as players
from rcss_hat.keepaway.moved import new_sightings, somebody_was_moved
from rcss_hat.keepaway.state import n_state_variables
from rcss_hat.keepaway.taker_state import n_taker_variables, taker_state_variables
from rcss_hat.protocol.commands import action_to_bytes
from rcss_hat.protocol.records import ACTION, HEARD, LEFT, RIGHT, SEE, SENSE_BODY, empty
from rcss_hat.protocol.warm_up import warm_up as warm_up_messages


def warm_up(n_keepers: int, n_takers: int, params: NDArray[np.void]) -> None:
    """Compile, or load from the cache, every kernel of a player and of its messages, by running it once.

    Parameters
    ----------
    n_keepers, n_takers : int
    params : KERNEL_PARAMS, shape (1,)
        Of the server.
    """
    sense, see, heard, action = empty(SENSE_BODY), empty(SEE), empty(HEARD), empty(ACTION)
    heard["time"][0] = -1
    for side in (LEFT, RIGHT):
        agent = players.new_agent(side, 1, n_keepers, n_takers, params, 0)
        players.perceive(agent, params, sense, see, True, heard, True)
        players.act(agent, params, 0, 0, action)
    players.decide(agent, np.zeros(n_state_variables(n_keepers, n_takers)))
    taker_state_variables(agent, np.zeros(n_taker_variables(n_keepers, n_takers)))
    somebody_was_moved(agent, params, see, new_sightings())
    action_to_bytes(action)
    warm_up_messages()
