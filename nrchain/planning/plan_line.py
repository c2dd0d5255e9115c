"""One line of a plan."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Line:
    """A quantity of a plan, its value with symbol, and what it means."""

    quantity: str
    value: str
    meaning: str
