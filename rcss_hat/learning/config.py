"""All settings of a learner, with the presets that ship with the package."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from importlib.resources import files
from pathlib import Path
from typing import Annotated, Any, Literal

from msgspec import Meta

from rcss_hat.inputs import excerpt, read_text
from rcss_hat.learning.features import Approximator, cmac, rbf
from rcss_hat.learning.widths import tile_widths, variable_maxima
from rcss_hat.schema import MAX_TOML, check, did_you_mean, parse_toml

Positive = Annotated[float, Meta(gt=0.0, le=sys.float_info.max, description="a positive number")]
Share = Annotated[float, Meta(ge=0.0, le=1.0, description="0.0 to 1.0")]
Decay = Annotated[float, Meta(gt=0.0, le=1.0, description="greater than 0.0 and at most 1.0")]
Cycles = Annotated[float, Meta(ge=-1e9, le=1e9, description="a number of cycles")]


@dataclass(frozen=True, slots=True, kw_only=True)
class LearnerConfig:
    """Settings of one learner; the defaults are those of the UT Austin players 0.6.

    Raises
    ------
    ValueError
        Naming the setting, its value and what would be right.

    Examples
    --------
    >>> from rcss_hat import LearnerConfig
    >>> LearnerConfig(approximator="rbf", epsilon=0.05).gamma
    1.0
    """

    name: str = "players"
    """What results call this learner."""
    description: str = "the learner of the UT Austin players 0.6"
    """One line for people."""

    approximator: Literal["cmac", "rbf"] = "cmac"
    """``cmac`` (tiles) or ``rbf`` (Gaussians)."""
    tilings: Annotated[int, Meta(ge=1, le=256, description="1 to 256")] = 32
    """Features in one tile width of a state variable, 1 to 256."""
    widths: Literal["players", "article"] = "players"
    """Tile widths: ``players`` (by the players' formula) or ``article`` (3 m and 10 degrees throughout)."""
    distance_max: Annotated[float, Meta(gt=0.0, le=10_000.0, description="a positive number up to 10000.0")] = 60.0
    """Metres; greater distances are taken for this one. Beyond any distance seen in a region of 35 m x 35 m."""
    sigma: Annotated[float, Meta(ge=0.001, le=100.0, description="0.001 to 100.0")] = 0.25
    """RBF: standard deviation in tile widths."""
    cutoff: Annotated[float, Meta(gt=0.0, le=100.0, description="a positive number up to 100.0")] = 0.75
    """RBF: distance from the centre, in tile widths, from which on the value is 0."""
    normalise: bool = False
    """RBF: scale the values of each state variable to sum 1."""

    alpha: Positive = 0.125
    """Step size before division by the divisor."""
    divisor: Literal["tiles", "norm", "one"] = "tiles"
    """What alpha is divided by: ``tiles`` (tilings x variables, as the players do), ``norm`` (mean sum of squared
    feature values, so that alpha is the share of the error by which an update moves Q(s, a)) or ``one``."""
    alpha_decay: Decay = 1.0
    """Factor of the step size per finished episode; 1: constant."""
    alpha_final: float = 0.0
    """Alpha below which its decay stops."""
    epsilon: Share = 0.01
    """Probability of an exploratory action per decision."""
    epsilon_decay: Decay = 1.0
    """Factor of epsilon per finished episode; 1: constant."""
    epsilon_final: Share = 0.0
    """Epsilon below which its decay stops."""
    gamma: Share = 1.0
    """Discount per decision; 1, as rewards are durations."""
    lambda_: Share = 0.0
    """Decay of eligibility traces per decision (``lambda`` in files); 0: none."""
    hold_cycles: Annotated[int, Meta(ge=1, le=100, description="1 to 100")] = 1
    """Cycles a Hold lasts before the keeper decides again; 1: it decides in every cycle, as the players do."""
    trace_minimum: Share = 0.01
    """Traces below this are dropped."""
    initial_value: Cycles = 0.0
    """Cycles: value of every action in every state before learning, spread evenly over the features."""

    def __post_init__(self) -> None:
        """Check every setting."""
        check(self)
        if not 0.0 <= self.alpha_final <= self.alpha:
            raise ValueError(f"alpha_final must be 0.0 to {self.alpha}, not {self.alpha_final!r}")
        if self.epsilon_final > self.epsilon:
            raise ValueError(f"epsilon_final ({self.epsilon_final}) must not exceed epsilon ({self.epsilon})")

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
        if not isinstance(settings, Mapping):
            raise ValueError(f"settings of a learner must be a table, not {excerpt(settings)}")
        known = {_file_name(field.name): field.name for field in fields(cls)}
        for key in sorted(set(settings) - set(known)):
            there = ", ".join(known)
            raise ValueError(f"unknown learner setting {excerpt(key)}; known are {there}{did_you_mean(key, known)}")
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

    Examples
    --------
    >>> from rcss_hat import load_config
    >>> load_config("paper").approximator
    'rbf'
    """
    name = str(name_or_path)
    if name.endswith(".toml") and not Path(name).exists():
        raise FileNotFoundError(f"there is no learner file {name}")
    if not name.endswith(".toml") and name not in preset_names():
        there = ", ".join(preset_names())
        near = did_you_mean(name, preset_names())
        raise ValueError(f"no learner preset {name!r}; there are {there}, or give a file that ends in .toml{near}")
    preset = files("rcss_hat.learning") / "presets" / f"{name}.toml"
    try:
        own = name.endswith(".toml")
        text = read_text(Path(name), "learner", MAX_TOML) if own else preset.read_text(encoding="utf-8")
        return LearnerConfig.from_dict({"name": Path(name).stem, **parse_toml(text)})
    except ValueError as problem:
        raise ValueError(f"learner preset {name}: {problem}") from problem


def _file_name(field_name: str) -> str:
    return field_name.removesuffix("_")
