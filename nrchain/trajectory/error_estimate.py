"""The estimated error of one snapshot."""

from __future__ import annotations

import math
from typing import NamedTuple


class ErrorEstimate(NamedTuple):
    """The largest error over the spheres: of positions in units of length, of frames in radians."""

    position: float
    frame: float


NOT_KNOWN = ErrorEstimate(math.nan, math.nan)
"""The error of a snapshot for which there is no estimate."""
