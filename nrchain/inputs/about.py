"""What each key of a section is for: symbol, unit, allowed values and meaning.

docs/scenes.md has the same texts, and a test compares them.
"""

from __future__ import annotations

from typing import NamedTuple


class About(NamedTuple):
    """What a key is for.

    Attributes
    ----------
    symbol
        As in the paper and in the docs; empty if it has none.
    unit
        In units of length L, time T and force F; empty for a number without a unit.
    allowed
        The allowed values in words.
    meaning
        What the key sets.
    """

    symbol: str
    unit: str
    allowed: str
    meaning: str
