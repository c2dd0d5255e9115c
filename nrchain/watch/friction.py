"""min λ(μ) > 0: friction between spheres that is cut at a reach must still dissipate energy.

Where the mobility is no longer positive definite, spheres gain energy from the fluid.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from nrchain.outcome import Cause, Stop


class FrictionWatch:
    """Stops a run in which friction cut at so many ``neighbours`` no longer dissipates energy.

    ``least_mobility`` gives the least eigenvalue of μ at positions (N, 3), in units of the mobility
    of a single sphere.
    """

    def __init__(self, neighbours: int, least_mobility: Callable[[np.ndarray], float]) -> None:
        self._neighbours, self._least_mobility = neighbours, least_mobility

    def check(self, time: float, positions: np.ndarray) -> None:
        """Raise :class:`~nrchain.outcome.Stop` where the mobility is not positive definite."""
        least = self._least_mobility(positions)
        if least <= 0.0:
            raise Stop(
                Cause.FRICTION,
                time,
                f"the mobility cut at {self._neighbours} neighbours is no longer positive "
                f"definite: its least eigenvalue is {least:.2g} of that of a single sphere",
            )
