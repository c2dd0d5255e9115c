"""The rod that the chain of a scene becomes as d/L → 0, and its poses from those of the chain."""

from __future__ import annotations

import numpy as np

from nrchain.errors import SceneError
from nrchain.inputs.arguments import finite_array, rotations
from nrchain.scene.loading import require_scene
from nrchain.scene.scene import Scene
from nrchain.theory.rod.nonlinear.chain_law import chain_law
from nrchain.theory.rod.nonlinear.elements import lagrange
from nrchain.theory.rod.nonlinear.rod import CosseratRod
from nrchain.theory.rod.uniform_chain import UniformChain
from nrchain.types import Poses

STENCIL = 8
"""Spheres between which poses are interpolated, where there are as many."""


def rod_of(
    scene: Scene, *, elements: int = 3, degree: int = 8, nonlinear: bool = True
) -> CosseratRod:
    """The nonlinear rod of the chain of a scene: :mod:`~nrchain.theory.rod.nonlinear.chain_law`.

    Its ends are at the centres of the first and last sphere. Each free end has the drag and the
    field of half a sphere besides. With nearest neighbours the chain differs from it by a relative
    order (d/L)², at deflections of the order of L. With more neighbours pairs are missing at the
    ends, and the order is 1. With all pairs (of the N spheres of the scene) there is no limit for
    modes that depend on ln(1/qd): see :func:`nrchain.moduli`.

    ``nonlinear=False`` leaves out terms of second order in the strains.

    Raises :class:`~nrchain.SceneError` for scenes without uniform states of strain, and for
    friction between spheres.

    >>> import nrchain
    >>> scene = nrchain.load_scene("wave", **{"slip.neighbours": 1})
    >>> found = nrchain.rod_of(scene)
    >>> arc = found.bent([0, 0, 0, 0, 0, 1.0 / found.length])
    >>> motion = found.simulate(*arc, times=[0.0, 1.0])
    """
    material, quadratic = chain_law(require_scene(scene))
    chain, ends = scene.chain, scene.chain.ends
    links = chain.particles if ends == "periodic" else chain.particles - 1
    free = ends == "free"
    return CosseratRod(
        material,
        chain.spacing * links,
        elements=elements,
        degree=degree,
        ends=ends,
        quadratic=quadratic if nonlinear else None,
        end_length=0.5 * chain.spacing if free else 0.0,
        end_wrench=0.5 * UniformChain(scene).body if free else None,
    )


def node_poses(rod: CosseratRod, positions: np.ndarray, frames: np.ndarray) -> Poses:
    """Poses of the nodes of a rod from those of spheres at equal spacing along it.

    Polynomials through the :data:`STENCIL` nearest spheres; frames are the rotations nearest to
    the polynomials of their rows.
    """
    r = finite_array("positions", positions, (None, 3))
    e = rotations(frames, len(r))
    closed = rod.ends == "periodic"
    if len(r) < 2:
        raise SceneError("positions", r.shape, "must be those of at least 2 spheres")
    places = rod.places * (len(r) if closed else len(r) - 1) / rod.length
    width = min(STENCIL, len(r))
    first = np.floor(places).astype(int) - (width // 2 - 1)
    if not closed:
        first = np.clip(first, 0, len(r) - width)
    index = first[:, None] + np.arange(width)
    values = np.array(
        [lagrange(np.arange(width, dtype=float), np.array([s]))[0] for s in places - first]
    )
    turns, index = np.divmod(index, len(r))
    near = r[index]
    near[..., 0] += rod.length * turns
    left, _, right = np.linalg.svd(np.einsum("nw,nwap->nap", values, e[index]))
    return np.einsum("nw,nwp->np", values, near), left @ right
