"""V and e of one mode, as a user states them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from nrchain.inputs.rules import Section, direction, number, one_or_each

E1 = (1.0, 0.0, 0.0)
"""The body axis of a mode unless another is named."""

STRENGTH = one_or_each(number())
"""The rule of a strength: one number, or one for each sphere."""


@dataclass(frozen=True, slots=True)
class Slip(Section):
    """V and e: the strength of one mode, one number or one a sphere, and its body axis.

    The axis has components along e_1, e_2 and e_3 of each sphere, is not zero, and is kept as
    given: whoever uses it takes its direction.
    """

    strength: Annotated[float | tuple[float, ...], STRENGTH]
    axis: Annotated[tuple[float, float, float], direction()] = E1
