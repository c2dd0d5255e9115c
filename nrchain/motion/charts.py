"""r_i = r_i⁰(t) + ρ_i, R_i = cay(θ_i) R_i⁰(t): the poses of a chain as coordinates y, and its ODE.

Every sphere has a base pose and six coordinates (ρ, θ) about it, zero at the start: how far it has
come from its base, and the rotation from the frame of the base by the Cayley map. The base moves:
all bases drift with one velocity V and each turns with Ω, constant along its own axes e_a, so that
a chain that swims or spins steadily stays near y = 0. Where elasticity ties the frames to each
other, Ω lies along e₁ and is the same for all; where nothing does, each is that of its own sphere.
The rates are

    ρ̇ = v − V,   θ̇ = dcay⁻¹(ω − Σ_a Ω_a e_a)   (see :func:`nrchain.geometry.lie.rate`),

and the Jacobian is J_ij = T_i⁻¹ D_ij T_j + δ_ij ∂(T_i⁻¹)·ω, with D the derivative of the twists
with displacements and rotations in the lab and T the tangent of the Cayley map, which is the
identity for ρ.

Why not one chart of SE(3): ρ would be p − θ × p/2, with p = r − r⁰. A sphere that is carried on
while it turns then has the errors of θ in its position, times its distance from the base, however
simple its path is.

Spheres that are clamped have no coordinates. The spheres of a periodic chain are numbered
0, N−1, 1, N−2, … in y: neighbours stay within twice their distance, and the matrix banded.
"""

from __future__ import annotations

import math

import numpy as np

from nrchain._compile import kernel
from nrchain.geometry import lie
from nrchain.motion.model import Model

TURN_LIMIT = 2.0
"""|θ| = 2 tan(α/2) at which a chart is left for a fresh one: a quarter turn."""


@kernel
def _turned(spin, time, out):
    """out (3, 3): the axes of a base, row by row, along those it had ``time`` ago."""
    rate = math.sqrt(spin[0] ** 2 + spin[1] ** 2 + spin[2] ** 2)
    out[:] = 0.0
    if rate == 0.0:
        out[0, 0] = out[1, 1] = out[2, 2] = 1.0
        return
    cosine, sine = math.cos(rate * time), math.sin(rate * time)
    for a in range(3):
        b, c = (a + 1) % 3, (a + 2) % 3
        for k in range(3):
            out[a, k] = (1.0 - cosine) * spin[a] * spin[k] / rate**2
        out[a, a] += cosine
        out[a, b] += sine * spin[c] / rate
        out[a, c] -= sine * spin[b] / rate


@kernel
def _poses(y, order, base_positions, base_frames, spins, time, positions, frames):
    rotation, base, turn, last = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3)), -1
    for slot in range(order.shape[0]):
        i = order[slot]
        lie.cayley(y[6 * slot + 3 : 6 * slot + 6], rotation)
        if last < 0 or (spins[i] != spins[last]).any():
            _turned(spins[i], time, turn)
            last = i
        for k in range(3):
            positions[i, k] = base_positions[i, k] + y[6 * slot + k]
            for a in range(3):
                base[a, k] = (
                    turn[a, 0] * base_frames[i, 0, k]
                    + turn[a, 1] * base_frames[i, 1, k]
                    + turn[a, 2] * base_frames[i, 2, k]
                )
        for a in range(3):
            for k in range(3):
                frames[i, a, k] = (
                    rotation[k, 0] * base[a, 0]
                    + rotation[k, 1] * base[a, 1]
                    + rotation[k, 2] * base[a, 2]
                )


@kernel
def _turning(spin, frame, out):
    """out = Σ_a Ω_a e_a."""
    for k in range(3):
        out[k] = spin[0] * frame[0, k] + spin[1] * frame[1, k] + spin[2] * frame[2, k]


@kernel
def _relative(spin, frame, twist, omega):
    """ω − Σ_a Ω_a e_a of a sphere."""
    _turning(spin, frame, omega)
    for k in range(3):
        omega[k] = twist[3 + k] - omega[k]


@kernel
def _rates(y, order, drift, spins, frames, twists, out):
    omega = np.empty(3)
    for slot in range(order.shape[0]):
        i = order[slot]
        for k in range(3):
            out[6 * slot + k] = twists[i, k] - drift[k]
        _relative(spins[i], frames[i], twists[i], omega)
        lie.rate(y[6 * slot + 3 : 6 * slot + 6], omega, out[6 * slot + 3 : 6 * slot + 6])


