"""Arrays of positions."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ._errors import misuse

Positions = NDArray[np.float64]
"""Positions of vertices, n × 3."""


def positions_of(values: Any, what: str) -> Positions:
    """Values as an array that can be read in one go; it is copied only where it is none yet."""
    array = np.ascontiguousarray(values, dtype=np.float64)
    if array.ndim != 2 or array.shape[1] != 3:
        raise misuse(f"{what}: expected an array of n × 3 numbers, found one of the shape {array.shape}")
    return array
