"""The errors that a user can cause. Each states what was given, where, and what is allowed.

All of them can be pickled, so that a process pool can hand them on.
"""

from __future__ import annotations

import pickle
from typing import Any


class _NotGiven:
    """The value of a required key that is missing."""

    def __repr__(self) -> str:
        return "not given"

    def __reduce__(self) -> str:
        return "NOT_GIVEN"


NOT_GIVEN = _NotGiven()

SYSTEMS = "nrchain runs on Linux and macOS, and on Windows inside WSL."
"""The supported systems, in the words of the README."""


class Words(str):
    """What an error shows in place of a value that is too long to show; without quotes.

    >>> raise SceneError("guess", Words("the given poses"), "leads to no state")
    Traceback (most recent call last):
    nrchain.errors.SceneError: guess = the given poses: leads to no state
    """

    __slots__ = ()

    def __repr__(self) -> str:
        return str(self)


class NrchainError(Exception):
    """Base class of all errors of nrchain.

    >>> issubclass(SceneError, NrchainError)
    True
    """


class SceneError(NrchainError, ValueError):
    """A scene or an argument that cannot be simulated; raised before the run starts.

    Attributes
    ----------
    key
        The scene key, such as ``chain.spacing``, or the name of the argument.
    value
        What was given, or :data:`NOT_GIVEN`.
    allowed
        What is accepted, in words.

    >>> raise SceneError("chain.spacing", 1.0, "must exceed two radii")
    Traceback (most recent call last):
    nrchain.errors.SceneError: chain.spacing = 1.0: must exceed two radii
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
    """A scene that is simulated, but may not show what its user expects.

    >>> import warnings
    >>> warnings.simplefilter("ignore", SceneWarning)  # in a program that knows
    """


class UnknownNameError(NrchainError, KeyError):
    """An unknown name, such as that of an effect; the message lists the known ones.

    >>> from nrchain import load_scene
    >>> try:
    ...     load_scene("buckling").slip.modes["2a"]
    ... except UnknownNameError as error:
    ...     "did you mean '2s'" in str(error)
    True
    """

    def __str__(self) -> str:
        # KeyError would put quotes around the sentence
        return Exception.__str__(self)


class BackendError(NrchainError, RuntimeError):
    """A backend of pair laws that is missing, has an unknown version, or fails its self-check.

    >>> raise BackendError("PyStokes 9.9 is not known")
    Traceback (most recent call last):
    nrchain.errors.BackendError: PyStokes 9.9 is not known
    """


class PlatformError(NrchainError, ImportError):
    """A system that lacks what nrchain needs; raised on import of the part that needs it."""

    def __init__(self, systems: str = SYSTEMS) -> None:
        super().__init__(systems)


class MissingLibraryError(NrchainError, ImportError):
    """An optional library that is not installed; the message names the extra that brings it."""


class TrajectoryError(NrchainError, OSError):
    """A trajectory file that is missing, foreign or damaged, or would be overwritten.

    >>> from nrchain import Trajectory
    >>> try:
    ...     Trajectory.open("nowhere")
    ... except TrajectoryError as error:
    ...     print(error)
    nowhere: there is no such trajectory
    """


class _Shown:
    """A stand-in for a value that cannot be pickled, with the same ``repr``."""

    def __init__(self, text: str) -> None:
        self._text = text

    def __repr__(self) -> str:
        return self._text


def _portable(value: object) -> object:
    """The value, or a stand-in if it cannot be pickled and unpickled.

    A value that cannot be unpickled would block the result thread of a process pool for ever.
    """
    try:
        pickle.loads(pickle.dumps(value))
    except Exception:
        return _Shown(shorten(value))
    return value


def shorten(value: object, limit: int = 80) -> str:
    """The ``repr`` of a value, cut to ``limit`` characters, as messages show it."""
    try:
        text = repr(value)
    except ValueError:
        # Python prints no integer of more than 4300 digits, alone or in a list
        kind = type(value).__name__
        text = hex(value) if isinstance(value, int) else f"a {kind} of huge integers"
    return text if len(text) <= limit else text[: limit - 1] + "…"
