"""V and e of one slip mode, as a scene states them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from nrchain.inputs.rules import Section, direction, number, one_or_each

E1 = (1.0, 0.0, 0.0)
"""The default body axis of a mode."""

STRENGTH = one_or_each(number())
"""The rule for a strength: one number, or one for each sphere."""


@dataclass(frozen=True, slots=True)
class Slip(Section):
    """V and e: the strength of one mode, a number or one for each sphere, and its body axis.

    The axis has components along e_1, e_2 and e_3 of each sphere and is not zero. Its length has no
    effect.

    >>> Slip(500.0).axis
    (1.0, 0.0, 0.0)
    """

    strength: Annotated[float | tuple[float, ...], STRENGTH]
    axis: Annotated[tuple[float, float, float], direction()] = E1