@kernel
def _tangents(y, order, spins, frames, twists, maps):
    """maps[i] = T, T⁻¹ and ∂(T⁻¹)·ω, (3, 3) each, of every sphere with coordinates."""
    omega = np.empty(3)
    for slot in range(order.shape[0]):
        i = order[slot]
        _relative(spins[i], frames[i], twists[i], omega)
        theta = y[6 * slot + 3 : 6 * slot + 6]
        lie.tangent(theta, maps[i, 0])
        lie.inverse_tangent(theta, maps[i, 1])
        lie.rate_derivative(theta, omega, maps[i, 2])


@kernel
def _to_chart(blocks, slot_of, maps, turning):
    """blocks ← T_i⁻¹ D_ij T_j + δ_ij ∂(T_i⁻¹)·ω, in place."""
    count, width = blocks.shape[0], blocks.shape[1]
    centre = width // 2
    work = np.empty((6, 3))
    for i in range(count):
        if slot_of[i] < 0:
            continue
        own = blocks[i, centre]
        # ω − Ω changes by −φ × Ω = Ω × φ when the sphere turns, and Ω with it
        for k in range(3):
            k1, k2 = (k + 1) % 3, (k + 2) % 3
            own[3 + k, 3 + k1] -= turning[i, k2]
            own[3 + k, 3 + k2] += turning[i, k1]
        for m in range(width):
            j = (i + m - centre) % count
            if slot_of[j] < 0:
                continue
            block = blocks[i, m]
            for p in range(6):
                for q in range(3):
                    work[p, q] = 0.0
                    for k in range(3):
                        work[p, q] += block[p, 3 + k] * maps[j, 0, k, q]
                for q in range(3):
                    block[p, 3 + q] = work[p, q]
            for q in range(6):
                for p in range(3):
                    work[p, 0] = maps[i, 2, p, q - 3] if m == centre and q > 2 else 0.0
                    for k in range(3):
                        work[p, 0] += maps[i, 1, p, k] * block[3 + k, q]
                for p in range(3):
                    block[3 + p, q] = work[p, 0]


@kernel
def _product(blocks, order, slot_of, periodic, vector, out):
    count, width = blocks.shape[0], blocks.shape[1]
    centre = width // 2
    out[:] = 0.0
    for slot in range(order.shape[0]):
        i = order[slot]
        for m in range(width):
            j = i + m - centre
            if not periodic and (j < 0 or j >= count):
                continue
            other = slot_of[j % count]
            if other < 0:
                continue
            for p in range(6):
                for q in range(6):
                    out[6 * slot + p] += blocks[i, m, p, q] * vector[6 * other + q]


@kernel
def _fill_band(blocks, order, slot_of, periodic, shift, scale, half, band):
    """band ← shift · I + scale · J in the layout of LAPACK's banded factorisation.

    Column by column, as they lie in memory. The first ``half`` rows are LAPACK's own.
    """
    count, width = blocks.shape[0], blocks.shape[1]
    centre = width // 2
    for slot in range(order.shape[0]):
        for column in range(6 * slot, 6 * slot + 6):
            for row in range(half, 3 * half + 1):
                band[row, column] = 0.0
            band[2 * half, column] = shift
        for m in range(width):
            i = order[slot] - m + centre
            if not periodic and (i < 0 or i >= count):
                continue
            i %= count
            other = slot_of[i]
            if other < 0:
                continue
            for q in range(6):
                column = 6 * slot + q
                for p in range(6):
                    band[2 * half + 6 * other + p - column, column] += scale * blocks[i, m, p, q]


@kernel
def _push_forward(vector, maps, order, poses):
    """poses[i] = T (change of y): displacement and rotation in the lab."""
    for slot in range(order.shape[0]):
        i = order[slot]
        for p in range(3):
            poses[i, p], poses[i, 3 + p] = vector[6 * slot + p], 0.0
            for q in range(3):
                poses[i, 3 + p] += maps[i, 0, p, q] * vector[6 * slot + 3 + q]


@kernel
def _pull_back(twists, poses, turning, vector, maps, order, out):
    """out = T⁻¹ (v, ω + Ω × φ) + ∂(T⁻¹)·ω · vector, for a change of twists and poses."""
    omega = np.empty(3)
    for slot in range(order.shape[0]):
        i = order[slot]
        for k in range(3):
            k1, k2 = (k + 1) % 3, (k + 2) % 3
            omega[k] = twists[i, 3 + k]
            omega[k] += turning[i, k1] * poses[i, 3 + k2] - turning[i, k2] * poses[i, 3 + k1]
        for p in range(3):
            total = 0.0
            for q in range(3):
                total += maps[i, 1, p, q] * omega[q] + maps[i, 2, p, q] * vector[6 * slot + 3 + q]
            out[6 * slot + p], out[6 * slot + 3 + p] = twists[i, p], total


