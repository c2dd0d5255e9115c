"""M(q) of the simulated chain, by differences of the twists of displaced and turned spheres."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from nrchain import Scene
from nrchain.motion.model import Model

STEPS = ((-2, 1 / 12), (-1, -8 / 12), (1, 8 / 12), (2, -1 / 12))
"""Places and weights of a central difference of fourth order."""


def differenced_operator(scene: Scene, phase: float, step: float = 1e-4) -> NDArray[np.complex128]:
    """M (6, 6) in the lab, with Ω0 × φ, from the first sphere of a periodic chain."""
    model = Model(scene)
    wave = np.exp(1j * phase * np.arange(model.count))
    operator = np.zeros((6, 6), complex)
    for column, unit in enumerate(np.eye(6)):
        for factor, part in ((1.0, wave.real), (1j, wave.imag)):
            poses = part[:, None] * unit
            for place, weight in STEPS:
                twist = _twists(scene, model, place * step * poses)[0]
                operator[:, column] += factor * weight / step * twist
    spin = _twists(scene, model, np.zeros((model.count, 6)))[0, 3]
    operator[4, 5] -= spin
    operator[5, 4] += spin
    return operator


def _twists(scene: Scene, model: Model, poses: NDArray[np.float64]) -> NDArray[np.float64]:
    positions = poses[:, :3].copy()
    positions[:, 0] += scene.chain.spacing * np.arange(model.count)
    turned = Rotation.from_rotvec(poses[:, 3:]).as_matrix()
    return model.twists(positions, np.ascontiguousarray(turned.swapaxes(1, 2)))
