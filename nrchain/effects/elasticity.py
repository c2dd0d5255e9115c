"""W = −∂V: a term of the elastic energy as an effect by itself."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from nrchain.effects.base import Cost, Effect

if TYPE_CHECKING:
    from nrchain.scene import Scene


class ElasticTerm(Effect):
    """One term of the elastic energy. A model sums all of a scene in one pass over the links.

    Evaluated by itself it goes through the kernels of the scene, with the other moduli zero.
    """

    absence = "modulus 0"
    fused = True
    placed = False

    def __init__(self, scene: Scene) -> None:
        from nrchain.effects.cosserat import REACH, Elasticity, terms_of

        super().__init__(scene)
        terms = terms_of(scene.moduli)
        own = [m if n == self.name else 0.0 for n, m in scene.moduli._asdict().items()]
        self._elasticity = Elasticity.of(scene, own, terms)
        self._blocks = np.zeros((scene.chain.particles, 2 * REACH + 1, 6, 6))
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
        from nrchain.effects.link import add_block_product

        add_block_product(self._blocks, poses, self.scene.chain.ends == "periodic", out)

    def energy(self, positions: np.ndarray, frames: np.ndarray) -> Any:
        return self._elasticity.energy(positions, frames)
