"""(F, T) = −∂V/∂(u, φ): one term of the elastic energy as an effect."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from nrchain.effects.base import Cost, Effect
from nrchain.potential.chain import REACH, Elasticity, terms_of
from nrchain.potential.link import add_block_product
from nrchain.scene.scene import Scene


def elasticity_of(
    scene: Scene, moduli: Sequence[float] | None = None, terms: tuple[str, ...] | None = None
) -> Elasticity:
    """The elastic energy of a scene, with its moduli or others.

    ``terms`` are those compiled into the kernels; by default those with a nonzero modulus.
    """
    chosen = tuple(scene.moduli if moduli is None else moduli)
    return Elasticity(
        scene.chain.spacing,
        scene.period,
        chosen,
        scene.elasticity.measure == "isotropic",
        terms_of(chosen) if terms is None else terms,
    )


class ElasticTerm(Effect):
    """One term of the elastic energy. A model sums all terms in one pass over the links.

    A single term uses the kernels of the scene with the other moduli set to zero.
    """

    absence = "modulus 0"
    fused = True
    placed = False

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        terms = terms_of(scene.moduli)
        own = [m if n == self.name else 0.0 for n, m in scene.moduli._asdict().items()]
        self._elasticity = elasticity_of(scene, own, terms)
        self._blocks = np.zeros((scene.chain.particles, 2 * REACH + 1, 6, 6))
        self._closed = scene.chain.ends == "periodic"
        self.places = REACH

    @classmethod
    def acts(cls, scene: Scene) -> bool:
        return getattr(scene.moduli, cls.name) != 0.0

    @classmethod
    def balanced(cls, scene: Scene) -> bool:
        return True

    @classmethod
    def detail(cls, scene: Scene) -> str:
        return f"modulus {getattr(scene.moduli, cls.name):.4g}"

    @classmethod
    def cost(cls, scene: Scene) -> Cost:
        count = scene.chain.particles
        return Cost(count if scene.chain.ends == "periodic" else count - 1, "links")

    def add_wrenches(self, positions: np.ndarray, frames: np.ndarray, wrenches: np.ndarray) -> None:
        self._elasticity.add_wrenches(positions, frames, wrenches)

    def linearise(self, positions: np.ndarray, frames: np.ndarray) -> None:
        self._blocks[:] = 0.0
        self._elasticity.add_jacobian(positions, frames, self._blocks)

    def add_blocks(self, blocks: np.ndarray) -> None:
        centre, reach = blocks.shape[1] // 2, self._blocks.shape[1] // 2
        blocks[:, centre - reach : centre + reach + 1] += self._blocks

    def add_product(self, poses: np.ndarray, out: np.ndarray) -> None:
        add_block_product(self._blocks, poses, self._closed, out)

    def energy(self, positions: np.ndarray, frames: np.ndarray) -> Any:
        return self._elasticity.energy(positions, frames)
