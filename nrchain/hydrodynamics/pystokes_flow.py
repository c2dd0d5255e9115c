"""(v, ω)_i = Σ_j (u, w)(r_i − r_j, e_j) by PyStokes, with the derivatives of the closed forms."""

from __future__ import annotations

from typing import Any

import numpy as np

from nrchain.hydrodynamics.pairs import SlipFlow


class PyStokesFlow(SlipFlow):
    """A :class:`~nrchain.hydrodynamics.pairs.SlipFlow` whose twists come from PyStokes.

    ``neighbours`` is the number on either side, or ``"all"``; other arguments as for SlipFlow.
    """

    def __init__(self, *arguments: Any, neighbours: int | str, viscosity: float, **options: Any):
        super().__init__(*arguments, **options)
        self._neighbours, self._viscosity = neighbours, viscosity

    def term(self) -> None:
        """None: PyStokes is called in Python."""

    def add_twists(self, positions: np.ndarray, frames: np.ndarray, twists: np.ndarray) -> None:
        from nrchain.hydrodynamics import pystokes_backend

        if not self:
            return
        law = self.law
        velocities, spins = pystokes_backend.twists(
            positions,
            [np.einsum("b,nbk->nk", np.array(law.axes[g]), frames) for g in law.axis_of],
            list(self.strengths),
            neighbours=self._neighbours,
            radius=self.radius,
            viscosity=self._viscosity,
            finite_size=law.finite_size,
            labels=law.labels,
        )
        twists[:, :3] += velocities
        twists[:, 3:] += spins
