"""The kinds of attractors, and what is known of the one that a run has reached."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum

from nrchain.inputs.names import Named
from nrchain.notebook import record_html
from nrchain.wording import brief


class Attracted(StrEnum):
    """What a chain ends in."""

    STRAIGHT = "straight"
    BUCKLED = "buckled"
    COILED = "coiled"
    SWIMMING = "swimming"
    SPINNING = "spinning"
    ROTATING = "rotating shape"
    STANDING = "standing oscillation"
    TRAVELLING = "travelling oscillation"
    IRREGULAR = "irregular"
    TORN = "torn"
    TOUCHING = "touching"
    UNSETTLED = "unsettled"

    @property
    def is_steady(self) -> bool:
        """Whether the kind is a state of rest or of steady motion, or may be one."""
        return self in _STEADY

    @property
    def is_oscillation(self) -> bool:
        """Whether the shape changes periodically."""
        return self in (Attracted.STANDING, Attracted.TRAVELLING)


_STEADY = frozenset(list(Attracted)[:6])


@dataclass(frozen=True)
class Attractor:
    """The attractor of a run.

    Attributes
    ----------
    kind
        See :class:`Attracted`.
    since
        Time from which on the chain is on the attractor, to the tolerance in ``numbers``. None if
        it has not got there, or is only seen to be on its way.
    period
        Period of an oscillation, or of a shape that goes round.
    numbers
        What decided, by name, with the tolerances.
    confidence
        How sure the kind is, in words.
    """

    kind: Attracted
    since: float | None = None
    period: float | None = None
    numbers: Mapping[str, float] = field(default_factory=dict)
    confidence: str = ""

    __repr__ = brief
    _repr_html_ = record_html

    def __post_init__(self) -> None:
        object.__setattr__(self, "numbers", Named(self.numbers))

    def __str__(self) -> str:
        """One line, such as "settled in a steady state at t = 412: buckled"."""
        since = "" if self.since is None else f" since t = {self.since:.6g}"
        if self.period is not None:
            moves = "oscillates" if self.kind.is_oscillation else "goes round"
            return f"{moves}, period {self.period:.4g}{since}: {self.kind}"
        if self.kind.is_steady and self.since is not None:
            return f"settled in a steady state at t = {self.since:.6g}: {self.kind}"
        return (
            f"{self.kind}{since}: {self.confidence}" if self.confidence else f"{self.kind}{since}"
        )
