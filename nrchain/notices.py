"""How a run tells of what it was not made for: by Python's warnings, or to whoever wants the words.

The filters of warnings belong to the process: who wants no warnings takes the words.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Callable

from nrchain.errors import SceneWarning

Tell = Callable[[str], None]


def warn(text: str) -> None:
    """Warn with :class:`~nrchain.errors.SceneWarning`, at the line that called the package."""
    level, frame = 1, sys._getframe()
    while frame.f_back is not None and frame.f_globals["__name__"].startswith("nrchain."):
        level, frame = level + 1, frame.f_back
    warnings.warn(text, SceneWarning, stacklevel=level)


def nobody(text: str) -> None:
    """Tell nobody."""
