"""a(t) = Σ ℓ* · (u, φ): how fast a run returns to a state, or leaves it, against the mode's rate.

A run starts off the state along a mode. Its poses, in axes that move with the state, differ from
it by (u, φ), whose part along the mode is a(t): the slope of log |a| is the rate. The run knows
nothing of the spectrum but the direction of its start, and how long it takes.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import nrchain

Array = NDArray[np.float64]

HEIGHT = 1e-4
"""Largest displacement at the start, in radii, or rotation in radians."""

SNAPSHOTS, LENGTH = 41, 1.0
"""Snapshots of a run, and its length in units of 1/|Re Λ|."""

TIGHT = {"run.rtol": 1e-8, "run.atol": 1e-11}


def rate_in_run(state: nrchain.State, mode: nrchain.Mode) -> float:
    """d log |a|/dt of a run that starts off a state along one of its modes."""
    changes = {"run.end": LENGTH / abs(mode.growth), "run.snapshots": SNAPSHOTS, **TIGHT}
    positions, frames = displaced(state, mode.right[0].real)
    run = nrchain.simulate(
        nrchain.load_scene(state.scene, **changes), positions=positions, frames=frames
    )
    if run.status != "completed":
        raise ArithmeticError(f"the run ends early: {run.reason}")
    amplitude = np.abs(np.einsum("nk,tnk->t", mode.left[0].conj(), away_from(state, run)))
    return float(np.polyfit(run.time, np.log(amplitude), 1)[0])


def displaced(state: nrchain.State, change: Array) -> tuple[Array, Array]:
    """Poses off a state along (u, φ) (N, 6), by :data:`HEIGHT` at most."""
    radius = state.scene.chain.radius
    sizes = np.linalg.norm(change.reshape(-1, 2, 3), axis=2) / [radius, 1.0]
    change = HEIGHT / sizes.max() * change
    turned = Rotation.from_rotvec(change[:, 3:]).as_matrix()
    frames = np.einsum("nij,naj->nai", turned, state.frames)
    return state.positions + change[:, :3], frames


def away_from(state: nrchain.State, run: nrchain.Trajectory) -> Array:
    """(T, N, 6): displacements and rotations from a state, in axes that move with it.

    States here rotate about a point that rests, or move without rotating, and may turn about e₁.
    """
    if np.any(state.rotation) and np.linalg.norm(state.velocity) > 1e-9 * abs(state.rotation).max():
        raise ArithmeticError("a state that moves and rotates at once is not compared")
    time = run.time - run.time[0]
    back = Rotation.from_rotvec(-time[:, None] * state.rotation).as_matrix()
    moved = run.positions - state.origin - time[:, None, None] * state.velocity
    positions = np.einsum("tij,tnj->tni", back, moved) + state.origin
    frames = np.einsum("tij,tnaj->tnai", back, run.frames)
    cosine, sine = np.cos(state.turn * time), np.sin(state.turn * time)
    still = np.zeros((len(time), 3, 3))
    still[:, 0, 0], still[:, 1, 1], still[:, 2, 2] = 1.0, cosine, cosine
    still[:, 1, 2], still[:, 2, 1] = -sine, sine
    # the frames turn about their own e₁: the rows of a frame mix
    frames = np.einsum("tab,tnbk->tnak", still, frames)
    turns = np.einsum("tnak,naj->tnkj", frames, state.frames)
    angles = Rotation.from_matrix(turns.reshape(-1, 3, 3)).as_rotvec()
    return np.concatenate([positions - state.positions, angles.reshape(positions.shape)], axis=2)
