"""Warnings of a run: Python's warnings, or a function that gets their text.

The filters of Python's warnings belong to the whole process. A caller that wants none passes
:func:`ignore` in place of :func:`warn`.
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Callable

from nrchain.errors import SceneWarning

Report = Callable[[str], None]
"""What gets the text of a warning."""


def warn(text: str) -> None:
    """Warn with :class:`~nrchain.errors.SceneWarning`, at the line that called the package."""
    level, frame = 1, sys._getframe()
    while frame.f_back is not None and frame.f_globals["__name__"].startswith("nrchain."):
        level, frame = level + 1, frame.f_back
    warnings.warn(text, SceneWarning, stacklevel=level)


def ignore(text: str) -> None:
    """Do nothing with a warning."""
