"""The moduli of a chain: those of linear response, or those of uniform strain.

**Linear response** (``stress="linear"``, the paper's). The moduli are those with which the
linearised rod has the wrenches of the chain up to the second derivatives of u and φ, from the
Jacobian of the simulation: :mod:`nrchain.theory.rod.linear_response`.

**Uniform strain** (``stress="cut"``). The moduli are derivatives of the stress and the sources in
uniform states of strain: :mod:`nrchain.theory.rod.uniform`. They are those of a finite strain, and
those of the work in a cycle.

The two agree for reciprocal interactions. Without reciprocity a source may change with the gradient
of the strain. In a wave this cannot be told from the divergence of a stress: linear response counts
it as stress, a cut does not. For nearest neighbours C^{Fτ} and the torques in C^{Mτ} are then twice
those of the cut.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from nrchain.errors import SceneError
from nrchain.inputs.rules import choice
from nrchain.notebook import record_html, table_html
from nrchain.scene.scene import Scene
from nrchain.theory.rod.constants import Constants
from nrchain.theory.rod.linear_response import (
    active_constants,
    elastic_constants,
    resistance_gradients,
)
from nrchain.theory.rod.slip_symmetry import slip_symmetry
from nrchain.theory.rod.symmetry import Symmetry
from nrchain.theory.rod.uniform import cut_constants
from nrchain.wording import brief

Stress = Literal["linear", "cut"]
"""How forces are assigned to a cut: by linear response, or in uniform strain."""


@dataclass(frozen=True, eq=False)
class Moduli:
    """The constants of the linear rod that a chain makes, in the moving frame.

    Attributes
    ----------
    active, elastic
        The parts of slip and fields, and of the elasticity; :attr:`total` is their sum.
    logarithm
        Coefficients of ln(1/qd); not 0 only for all pairs. See :meth:`at`.
    error
        Bounds of the absolute errors of the total: of rounding, and of differences for a cut.
    drag
        Γ (6, 6) in (f, m)^D = −Γ (V, Ω), per length.
    spacing
        d.
    symmetry
        That of the slip.
    stress
        "linear" or "cut".
    """

    active: Constants
    elastic: Constants
    logarithm: Constants
    error: Constants
    drag: np.ndarray
    spacing: float
    symmetry: Symmetry
    stress: Stress

    __repr__ = brief

    def _repr_html_(self) -> str:
        if not self.symmetry.isotropic:
            return record_html(self)
        columns = (self.active.symbols(), self.elastic.symbols(), self.error.symbol_bounds())
        rows = [
            (symbol, *(float(column[symbol]) for column in columns))
            for symbol in self.symmetry.symbols()
        ]
        return table_html("Moduli", rows, ("constant", "slip", "elasticity", "± error"))

    @property
    def total(self) -> Constants:
        """Active and elastic; for entries with a logarithm, without it."""
        return self.active + self.elastic

    def at(self, wavenumber: float) -> Constants:
        """The total at a wavenumber q > 0, with ln(1/qd) of all pairs; relative error (qd)²."""
        if not wavenumber > 0.0:
            raise SceneError("wavenumber", wavenumber, "must be above 0")
        return self.total + self.logarithm * -math.log(wavenumber * self.spacing)


def moduli(scene: Scene, stress: Stress = "linear") -> Moduli:
    """The moduli of the chain of a scene, from the code that simulates it.

    Any modes, axes, number of neighbours, finite size and elasticity. Nearest neighbours of the
    paper's modes give its Table moduli. ``stress`` says how forces are assigned to a cut, see
    :mod:`nrchain.theory.rod.coarse_graining`: "linear" includes friction between a number of
    neighbours, "cut" takes all pairs of the N spheres of the scene.

    Raises :class:`~nrchain.errors.SceneError` for a scene without uniform states (strengths that
    vary, fields and flows fixed in the lab), for flows without a sum over all pairs, and for
    friction between all pairs: the drag per length of an infinite chain depends on the wavelength.

    >>> import nrchain
    >>> found = nrchain.moduli(nrchain.load_scene("buckling"))
    >>> print(found.symmetry)
    transversely isotropic, apolar, achiral
    """
    symmetry, d = slip_symmetry(scene), scene.chain.spacing
    choice(Stress)("stress", stress)
    if stress == "cut":
        active, elastic, error = cut_constants(scene)
        drag = np.diag(np.repeat(scene.drag, 3)) / d
        return Moduli(active, elastic, Constants.of(), error, drag, d, symmetry, stress)
    resistance = resistance_gradients(scene)
    active, logarithm, active_error = active_constants(scene, resistance)
    elastic, elastic_error = elastic_constants(scene)
    error = active_error + elastic_error
    return Moduli(active, elastic, logarithm, error, resistance[0], d, symmetry, stress)
