"""JSON as rcssserver writes it: no blanks, numbers with six significant digits (``%g``)."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence


def json_text(value: object) -> str:
    """Return a value as JSON.

    Parameters
    ----------
    value : None, bool, int, float, str, or a mapping or sequence of such
        Texts are escaped, which the original does not do with control characters and bytes above 127.
    """
    if isinstance(value, Mapping):
        return "{" + ",".join(f'"{key}":{json_text(member)}' for key, member in value.items()) + "}"
    if isinstance(value, float):
        return f"{value:g}"
    if isinstance(value, Sequence) and not isinstance(value, str):
        return "[" + ",".join(map(json_text, value)) + "]"
    return json.dumps(value)
