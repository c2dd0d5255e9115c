"""The errors a user can cause. Each says what was given, where, and what is allowed.

Each can be pickled, and so reaches whoever waits for a worker of a process pool.
"""

from __future__ import annotations

import pickle
from typing import Any


class _NotGiven:
    """Stands for the value of a key that must be given and was not."""

    def __repr__(self) -> str:
        return "not given"

    def __reduce__(self) -> str:
        return "NOT_GIVEN"


NOT_GIVEN = _NotGiven()

SYSTEMS = "nrchain runs on Linux and macOS, and on Windows inside WSL."
"""What it runs on, as the README says it."""


class NrchainError(Exception):
    """Base of every documented error of nrchain."""


class SceneError(NrchainError, ValueError):
    """A scene, or an argument, that cannot be simulated; raised before any time is spent.

    ``key`` is the scene key (``chain.spacing``) or argument name, ``value`` what was given, or
    :data:`NOT_GIVEN`, and ``allowed`` a sentence on what would be accepted.
    """

    def __init__(self, key: str, value: object, allowed: str) -> None:
        self.key, self.value, self.allowed = key, value, allowed
        given = " is not given" if value is NOT_GIVEN else f" = {shorten(value)}"
        super().__init__(f"{key}{given}: {allowed}")

    def __reduce__(self) -> tuple[Any, ...]:
        value = _portable(self.value)
        state = vars(self) | {"value": value, "args": self.args}
        return type(self), (self.key, value, self.allowed), state


class SceneWarning(UserWarning):
    """A scene that is simulated as it is, and may not show what it was made for."""


class UnknownNameError(NrchainError, KeyError):
    """A name by which nothing is found, such as that of an effect; says which names there are."""

    def __str__(self) -> str:
        # a KeyError would quote the sentence
        return Exception.__str__(self)


class BackendError(NrchainError, RuntimeError):
    """A pair-law backend that is missing, of an unknown release, or fails its self-check."""


class PlatformError(NrchainError, ImportError):
    """A system without what nrchain needs of it, found where the part that needs it is imported."""

    def __init__(self, systems: str = SYSTEMS) -> None:
        super().__init__(systems)


class TrajectoryError(NrchainError, OSError):
    """A trajectory file that is missing, not ours, damaged, or would be overwritten."""


class _Shown:
    """Stands for a value that cannot be pickled: it is shown as that was."""

    def __init__(self, text: str) -> None:
        self._text = text

    def __repr__(self) -> str:
        return self._text


def _portable(value: object) -> object:
    """The value, or how it is shown where it comes to no other process.

    What cannot be unpickled stops the thread of a pool that hands results on, for ever.
    """
    try:
        pickle.loads(pickle.dumps(value))
    except Exception:
        return _Shown(shorten(value))
    return value


def shorten(value: object, limit: int = 80) -> str:
    """The value as messages show it."""
    try:
        text = repr(value)
    except ValueError:
        # Python spells out no integer of more than 4300 digits, in a list or by itself
        kind = type(value).__name__
        text = hex(value) if isinstance(value, int) else f"a {kind} of huge integers"
    return text if len(text) <= limit else text[: limit - 1] + "…"
