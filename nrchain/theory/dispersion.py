"""Λ(q) of one scene by every theory: the exact lattice, its rod, and the beam limit of the rod."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from nrchain.errors import SceneError
from nrchain.inputs.arguments import finite_array
from nrchain.notebook import table_html
from nrchain.scene.loading import require_scene
from nrchain.scene.scene import Scene
from nrchain.theory.eigenvalues import joined
from nrchain.theory.lattice import Branch, Frame, lattice_rates
from nrchain.theory.rod.coarse_graining import moduli
from nrchain.theory.rod.material import Material
from nrchain.theory.rod.slip_symmetry import slip_symmetry
from nrchain.theory.rod.uniform_scene import body_wrench, uniform_slip
from nrchain.theory.rod.waves import PAIRS, Waves, rod_waves
from nrchain.wording import brief

Complex = NDArray[np.complex128]

POINTS = 160
"""Number of wavenumbers unless they are given."""


@dataclass(frozen=True, eq=False)
class Dispersion:
    """Rates of plane waves of the straight chain of a scene.

    Attributes
    ----------
    scene
        The scene.
    wavenumbers
        q (n,).
    frame
        "lab", or "spinning" for an anisotropic chain that spins.
    lattice
        Λ (n, 6) of the chain, in the columns of :class:`nrchain.lattice.Branch`.
    rod, beam
        Waves of its rod and of the beam limit; None for a chain without moduli.
    why
        Why there is no rod; "" where there is one.

    >>> from nrchain import dispersion, load_scene
    >>> dispersion(load_scene("buckling"), [0.01, 0.02]).lattice.shape
    (2, 6)
    """

    scene: Scene
    wavenumbers: NDArray[np.float64]
    frame: Frame
    lattice: Complex
    rod: Waves | None
    beam: Waves | None
    why: str

    __repr__ = brief

    def _repr_html_(self) -> str:
        rows = []
        for branch in Branch:
            place = self.fastest(branch)
            rate = self.lattice[place, branch]
            qd = self.wavenumbers[place] * self.scene.chain.spacing
            rows.append((branch.spoken, qd, rate.real, 0.0 - rate.imag))
        heads = ("branch of the lattice", "qd of the largest growth", "growth", "frequency")
        return table_html(f"Plane waves at {len(self.wavenumbers)} wavenumbers", rows, heads)

    def fastest(self, branch: Branch) -> int:
        """The index of the wavenumber at which a branch of the lattice grows fastest."""
        return int(np.argmax(self.lattice[:, branch].real))


def dispersion(scene: Scene, wavenumbers: ArrayLike | None = None) -> Dispersion:
    """Λ(q) of a scene by the lattice, its rod of linear response, and the beam limit.

    ``wavenumbers`` (n,) are :func:`even_wavenumbers` of the scene unless they are given.

    Raises :class:`~nrchain.errors.SceneError` for a scene without uniform states: strengths that
    differ between spheres, fields and flows fixed in the lab; and as
    :func:`nrchain.lattice.lattice_rates`.

    >>> import nrchain
    >>> found = nrchain.dispersion(nrchain.load_scene("wave"))
    >>> found.lattice.shape, found.rod.rates.shape, found.beam.rates.shape
    ((160, 6), (160, 6), (160, 3))
    """
    require_scene(scene)
    q = even_wavenumbers(scene) if wavenumbers is None else finite_array("wavenumbers", wavenumbers)
    uniform_slip(scene)
    body_wrench(scene)
    frame, lattice = _lattice(scene, q)
    material, why = _material(scene)
    if material is None:
        return Dispersion(scene, q, frame, lattice, None, None, why)
    rod, beam = (rod_waves(material, q, frame=frame, beam=limit) for limit in (False, True))
    return Dispersion(scene, q, frame, lattice, rod, beam, "")


def even_wavenumbers(scene: Scene) -> NDArray[np.float64]:
    """q (POINTS,) at equal ratios, from π/(N d) (half a wave on the chain) to π/d."""
    count, d = scene.chain.particles, scene.chain.spacing
    return np.geomspace(math.pi / (max(count, 2) * d), math.pi / d, POINTS)


def _lattice(scene: Scene, q: np.ndarray) -> tuple[Frame, Complex]:
    """Rates in the lab, or along axes that spin if only these have steady coefficients."""
    frame: Frame = "lab"
    try:
        rates = lattice_rates(scene, q)
    except SceneError as error:
        if error.key != "frame":
            raise
        frame = "spinning"
        rates = lattice_rates(scene, q, frame=frame)
    for columns in PAIRS if slip_symmetry(scene).isotropic else (tuple(Branch),):
        rates[:, columns] = joined(rates[:, columns])
    return frame, rates


def _material(scene: Scene) -> tuple[Material | None, str]:
    """The material of a chain, or why it has none."""
    friction = scene.friction
    if friction.kind == "pairwise" and friction.neighbours == "all":
        return None, (
            "friction.neighbours = 'all' has no rod: the drag per length falls as 1/ln of the"
            " wavelength"
        )
    found = moduli(scene)
    if found.logarithm.largest() == 0.0:
        return Material(found.total, found.drag, found.error), ""
    values = found.logarithm.symbols().items()
    symbols = [symbol for symbol, value in values if value] if found.symmetry.isotropic else []
    which = ", ".join(symbols) or "entries of C and H"
    return None, f"slip.neighbours = 'all' has no rod: {which} diverge as ln(1/qd)"
