"""The state of a process that a library may not change, as one comparable value."""

from __future__ import annotations

import gc
import locale
import logging
import os
import random
import signal
import sys
import threading
import warnings
from typing import Any

import matplotlib
import numpy as np


def handlers() -> dict[str, Any]:
    """The signal handlers, which a run in the main thread replaces while it goes on."""
    return {
        s.name: signal.getsignal(s) for s in signal.valid_signals() if isinstance(s, signal.Signals)
    }


def state() -> dict[str, Any]:
    """Everything but the signal handlers: the same before, during and after a run."""
    mask = os.umask(0)
    os.umask(mask)
    return {
        "streams": (sys.stdin, sys.stdout, sys.stderr),
        "hooks": (sys.excepthook, sys.displayhook, threading.excepthook, warnings.showwarning),
        "warning filters": list(warnings.filters),
        "floating-point errors": np.geterr() | {"call": np.geterrcall()},
        "how arrays are printed": np.get_printoptions(),
        "random numbers": (random.getstate(), repr(np.random.get_state())),  # noqa: NPY002
        "environment": dict(os.environ),
        "folder": os.getcwd(),
        "file mode mask": mask,
        "locale": locale.setlocale(locale.LC_ALL),
        "logging": (logging.root.level, list(logging.root.handlers), logging.raiseExceptions),
        "interpreter": (sys.getrecursionlimit(), sys.getswitchinterval(), gc.isenabled()),
        "import path": list(sys.path),
        "threads": {thread for thread in threading.enumerate() if thread.is_alive()},
        "matplotlib": dict(matplotlib.rcParams),
    }


def changes(before: dict[str, Any], after: dict[str, Any]) -> dict[str, tuple[Any, Any]]:
    """What differs, by name, as it was and as it is."""
    return {name: (before[name], after[name]) for name in before if before[name] != after[name]}