@kernel
def _largest_turn(y):
    largest = 0.0
    for slot in range(y.shape[0] // 6):
        x, z, w = y[6 * slot + 3], y[6 * slot + 4], y[6 * slot + 5]
        largest = max(largest, x * x + z * z + w * w)
    return math.sqrt(largest)


class ChartedChain:
    """The chain's ODE ẏ = f(t, y) about base poses that drift and spin.

    ``rates`` is f, ``linearise`` takes its Jacobian at a point, ``product`` applies that Jacobian,
    ``factorise`` and ``solve`` treat I − γJ with the part of J near the diagonal. ``evaluations``
    and ``jacobians`` count the work.
    """

    def __init__(self, model: Model) -> None:
        self.model = model
        count = model.count
        self._periodic = model.period > 0.0
        spheres = np.arange(count)
        if self._periodic:
            spheres = np.stack([spheres, spheres[::-1]], axis=1).ravel()[:count]
        self.order = spheres[~model.held[spheres]]
        self._slot_of = np.full(count, -1)
        self._slot_of[self.order] = np.arange(len(self.order))
        self.dimension = 6 * len(self.order)
        places = min(model.reach * (2 if self._periodic else 1), max(len(self.order) - 1, 0))
        self.bandwidth = 6 * places + 5
        self.evaluations = self.jacobians = 0
        self._positions, self._frames = np.empty((count, 3)), np.empty((count, 3, 3))
        self._twists, self._poses = np.empty((count, 6)), np.zeros((count, 6))
        self._blocks = np.empty((count, 2 * model.reach + 1, 6, 6))
        self._maps = np.empty((count, 3, 3, 3))
        self._band = np.empty((3 * self.bandwidth + 1, self.dimension), order="F")
        self._factors: tuple[np.ndarray, np.ndarray] | None = None

    def set_base(
        self,
        time: float,
        positions: np.ndarray,
        frames: np.ndarray,
        drift: np.ndarray,
        spin: float,
    ) -> None:
        """Take these poses as the base at ``time``, moving with ``drift`` (3,) and ``spin``.

        ``spin`` is the rate about e₁ of frames that are tied to each other. Those of free spheres
        each turn as slip, fields and flows turn their sphere now.
        """
        self.time, self.drift, self.spin = float(time), np.array(drift, float), float(spin)
        self._spins = np.zeros((self.model.count, 3))
        self._spins[:, 0] = self.spin
        if not (self.model.ties_frames or self.model.held.any()):
            twists = self.model.carrying_twists(positions, frames)
            self._spins = np.einsum("nak,nk->na", frames, twists[:, 3:])
        self.base_positions = np.array(positions, float)
        self.base_frames = np.array(frames, float)
        held = self.model.held
        at = self.base_positions
        self._origin = at[np.argmax(held)].copy() if held.any() else at.mean(axis=0)
        self._near = self.base_positions - self._origin
        self._positions[:], self._frames[:] = self._near, frames

    def rebase(self, time: float, positions: np.ndarray, frames: np.ndarray) -> None:
        """As :meth:`set_base`, with the mean drift and spin that slip, fields and flows give now.

        The elastic part is left out: it sums to nothing over the chain, but its fast transients
        would lend their rate to the base. Frames are orthonormalised, so that rounding does not
        add up from chart to chart.
        """
        frames = np.array(frames, float)
        lie.orthonormalise(frames)
        drift, spin = np.zeros(3), 0.0
        if not self.model.held.any():
            twists = self.model.carrying_twists(positions, frames)
            drift = twists[:, :3].mean(axis=0)
            spin = float(np.einsum("nk,nk->n", twists[:, 3:], frames[:, 0]).mean())
        self.set_base(time, positions, frames, drift, spin)

    def poses(self, time: float, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Positions (N, 3) and frames (N, 3, 3) at coordinates y; frames may be overwritten."""
        near, frames = self._poses_near(time, y)
        positions = near + (self._origin + self.drift * (time - self.time))
        # clamped spheres go nowhere, and stay where they are to the last bit
        positions[self.model.held] = self.base_positions[self.model.held]
        return positions, frames

    def _poses_near(self, time: float, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """As :meth:`poses`, with positions about an origin that drifts with the base."""
        _poses(
            y,
            self.order,
            self._near,
            self.base_frames,
            self._spins,
            time - self.time,
            self._positions,
            self._frames,
        )
        return self._positions, self._frames

    def _poses_of_model(self, time: float, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Poses as the model takes them: about the drifting origin, unless it asks for the lab.

        What acts between spheres depends on differences of positions, which lose their digits far
        from the origin of the lab: a chain would swim until rounding strained its links.
        """
        return self.poses(time, y) if self.model.needs_places else self._poses_near(time, y)

    def rates(self, time: float, y: np.ndarray, out: np.ndarray) -> None:
        """out = ẏ."""
        self.evaluations += 1
        positions, frames = self._poses_of_model(time, y)
        self.model.twists(positions, frames, self._twists)
        _rates(y, self.order, self.drift, self._spins, frames, self._twists, out)

    def linearise(self, time: float, y: np.ndarray) -> None:
        """Take the Jacobian at (time, y) for ``product``, ``factorise`` and ``jacobian``."""
        self.jacobians += 1
        positions, frames = self._poses_of_model(time, y)
        self.model.twists(positions, frames, self._twists)
        _tangents(y, self.order, self._spins, frames, self._twists, self._maps)
        self._turning = np.einsum("na,nak->nk", self._spins, frames)
        self.model.linearise(positions, frames, self._blocks)
        _to_chart(self._blocks, self._slot_of, self._maps, self._turning)

    def product(self, vector: np.ndarray, out: np.ndarray) -> None:
        """out = J · vector, with J the Jacobian of the last ``linearise``."""
        if self.model.is_banded:
            _product(self._blocks, self.order, self._slot_of, self._periodic, vector, out)
            return
        _push_forward(vector, self._maps, self.order, self._poses)
        changes = np.zeros((self.model.count, 6))
        self.model.add_product(self._poses, changes)
        _pull_back(
            changes,
            self._poses,
            self._turning,
            vector,
            self._maps,
            self.order,
            out,
        )

    def fill_band(self, band: np.ndarray, shift: complex, scale: complex) -> None:
        """band ← shift · I + scale · J, with J cut to the blocks near the diagonal.

        ``band`` (3w + 1, dimension), real or complex, is laid out for LAPACK's factors, with
        w = ``bandwidth``: row 2w + i − j, column j holds element (i, j). The first w rows, where
        LAPACK keeps what pivoting adds, are left as they are.
        """
        _fill_band(
            self._blocks,
            self.order,
            self._slot_of,
            self._periodic,
            shift,
            scale,
            self.bandwidth,
            band,
        )

    def factorise(self, gamma: float) -> None:
        """Prepare ``solve`` for I − γJ, with J cut to the blocks near the diagonal."""
        from scipy.linalg import lapack

        self.fill_band(self._band, 1.0, -gamma)
        width = self.bandwidth
        factors, pivots, info = lapack.dgbtrf(self._band, width, width, overwrite_ab=True)
        if info > 0:
            raise FloatingPointError(f"the Newton matrix is singular in column {info}")
        self._factors = factors, pivots

    def solve(self, vector: np.ndarray, out: np.ndarray) -> None:
        """out = (I − γJ)⁻¹ vector with the factors of the last ``factorise``."""
        from scipy.linalg import lapack

        assert self._factors is not None
        factors, pivots = self._factors
        out[:], _ = lapack.dgbtrs(factors, self.bandwidth, self.bandwidth, vector, pivots)

    def jacobian(self) -> np.ndarray:
        """The dense Jacobian of the last ``linearise``, column by column: for tests."""
        columns = np.empty((self.dimension, self.dimension))
        for unit, column in zip(np.eye(self.dimension), columns, strict=True):
            self.product(unit, column)
        return columns.T

    def has_outrun_base(self, y: np.ndarray) -> bool:
        """Whether a sphere has come farther from its base than the chain is long, as it lies now.

        A relative tolerance of y then says nothing of the chain, only of how little the drift of
        its bases knows of its path, and differences between spheres lose their digits. Clamped
        chains stay about their bases.
        """
        if self.model.held.any():
            return False
        shifts = y.reshape(-1, 6)[:, :3]
        extent = np.ptp(self._near[self.order] + shifts, axis=0)
        return bool(np.abs(shifts).max() > extent.max())

    def largest_turn(self, y: np.ndarray) -> float:
        """max |θ|, to be compared with :data:`TURN_LIMIT`."""
        return _largest_turn(y)
