"""A Keepaway task: how many play, where, and what they see."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

from rcss_hat.inputs import FileFormatError, item
from rcss_hat.protocol.params import PROFILES, ServerParams, Value


@dataclass(frozen=True, slots=True)
class Task:
    """A Keepaway task.

    Attributes
    ----------
    keepers, takers : int
    length, width : float
        Region in metres, centred on the pitch.
    vision : int
        View angle in degrees at normal width: 360 or 90.
    profile : {"19.0", "11.1"}
        Whose physics.

    Examples
    --------
    >>> from rcss_hat import Task
    >>> Task()
    Task(keepers=3, takers=2, length=20.0, width=20.0, vision=360, profile='19.0')
    >>> Task.parse("4v3").field
    '30x30'
    """

    keepers: int = 3
    takers: int = 2
    length: float = 20.0
    width: float = 20.0
    vision: int = 360
    profile: str = "19.0"

    def __post_init__(self) -> None:
        if not 3 <= self.keepers <= 11 or not 2 <= self.takers <= 11:
            raise ValueError(f"Keepaway takes 3 to 11 keepers and 2 to 11 takers, not {self.keepers}v{self.takers}")
        if not 8.0 <= self.length <= 100.0 or not 8.0 <= self.width <= 64.0:
            region = f"{self.length:g}x{self.width:g}"
            raise ValueError(f"the region must be 8 to 100 m long and 8 to 64 m wide, not {region}")
        if not 1 <= self.vision <= 360:
            raise ValueError(f"vision is an angle of 1 to 360 degrees, not {self.vision}")
        if self.profile not in PROFILES:
            raise ValueError(f"unknown profile {self.profile!r}; known are {', '.join(PROFILES)}")

    @classmethod
    def parse(cls, size: str = "3v2", field: str | None = None, vision: int = 360, profile: str = "19.0") -> Task:
        """Make a task from what people write.

        Parameters
        ----------
        size : str
            ``"3v2"``.
        field : str, optional
            ``"20x20"`` (metres); by default the usual region of that size: 20, 30 (4v3) or 35 m (5v4).

        Raises
        ------
        ValueError
            Naming what would be right.
        """
        match = re.fullmatch(r"(\d+)v(\d+)", size)
        if not match:
            raise ValueError(f"size is written KEEPERSvTAKERS, for example 3v2, not {size!r}")
        keepers, takers = int(match[1]), int(match[2])
        if field is None:
            side = {3: 20.0, 4: 30.0}.get(keepers, 35.0)
            length, width = side, side
        else:
            region = re.fullmatch(r"(\d+(?:\.\d+)?)x(\d+(?:\.\d+)?)", field)
            if not region:
                raise ValueError(f"field is written LENGTHxWIDTH in metres, for example 20x20, not {field!r}")
            length, width = float(region[1]), float(region[2])
        return cls(keepers, takers, length, width, vision, profile)

    @classmethod
    def from_dict(cls, data: Any) -> Task:
        """Make a task from the JSON data that ``dataclasses.asdict`` gave.

        Raises
        ------
        FileFormatError
            Naming what is missing, or what would be right.
        """
        try:
            return cls(
                item(data, "keepers", int, "task"),
                item(data, "takers", int, "task"),
                float(item(data, "length", (int, float), "task")),
                float(item(data, "width", (int, float), "task")),
                item(data, "vision", int, "task"),
                item(data, "profile", str, "task"),
            )
        except FileFormatError:
            raise
        except ValueError as error:
            raise FileFormatError(f"task: {error}") from error

    @property
    def size(self) -> str:
        """Such as ``3v2``."""
        return f"{self.keepers}v{self.takers}"

    @property
    def field(self) -> str:
        """Such as ``20x20``."""
        return f"{self.length:g}x{self.width:g}"

    def server_values(self) -> dict[str, Value]:
        """Return the server parameters of the UT Austin start script for this task (synch mode)."""
        return {
            "half_time": -1,
            "use_offside": False,
            "forbid_kick_off_offside": False,
            "stamina_inc_max": 3500.0,
            "synch_mode": True,
            "synch_offset": 80,
            "keepaway": True,
            "keepaway_length": self.length,
            "keepaway_width": self.width,
            "visible_angle": float(self.vision),
        }

    def params(self) -> ServerParams:
        """Return all server parameters of this task, as a server would tell them."""
        return ServerParams(self.profile, **self.server_values())
