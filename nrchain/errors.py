"""The errors a user can cause. Each says what was given, where, and what is allowed."""


class _NotGiven:
    """Stands for the value of a key that must be given and was not."""

    def __repr__(self) -> str:
        return "not given"


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


class SceneWarning(UserWarning):
    """A scene that is simulated as it is, and may not show what it was made for."""


class BackendError(NrchainError, RuntimeError):
    """A pair-law backend that is missing, of an unknown release, or fails its self-check."""


class PlatformError(NrchainError, ImportError):
    """A system without what nrchain needs of it, found where the part that needs it is imported."""

    def __init__(self, systems: str = SYSTEMS) -> None:
        super().__init__(systems)


class TrajectoryError(NrchainError, OSError):
    """A trajectory file that is missing, not ours, damaged, or would be overwritten."""


def shorten(value: object, limit: int = 80) -> str:
    """The value as messages show it."""
    try:
        text = repr(value)
    except ValueError:
        # Python spells out no integer of more than 4300 digits, in a list or by itself
        kind = type(value).__name__
        text = hex(value) if isinstance(value, int) else f"a {kind} of huge integers"
    return text if len(text) <= limit else text[: limit - 1] + "…"
