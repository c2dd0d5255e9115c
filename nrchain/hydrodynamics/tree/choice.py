"""The tree of a sum over pairs where it is faster than the direct sum, and None elsewhere.

Trees are imported where they are used: short chains do not load their kernels.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from nrchain.hydrodynamics.images import Layout
from nrchain.hydrodynamics.pair_law import PairLaw
from nrchain.hydrodynamics.tree.accuracy import break_even

if TYPE_CHECKING:
    from nrchain.hydrodynamics.tree.sums import DisturbanceTree, FrictionTree, SlipTree


def _is_worth(layout: Layout, accuracy: float) -> bool:
    """Whether all pairs of an open chain are summed, and are enough to be worth a tree."""
    count = len(layout.spheres)
    # a periodic chain has more slots than a sphere reaches on either side, a cut sum fewer places
    return layout.reach == count - 1 and count >= break_even(accuracy)


def slip_tree(law: PairLaw, layout: Layout, radius: float, accuracy: float) -> SlipTree | None:
    """The tree of slip flows; None for chains and modes that are summed directly."""
    if not law.labels or not _is_worth(layout, accuracy):
        return None
    from nrchain.hydrodynamics.tree.moments import slip_terms
    from nrchain.hydrodynamics.tree.sums import SlipTree

    terms = slip_terms(law)
    return SlipTree(law, terms, len(layout.spheres), radius, accuracy) if terms else None


def friction_tree(layout: Layout, radius: float, accuracy: float) -> FrictionTree | None:
    """The tree of friction between spheres; None for chains that are summed directly."""
    if not _is_worth(layout, accuracy):
        return None
    from nrchain.hydrodynamics.tree.sums import FrictionTree

    return FrictionTree(len(layout.spheres), radius, accuracy)


def disturbance_tree(
    law: tuple[bool, np.ndarray, float], layout: Layout, radius: float, accuracy: float
) -> DisturbanceTree | None:
    """The tree of one part of a disturbance; None for chains that are summed directly."""
    if not _is_worth(layout, accuracy):
        return None
    from nrchain.hydrodynamics.tree.sums import DisturbanceTree

    return DisturbanceTree(law, len(layout.spheres), radius, accuracy)
