"""w_n = Σ_k A_k exp(i q_k d n): the plane waves that a mode of a finite straight chain consists of.

In the bulk of a chain a mode of rate Λ is a sum of the few waves whose rate is Λ, most of them
evanescent. They are found from the mode alone, by the shift from sphere to sphere of the space that
its windows span (the matrix pencil, or ESPRIT). The wave of the largest norm on the chain gives the
mode its wavenumber and its branch. Im q ≠ 0 where modes of a chain without reciprocity pile up at
an end. Where the tension varies along a chain, as in a free one with 3t, there are no exact waves,
and some modes get a wavenumber that means little. Waves longer than four chains are no candidates:
they are motions of the chain as a whole, which modes of a free chain leave out, and evanescent
waves of the ends.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nrchain.comoving.dense import all_modes
from nrchain.comoving.relative import RelativeChain
from nrchain.errors import SceneError
from nrchain.notebook import record_html
from nrchain.scene.scene import Scene
from nrchain.states.search import state_near
from nrchain.theory.dispersion import Dispersion
from nrchain.theory.lattice import Branch
from nrchain.wording import brief

LEAST, MOST = 16, 200
"""Numbers of spheres of chains whose modes are resolved into waves: fewer spheres are too few for
the waves of one rate, and all modes of more take minutes."""

END = 1
"""Spheres at either end where links lack neighbours: the equation is not that of the bulk."""

WAVES = 12
"""Most waves of one rate: two ends, six coordinates."""

ALIKE = 1e-2
"""Waves whose difference is smaller than this fraction of them count as one."""

NOISE = 1e-4
"""Fraction of the largest singular value below which a direction of the windows is no wave."""


@dataclass(frozen=True, eq=False)
class ModeWaves:
    """The main wave of each mode of a finite straight chain; modes of the ends alone have none.

    Attributes
    ----------
    rates
        Λ (m,) of the modes, in the frame of the dispersion, one for each of a pair.
    wavenumbers
        q (m,), complex, with 0 ≤ Re q ≤ π/d.
    shares
        (m,) the norm of the main wave over the sum of the norms of all waves of the mode.
    branches
        (m,) places in :class:`nrchain.lattice.Branch`.

    >>> import nrchain
    >>> modes = nrchain.mode_waves(nrchain.dispersion(nrchain.load_scene("buckling")))
    >>> modes.rates.shape == modes.wavenumbers.shape
    True
    """

    rates: NDArray[np.complex128]
    wavenumbers: NDArray[np.complex128]
    shares: NDArray[np.float64]
    branches: NDArray[np.int64]

    __repr__ = brief
    _repr_html_ = record_html


def mode_waves(found: Dispersion) -> ModeWaves:
    """Rates, wavenumbers and branches of all modes of the scene of a dispersion, at its own ends.

    Raises :class:`~nrchain.errors.SceneError` for chains of too few or too many spheres, and for
    those whose straight state is not steady.

    >>> import nrchain
    >>> found = nrchain.dispersion(nrchain.load_scene("buckling"))
    >>> modes = nrchain.mode_waves(found)
    >>> len(modes.rates), bool(modes.rates.real.max() < found.lattice.real.max())
    (108, True)
    """
    scene, count = found.scene, found.scene.chain.particles
    if not LEAST <= count <= MOST:
        allowed = f"must be from {LEAST} to {MOST} for the waves of its modes"
        raise SceneError("chain.particles", count, allowed)
    with np.errstate(all="ignore"):
        state = state_near(scene, None)
        point = RelativeChain(scene, state.poses).at(state.poses)
        rates, vectors = all_modes(point)
        units = np.repeat([1.0, point.chain.length], 3)
        fields = [point.chain.poses(vector) * units for vector in vectors.T]
    spin = state.motion.rotation[0] if found.frame == "lab" else 0.0
    rows = [
        row
        for rate, field in zip(rates, fields, strict=True)
        if (row := _main_wave(scene, rate, field, spin))
    ]
    columns: Any = zip(*rows, strict=True)
    values, phases, shares, along = map(np.array, columns)
    wavenumbers: Any = phases / scene.chain.spacing
    return ModeWaves(values, wavenumbers, shares, _branches(found, values, wavenumbers, along))


def _main_wave(
    scene: Scene, rate: complex, field: np.ndarray, spin: float
) -> tuple[complex, complex, float, bool] | None:
    """(Λ, qd, share, whether it goes along the chain) of a mode (N, 6), for Re q ≥ 0.

    Of a pair Λ, Λ* either is given.
    """
    phases, waves = _resolve(field, periodic=scene.chain.ends == "periodic")
    sizes = np.linalg.norm(waves, axis=(1, 2))
    total = sizes.sum()
    if scene.chain.ends != "periodic":
        sizes = np.where(np.abs(phases.real) > 0.5 * np.pi / len(field), sizes, 0.0)
    main = int(np.argmax(sizes))
    wave, phase, share = waves[main], phases[main], float(sizes[main] / total)
    if not share:
        return None
    hand = _hand(wave)
    value = complex(rate + 1j * hand * spin)
    if phase.real < 0.0:
        value, phase = value.conjugate(), -phase.conjugate()
    return value, phase, share, hand == 0


def _hand(wave: np.ndarray) -> int:
    """±1 for the hand of most of a wave (N, 6), 0 if it goes along the chain."""
    plus, minus = (
        0.5 * float(np.sum(np.abs(wave[:, [1, 4]] + 1j * sign * wave[:, [2, 5]]) ** 2))
        for sign in (1, -1)
    )
    if float(np.sum(np.abs(wave[:, [0, 3]]) ** 2)) > plus + minus:
        return 0
    return 1 if plus > minus else -1


def _resolve(field: np.ndarray, *, periodic: bool) -> tuple[np.ndarray, np.ndarray]:
    """qd (k,) and the waves (k, N, 6) of a mode."""
    count = len(field)
    phases = 2.0 * np.pi * np.fft.fftfreq(count) + 0j if periodic else _phases(field)
    columns = np.exp(1j * phases * (np.arange(count)[:, None] - (count - 1) / 2))
    # each wave is scaled by its largest value: evanescent ones would overflow the condition
    columns /= np.abs(columns).max(axis=0)
    # waves that are nearly equal share their part, and do not cancel
    amplitudes = np.linalg.lstsq(columns, field.astype(complex), rcond=ALIKE)[0]
    return phases, columns.T[:, :, None] * amplitudes[:, None, :]


def _phases(field: np.ndarray) -> np.ndarray:
    """qd (k,) of the waves in a mode (N, 6), of which links at the ends are left out."""
    field = field[END:-END]
    count = len(field)
    width = count // 2
    windows = np.lib.stride_tricks.sliding_window_view(field, width, axis=0)
    # rows: place in the window and coordinate; columns: windows
    matrix = windows.transpose(2, 1, 0).reshape(6 * width, count - width + 1)
    spanned, sizes, _ = np.linalg.svd(matrix, full_matrices=False)
    rank = int(np.sum(sizes > NOISE * sizes[0]))
    rank = min(rank, WAVES, len(sizes) - 1)
    space = spanned[:, :rank]
    shift = np.linalg.lstsq(space[:-6], space[6:], rcond=None)[0]
    return -1j * np.log(np.linalg.eigvals(shift).astype(complex))


def _branches(
    found: Dispersion, rates: np.ndarray, wavenumbers: np.ndarray, along: np.ndarray
) -> np.ndarray:
    """The branch of the lattice, along the chain or across, whose rate at Re q is the nearest."""
    columns = [np.interp(wavenumbers.real, found.wavenumbers, one) for one in found.lattice.T]
    distance = np.abs(np.stack(columns, axis=1) - rates[:, None])
    is_along = np.array([branch.hand == 0 for branch in Branch])
    return np.argmin(np.where(is_along == along[:, None], distance, np.inf), axis=1)
