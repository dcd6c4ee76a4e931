"""All settings of a learner, with the presets that ship with the package."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from importlib.resources import files
from pathlib import Path
from typing import Any

from rcss_hat.learning.features import Approximator, cmac, rbf
from rcss_hat.learning.widths import WIDTH_RULES, tile_widths, variable_maxima

APPROXIMATORS = ("cmac", "rbf")
DIVISORS = ("tiles", "norm", "one")


@dataclass(frozen=True, slots=True, kw_only=True)
class LearnerConfig:
    """Settings of one learner; the defaults are those of the UT Austin players 0.6.

    Raises
    ------
    ValueError
        Naming the setting, its value and what would be right.
    """

    name: str = "players"
    """What results call this learner."""
    description: str = "the learner of the UT Austin players 0.6"
    """One line for people."""

    approximator: str = "cmac"
    """``cmac`` (tiles) or ``rbf`` (Gaussians)."""
    tilings: int = 32
    """Features in one tile width of a state variable, 1 to 256."""
    widths: str = "players"
    """Tile widths: ``players`` (by the players' formula) or ``article`` (3 m and 10 degrees throughout)."""
    distance_max: float = 60.0
    """Metres; greater distances are taken for this one. Beyond any distance seen in a region of 35 m x 35 m."""
    sigma: float = 0.25
    """RBF: standard deviation in tile widths."""
    cutoff: float = 0.75
    """RBF: distance from the centre, in tile widths, from which on the value is 0."""
    normalise: bool = False
    """RBF: scale the values of each state variable to sum 1."""

    alpha: float = 0.125
    """Step size before division by the divisor."""
    divisor: str = "tiles"
    """What alpha is divided by: ``tiles`` (tilings x variables, as the players do), ``norm`` (mean sum of squared
    feature values, so that alpha is the share of the error by which an update moves Q(s, a)) or ``one``."""
    alpha_decay: float = 1.0
    """Factor of the step size per finished episode; 1: constant."""
    alpha_final: float = 0.0
    """Alpha below which its decay stops."""
    epsilon: float = 0.01
    """Probability of an exploratory action per decision."""
    epsilon_decay: float = 1.0
    """Factor of epsilon per finished episode; 1: constant."""
    epsilon_final: float = 0.0
    """Epsilon below which its decay stops."""
    gamma: float = 1.0
    """Discount per decision; 1, as rewards are durations."""
    lambda_: float = 0.0
    """Decay of eligibility traces per decision (``lambda`` in files); 0: none."""
    hold_cycles: int = 1
    """Cycles a Hold lasts before the keeper decides again; 1: it decides in every cycle, as the players do."""
    trace_minimum: float = 0.01
    """Traces below this are dropped."""
    initial_value: float = 0.0
    """Cycles: value of every action in every state before learning, spread evenly over the features."""

    def __post_init__(self) -> None:
        """Check every setting."""
        self._one_of("approximator", APPROXIMATORS)
        self._one_of("widths", WIDTH_RULES)
        self._one_of("divisor", DIVISORS)
        self._between("tilings", 1, 256)
        self._between("hold_cycles", 1, 100)
        for name in ("distance_max", "sigma", "cutoff", "alpha"):
            if not (_is_number(getattr(self, name)) and getattr(self, name) > 0.0):
                raise ValueError(f"{name} must be a positive number, not {getattr(self, name)!r}")
        for name in ("epsilon", "epsilon_final", "gamma", "lambda_", "trace_minimum"):
            self._between(name, 0.0, 1.0)
        for name in ("alpha_decay", "epsilon_decay"):
            self._between(name, 0.0, 1.0, above=True)
        self._between("alpha_final", 0.0, self.alpha)
        if self.epsilon_final > self.epsilon:
            raise ValueError(f"epsilon_final ({self.epsilon_final}) must not exceed epsilon ({self.epsilon})")
        if not _is_number(self.initial_value):
            raise ValueError(f"initial_value must be a number of cycles, not {self.initial_value!r}")
        if not isinstance(self.normalise, bool):
            raise ValueError(f"normalise must be true or false, not {self.normalise!r}")
        for name in ("tilings", "hold_cycles"):
            if not isinstance(getattr(self, name), int) or isinstance(getattr(self, name), bool):
                raise ValueError(f"{name} must be an integer, not {getattr(self, name)!r}")

    def _one_of(self, name: str, known: tuple[str, ...]) -> None:
        if getattr(self, name) not in known:
            raise ValueError(f"{_file_name(name)} must be one of {', '.join(known)}, not {getattr(self, name)!r}")

    def _between(self, name: str, low: float, high: float, above: bool = False) -> None:
        value = getattr(self, name)
        if not (_is_number(value) and low <= value <= high) or (above and value == low):
            begin = f"greater than {low} and at most" if above else f"{low} to"
            raise ValueError(f"{_file_name(name)} must be {begin} {high}, not {value!r}")

    def build(self, n_keepers: int, n_takers: int) -> Approximator:
        """Make the approximator for n v m Keepaway.

        Raises
        ------
        ValueError
            For fewer than 3 keepers or 2 takers.
        """
        widths = tile_widths(n_keepers, n_takers, self.widths)
        maxima = variable_maxima(n_keepers, n_takers, self.distance_max)
        if self.approximator == "cmac":
            return cmac(widths, maxima, self.tilings)
        return rbf(widths, maxima, self.tilings, self.sigma, self.cutoff, self.normalise)

    def divisor_for(self, approximator: Approximator) -> float:
        """Return the number alpha is divided by."""
        return {"tiles": float(approximator.n_tiles), "norm": approximator.norm, "one": 1.0}[self.divisor]

    def effective_step(self, approximator: Approximator) -> float:
        """Return the share of the error by which an update moves Q(s, a), on average over places."""
        return self.alpha * approximator.norm / self.divisor_for(approximator)

    def to_dict(self) -> dict[str, Any]:
        """Return all settings under the names they have in files."""
        return {_file_name(field.name): getattr(self, field.name) for field in fields(self)}

    @classmethod
    def from_dict(cls, settings: Mapping[str, Any]) -> LearnerConfig:
        """Make a configuration from settings as files hold them; what is not named keeps its default.

        Raises
        ------
        ValueError
            For an unknown setting, or a value that is not allowed.
        """
        known = {_file_name(field.name): field.name for field in fields(cls)}
        unknown = sorted(set(settings) - set(known))
        if unknown:
            raise ValueError(f"unknown learner setting {unknown[0]!r}; known are {', '.join(known)}")
        return cls(**{known[key]: value for key, value in settings.items()})

    def with_changes(self, **changes: Any) -> LearnerConfig:
        """Return a copy with some settings changed, by field name."""
        return replace(self, **changes)


def preset_names() -> list[str]:
    """Names of the presets in the package."""
    folder = files("rcss_hat.learning") / "presets"
    return sorted(entry.name.removesuffix(".toml") for entry in folder.iterdir() if entry.name.endswith(".toml"))


def load_config(name_or_path: str | Path) -> LearnerConfig:
    """Load a preset of the package, or a TOML file of the same form.

    Parameters
    ----------
    name_or_path : str or Path
        ``"cmac"``, ``"paper"``, ``"best"``, or a path that ends in ``.toml``.

    Raises
    ------
    ValueError
        When there is no such preset, or the file is not valid; the message names the file.
    FileNotFoundError
        When there is no such file.
    """
    name = str(name_or_path)
    if name.endswith(".toml"):
        text = Path(name).read_text(encoding="utf-8")
    elif name in preset_names():
        text = (files("rcss_hat.learning") / "presets" / f"{name}.toml").read_text(encoding="utf-8")
    else:
        raise ValueError(
            f"no learner preset {name!r}; there are {', '.join(preset_names())}, or give a file that ends in .toml"
        )
    try:
        settings = tomllib.loads(text)
        return LearnerConfig.from_dict({"name": Path(name).stem, **settings})
    except (tomllib.TOMLDecodeError, ValueError) as problem:
        raise ValueError(f"learner preset {name}: {problem}") from problem


def _file_name(field_name: str) -> str:
    return field_name.removesuffix("_")


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and math.isfinite(value)
