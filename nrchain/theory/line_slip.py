"""Σ_s c_s m^−s: twists and blocks that the slip of one mode gives at the m-th sphere of a line."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from nrchain.hydrodynamics import slip_modes
from nrchain.hydrodynamics.slip import Slip
from nrchain.motion.model import Model
from nrchain.scene.chain_sections import ElasticitySpec, RunSpec
from nrchain.scene.fluid_sections import SlipSpec
from nrchain.scene.scene import Scene
from nrchain.theory.lattice_sums import STRIDE, take_apart
from nrchain.theory.line_mobility import Sides

_NO_ELASTICITY = ElasticitySpec(stretch=0.0, shear=0.0, twist=0.0, bend=0.0)


def slip_powers(scene: Scene, label: str, slip: Slip) -> tuple[Sides, Sides]:
    """``twists[s]`` (2, 6) and ``blocks[s]`` (2, 6, 6) of a mode with one strength for all spheres.

    They are the coefficients of 1/m^s in the twist of a sphere, and in its derivative with the pose
    of the acting one, m places to the right (row 0) or left (row 1). Pairs are evaluated at several
    distances, and the powers separated.
    """
    mode, spacing = slip_modes.find(label), scene.chain.spacing
    finite_size = scene.slip.finite_size
    flow = sorted({k for _, k in mode.flow(finite_size)})
    spin = sorted({k for _, k in mode.spin(finite_size)})
    samples = max(len(flow), len(spin))
    twists, blocks = np.empty((samples, 2, 6)), np.empty((samples, 2, 3, 6, 6))
    for n in range(samples):
        pair = Scene(
            chain=replace(scene.chain, particles=2, spacing=spacing * STRIDE**n, ends="free"),
            elasticity=_NO_ELASTICITY,
            slip=SlipSpec(modes={label: slip}, finite_size=finite_size),
            run=RunSpec(end=1.0),
        )
        twists[n], blocks[n] = _twists_and_blocks(pair)
    across = np.stack([blocks[:, 0, 2], blocks[:, 1, 0]], axis=1)
    twist_powers: Sides = {}
    block_powers: Sides = {}
    for rows, powers in ((slice(0, 3), flow), (slice(3, 6), spin)):
        for columns, shift in ((slice(0, 3), 1), (slice(3, 6), 0)):
            part = across[:, :, rows, columns]
            for power, share in take_apart(part, [k + shift for k in powers]).items():
                sides = block_powers.setdefault(power, np.zeros((2, 6, 6)))
                sides[:, rows, columns] += share
        for power, share in take_apart(twists[:, :, rows], powers).items():
            twist_powers.setdefault(power, np.zeros((2, 6)))[:, rows] += share
    return twist_powers, block_powers


def add_powers(total: Sides, share: Sides) -> None:
    """total += share, power by power."""
    for power, sides in share.items():
        total[power] = total.get(power, 0.0) + sides


def line_poses(count: int, spacing: float) -> tuple[np.ndarray, np.ndarray]:
    """Positions (N, 3) and frames (N, 3, 3) of a straight chain along x."""
    positions = np.zeros((count, 3))
    positions[:, 0] = spacing * np.arange(count)
    return positions, np.broadcast_to(np.eye(3), (count, 3, 3)).copy()


def _twists_and_blocks(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """Twists (N, 6) and Jacobian blocks (N, 2w + 1, 6, 6) of a straight chain along x."""
    model = Model(scene)
    positions, frames = line_poses(model.count, scene.chain.spacing)
    blocks = np.empty((model.count, 2 * model.reach + 1, 6, 6))
    model.linearise(positions, frames, blocks)
    return model.twists(positions, frames), blocks
