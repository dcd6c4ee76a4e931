"""How many participants a study needs: its power, by simulation from a rehearsal or a pilot."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

from rcss_hat.studies.inference import Components

SIMULATIONS = 2_000
LEVEL = 0.05


@dataclass(frozen=True, slots=True)
class Power:
    """How often a comparison would be significant.

    Attributes
    ----------
    first, second : str
        Conditions.
    difference : float
        Of their means, as assumed: seconds.
    participants : int
        Of each of the two conditions; within subjects, of both.
    games : int
        Of each participant in each condition.
    power : float
        Share of the simulated studies with p < 0.05.
    """

    first: str
    second: str
    difference: float
    participants: int
    games: int
    power: float


def power_of(
    means: Mapping[str, float],
    variance: Components,
    participants: Sequence[int],
    games: int,
    design: str = "between",
    seed: int = 0,
) -> list[Power]:
    """Simulate studies and test each as `rcss_hat.studies.inference` does.

    Every simulated participant has a true mean of his own, drawn around that of his condition, and games around it.
    Within subjects the same participant meets both conditions with the same deviation, which cancels.

    Parameters
    ----------
    means : mapping of str to float
        By condition, seconds.
    variance : Components
    participants : sequence of int
        Sizes to try, per condition.
    games : int
        Per participant and condition.
    design : {"between", "within"}
    seed : int
    """
    rng = np.random.default_rng(seed)
    noise = variance.within / np.sqrt(games)
    names, found = list(means), []
    for k, first in enumerate(names):
        for second in names[k + 1 :]:
            for n in participants:
                shape = (SIMULATIONS, n)
                if design == "within":
                    own = variance.between * rng.standard_normal(shape)
                    a, b = (means[c] + own + noise * rng.standard_normal(shape) for c in (first, second))
                    p = stats.ttest_1samp(a - b, 0.0, axis=1).pvalue
                else:
                    spread = np.hypot(variance.between, noise)
                    a, b = (means[c] + spread * rng.standard_normal(shape) for c in (first, second))
                    p = stats.ttest_ind(a, b, axis=1, equal_var=False).pvalue
                share = float(np.mean(p < LEVEL))
                found.append(Power(first, second, means[first] - means[second], n, games, share))
    return found
