"""What poses are, and what gives them at a time."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    import numpy as np

Poses: TypeAlias = "tuple[np.ndarray, np.ndarray]"
"""Positions (N, 3) and frames (N, 3, 3): e_{k+1} of sphere i in ``frames[i, k]``, lab
components."""

PosesAt: TypeAlias = "Callable[[float], Poses]"
"""Poses at a time, in arrays of their own."""
