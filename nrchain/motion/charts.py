"""r_i = r_i⁰(t) + ρ_i, R_i = cay(θ_i) R_i⁰(t): the poses of a chain as coordinates y, and its ODE.

Every sphere has a base pose and six coordinates (ρ, θ) about it, zero at the start: its
displacement from the base, and the rotation from the frame of the base by the Cayley map. The base
moves: all bases drift with one velocity V, and each rotates with Ω, constant along its own axes
e_a. A chain that swims or spins steadily stays near y = 0. If elasticity couples the frames, Ω lies
along e₁ and is the same for all spheres; otherwise each base rotates as its own sphere does. The
rates are

    ρ̇ = v − V,   θ̇ = dcay⁻¹(ω − Σ_a Ω_a e_a)   (see :func:`nrchain.geometry.lie.rate`),

and the Jacobian is J_ij = T_i⁻¹ D_ij T_j + δ_ij ∂(T_i⁻¹)·ω, with D the derivative of the twists
with displacements and rotations in the lab and T the tangent of the Cayley map, the identity for ρ.

Why not one chart of SE(3): ρ would be p − θ × p/2, with p = r − r⁰. The position of a sphere that
translates and rotates would then have the error of θ times its distance from the base, even on a
simple path.

Clamped spheres have no coordinates: slot s of y holds the six of the s-th free sphere.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from nrchain.geometry import lie
from nrchain.motion import chart_jacobian, chart_poses
from nrchain.motion.block_elimination import FINE, Elimination
from nrchain.motion.moving_chart import empty_chart
from nrchain.motion.pose_model import PoseModel

if TYPE_CHECKING:
    from scipy.sparse import csc_matrix


class ChartedChain:
    """ẏ = f(t, y): the motion of a chain in coordinates about base poses that drift and spin.

    ``rates`` is f, ``linearise`` takes its Jacobian at a point and ``product`` applies it.
    ``factorise`` and ``solve`` invert I − cJ with the part of J near the diagonal. ``evaluations``
    and ``jacobians`` count the calls of ``rates`` and ``linearise``. ``is_banded`` says whether
    that part is all of J. ``chart`` holds the base, for compiled code that moves it.
    """

    def __init__(self, model: PoseModel) -> None:
        self.model = model
        count = model.count
        self.is_banded = model.is_banded
        self._periodic = model.period > 0.0
        self.order = np.flatnonzero(~model.held)
        self._slot_of = np.full(count, -1)
        self._slot_of[self.order] = np.arange(len(self.order))
        self.dimension = 6 * len(self.order)
        self.evaluations = self.jacobians = 0
        self.chart = empty_chart(count)
        self._positions, self._frames = self.chart.positions, self.chart.turned
        self._twists, self._maps = self.chart.twists, self.chart.maps
        self._poses = np.zeros((count, 6))
        self._blocks = np.empty((count, 2 * model.reach + 1, 6, 6))
        self._held = model.held.astype(np.int64)
        # for real and for complex c
        self._eliminations: dict[bool, Elimination] = {}

    def set_base(
        self,
        time: float,
        positions: np.ndarray,
        frames: np.ndarray,
        drift: np.ndarray,
        spin: float,
    ) -> None:
        """Take these poses as the base at ``time``, moving with ``drift`` (3,) and ``spin``.

        Coupled frames rotate about e₁ at the rate ``spin``. Frames of free spheres rotate each as
        slip, fields and flows rotate the sphere at this time.
        """
        chart, held = self.chart, self.model.held
        chart.clock[0], chart.drift[:], self.spin = time, drift, float(spin)
        chart.spins[:] = [self.spin, 0.0, 0.0]
        if not (self.model.ties_frames or held.any()):
            twists = self.model.carrying_twists(positions, frames)
            chart.spins[:] = np.einsum("nak,nk->na", frames, twists[:, 3:])
        chart.places[:], chart.frames[:] = positions, frames
        chart.origin[:] = positions[np.argmax(held)] if held.any() else positions.mean(axis=0)
        chart.near[:] = chart.places - chart.origin
        self._positions[:], self._frames[:] = chart.near, frames

    @property
    def time(self) -> float:
        """When the base was set."""
        return float(self.chart.clock[0])

    @property
    def drift(self) -> np.ndarray:
        """V (3,) of all bases."""
        return self.chart.drift

    @property
    def base_positions(self) -> np.ndarray:
        """Positions (N, 3) of the bases at ``time``."""
        return self.chart.places

    @property
    def base_frames(self) -> np.ndarray:
        """Frames (N, 3, 3) of the bases at ``time``."""
        return self.chart.frames

    def rebase(self, time: float, positions: np.ndarray, frames: np.ndarray) -> None:
        """As :meth:`set_base`, with the mean drift and spin due to slip, fields and flows.

        Elastic forces sum to zero over the chain; they are left out because of their fast
        transients. Frames are orthonormalised: rounding does not add up from chart to chart.
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
        positions = near + (self.chart.origin + self.drift * (time - self.time))
        # clamped spheres keep their positions to the last bit
        positions[self.model.held] = self.base_positions[self.model.held]
        return positions, frames

    def _poses_near(self, time: float, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """As :meth:`poses`, with positions relative to an origin that drifts with the base."""
        chart_poses.set_poses(
            y,
            self.order,
            self.chart.near,
            self.chart.frames,
            self.chart.spins,
            time - self.time,
            self._positions,
            self._frames,
        )
        return self._positions, self._frames

    def _poses_of_model(self, time: float, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Poses for the model: relative to the drifting origin, or in the lab if it needs that.

        Interactions depend on differences of positions, which lose digits far from the origin of
        the lab: rounding would strain the links of a chain that swims far.
        """
        return self.poses(time, y) if self.model.needs_places else self._poses_near(time, y)

    def rates(self, time: float, y: np.ndarray, out: np.ndarray) -> None:
        """out = ẏ."""
        self.evaluations += 1
        positions, frames = self._poses_of_model(time, y)
        self.model.twists(positions, frames, self._twists)
        chart_poses.set_rates(
            y, self.order, self.drift, self.chart.spins, frames, self._twists, out
        )

    def linearise(self, time: float, y: np.ndarray) -> None:
        """Take J at (time, y), for ``product``, ``factorise`` and ``jacobian``."""
        self.jacobians += 1
        positions, frames = self._poses_of_model(time, y)
        self.model.twists(positions, frames, self._twists)
        chart_jacobian.set_tangents(
            y, self.order, self.chart.spins, frames, self._twists, self._maps
        )
        self._turning = np.einsum("na,nak->nk", self.chart.spins, frames)
        self.model.linearise(positions, frames, self._blocks)
        chart_jacobian.transform_blocks(self._blocks, self._slot_of, self._maps, self._turning)

    def product(self, vector: np.ndarray, out: np.ndarray) -> None:
        """out = J · vector, with J of the last ``linearise``."""
        if self.is_banded:
            chart_jacobian.multiply(
                self._blocks, self.order, self._slot_of, self._periodic, vector, out
            )
            return
        chart_jacobian.to_poses(vector, self._maps, self.order, self._poses)
        changes = np.zeros((self.model.count, 6))
        self.model.add_product(self._poses, changes)
        chart_jacobian.to_rates(
            changes,
            self._poses,
            self._turning,
            vector,
            self._maps,
            self.order,
            out,
        )

    def factorise(self, scale: complex) -> None:
        """Prepare ``solve`` for I − scale · J, with J cut to the blocks near the diagonal.

        ``scale`` is a float or a complex number of Python. Raises FloatingPointError if the matrix
        is singular.
        """
        turns = isinstance(scale, complex)
        if turns not in self._eliminations:
            kind = complex if turns else float
            elimination = Elimination(self._blocks, self._held, self._periodic, kind)
            self._eliminations[turns] = elimination
        if self._eliminations[turns].factorise(scale) != FINE:
            raise FloatingPointError("the Newton matrix is singular")

    def solve(self, vector: np.ndarray, out: np.ndarray) -> None:
        """out = (I − scale · J)⁻¹ vector with the last factors of the type of ``out``."""
        out[:] = vector
        self._eliminations[np.iscomplexobj(out)].solve(out, self.order)

    def near_jacobian(self) -> csc_matrix:
        """The blocks near the diagonal of the last ``linearise``, as a sparse matrix."""
        from scipy.sparse import csc_matrix

        count, width = self._blocks.shape[:2]
        i, m = np.indices((count, width))
        j = i + m - width // 2
        inside = (j >= 0) & (j < count) | self._periodic
        i, m, j = i[inside], m[inside], j[inside] % count
        row, column = self._slot_of[i], self._slot_of[j]
        free = (row >= 0) & (column >= 0)
        p, q = np.indices((6, 6))
        rows = 6 * row[free, None, None] + p
        columns = 6 * column[free, None, None] + q
        values = self._blocks[i[free], m[free]]
        shape = self.dimension, self.dimension
        return csc_matrix((values.ravel(), (rows.ravel(), columns.ravel())), shape=shape)

    def symmetric_band(self) -> np.ndarray | None:
        """The symmetric part of √μ⁻¹ J √μ by lower diagonals, with J near the diagonal at y = 0.

        μ is that of one-body friction. The largest eigenvalue bounds Re λ of J, and equals it where
        all forces have an energy. None for a periodic chain.
        """
        if self._periodic:
            return None
        translation, rotation = self.model.drag
        band = np.empty((3 * self._blocks.shape[1] + 3, self.dimension))
        ratio = float(np.sqrt(translation / rotation))
        chart_jacobian.set_symmetric_band(self._blocks, self._slot_of, ratio, band)
        return band

    def jacobian(self) -> np.ndarray:
        """The dense Jacobian of the last ``linearise``, column by column."""
        columns = np.empty((self.dimension, self.dimension))
        for unit, column in zip(np.eye(self.dimension), columns, strict=True):
            self.product(unit, column)
        return columns.T

    def has_outrun_base(self, y: np.ndarray) -> bool:
        """Whether a sphere is farther from its base than the present extent of the chain.

        A relative tolerance of y is then no measure of the shape of the chain, and differences
        between spheres lose digits. Clamped chains stay near their bases.
        """
        if self.model.held.any():
            return False
        shifts = y.reshape(-1, 6)[:, :3]
        extent = np.ptp(self.chart.near[self.order] + shifts, axis=0)
        return bool(np.abs(shifts).max() > extent.max())

    def largest_turn(self, y: np.ndarray) -> float:
        """max |θ|, to compare with :data:`TURN_LIMIT`."""
        return chart_poses.largest_turn(y)
