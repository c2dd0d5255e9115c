"""The wrenches of a chain on a helix: stress, sources, their errors and their slopes at rest."""

from __future__ import annotations

import numpy as np

from nrchain.effects.shared.image_sums import refuse_reach
from nrchain.effects.shared.slip_flow import largest_flow
from nrchain.effects.steric import Steric
from nrchain.errors import SceneError
from nrchain.hydrodynamics import slip_modes
from nrchain.hydrodynamics.pairs import SlipFlow
from nrchain.hydrodynamics.slip import Slip
from nrchain.potential.chain import REACH, Elasticity, terms_of
from nrchain.scene.scene import Scene
from nrchain.theory.rod.helix import Helix
from nrchain.theory.rod.uniform_scene import body_wrench, uniform_slip

ROUNDING = 1e-15
"""Error of a sum of wrenches, relative to the sum of their sizes."""

WEIGHTS = np.array([4 / 5, -1 / 5, 4 / 105, -1 / 280])
"""Central difference of eighth order: coefficients of f(nh) − f(−nh), over h."""


class UniformChain:
    """The interactions of a chain, evaluated on helices."""

    def __init__(self, scene: Scene) -> None:
        slips, self.body = uniform_slip(scene), body_wrench(scene)
        if scene.friction.kind != "one-body":
            allowed = (
                "must be 'one-body' for finite strains; nrchain.moduli takes friction between"
                " neighbours"
            )
            raise SceneError("friction.kind", scene.friction.kind, allowed)
        chain, reach = scene.chain, scene.slip.neighbours
        refuse_reach(scene, "slip.neighbours", reach)
        self.reach = (chain.particles - 1 if reach == "all" else reach) if slips else 0
        self._spacing, self._drag = chain.spacing, np.repeat(scene.drag, 3)
        self._sizes = _largest_wrenches(scene, slips)
        self._pair = SlipFlow(
            list(slips),
            [np.full(2, slip.strength) for slip in slips.values()],
            [slip.axis for slip in slips.values()],
            count=2,
            reach=1,
            radius=chain.radius,
            finite_size=scene.slip.finite_size,
        )
        isotropic = scene.elasticity.measure == "isotropic"
        self._elasticity = Elasticity(
            chain.spacing, 0.0, tuple(scene.moduli), isotropic, terms_of(scene.moduli)
        )
        self._contact = 2.0 * chain.radius
        if Steric.acts(scene):
            self._contact = max(self._contact, Steric.range(scene))

    def respond(self, strain: np.ndarray) -> np.ndarray:
        """Active and elastic stress and the sources (3, 6) in one state."""
        helix, d = Helix(strain), self._spacing
        places = d * np.arange(1, self.reach + 1)
        self._refuse_contact(helix, strain)
        on_first, on_last = self._pair_wrenches(helix, places)
        source = self.body + _mean_on_both(helix, places, on_first, on_last).sum(axis=0)
        # link l is crossed by the pairs (0, m) with m ≥ l; on a helix it is like the first link
        crossing = np.cumsum(0.5 * (on_first - on_last)[::-1], axis=0)[::-1]
        through = helix.carry(crossing, places - d).sum(axis=0)
        stress = helix.integral(through, 0.0, d) / d
        return np.array([stress, self._elastic_stress(helix), source / d])

    def second_moment(self, strain: np.ndarray) -> np.ndarray:
        """Σ_m (md)² × the source of the m-th neighbours per length (6,) in one state."""
        helix = Helix(strain)
        places = self._spacing * np.arange(1, self.reach + 1)
        sources = _mean_on_both(helix, places, *self._pair_wrenches(helix, places))
        return places**2 @ sources / self._spacing

    def rounding(self, strain: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Bounds (6,) of the rounding errors of the stress and of the sources in one state."""
        d, count = self._spacing, np.arange(1.0, self.reach + 1)
        distances = np.linalg.norm(Helix(strain).at(d * count)[0], axis=1)
        pulls, torques = (
            sum((size * distances**-power for power, size in sizes.items()), 0.0 * distances)
            for sizes in self._sizes
        )
        force = float(np.sum(count * pulls))
        moment = float(np.sum(count * (torques + count * d * pulls)))
        stretch, shear, twist, bend = self._elasticity.moduli
        springs = d * (stretch + shear)
        # rounding of C¹r − 1 and of products of frames, which are of order 1
        stress = [force + springs] * 3 + [moment + d * springs + d * (twist + bend)] * 3
        source = [force / d] * 3 + [moment / d] * 3
        return ROUNDING * np.array(stress), ROUNDING * np.array(source)

    def slopes(self, steps: np.ndarray) -> np.ndarray:
        """Derivatives (3, 6, 6) of :meth:`respond` at zero strain, one strain a column."""
        columns = []
        for axis, step in enumerate(steps):
            state = np.zeros(6)
            total = np.zeros((3, 6))
            for n, weight in enumerate(WEIGHTS, start=1):
                state[axis] = n * step
                total += weight * (self.respond(state) - self.respond(-state))
            columns.append(total / step)
        return np.stack(columns, axis=-1)

    def _pair_wrenches(self, helix: Helix, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Wrenches (N, 6) about the origin: of spheres at ``places`` on that at 0, and back."""
        positions, frames = helix.poses(np.concatenate([[0.0], places]))
        twists = np.zeros((len(places), 2, 6))
        for m, pair in enumerate(twists, start=1):
            self._pair.add_twists(positions[[0, m]], frames[[0, m]], pair)
        wrenches = self._drag * twists
        wrenches[:, 1, 3:] += np.cross(positions[1:], wrenches[:, 1, :3])
        return wrenches[:, 0], wrenches[:, 1]

    def _elastic_stress(self, helix: Helix) -> np.ndarray:
        """Minus the elastic wrench that the left half of a short chain exerts across its middle."""
        if not self._elasticity:
            return np.zeros(6)
        half, d = REACH + 1, self._spacing
        positions, frames = helix.poses(d * np.arange(2 * half))
        wrenches = np.zeros((2 * half, 6))
        self._elasticity.add_wrenches(positions, frames, wrenches)
        wrenches[:, 3:] += np.cross(positions, wrenches[:, :3])
        # internal wrenches of the left half cancel: what is left is that of right on left
        return helix.integral(wrenches[:half].sum(axis=0), (half - 1) * d, half * d) / d

    def _refuse_contact(self, helix: Helix, strain: np.ndarray) -> None:
        places = self._spacing * np.arange(1, max(self.reach, 1) + 1)
        nearest = float(np.linalg.norm(helix.at(places)[0], axis=1).min())
        if nearest <= self._contact:
            allowed = (
                f"brings spheres to a distance of {nearest:g}: it must stay above {self._contact:g}"
            )
            raise SceneError("strains", strain.tolist(), allowed)


def _mean_on_both(
    helix: Helix, places: np.ndarray, on_first: np.ndarray, on_last: np.ndarray
) -> np.ndarray:
    """Wrenches (N, 6) on a sphere of its pairs: the mean of both spheres of a pair, on each."""
    both = 0.5 * (on_first + on_last)
    return both + helix.carry(both, places)


def _largest_wrenches(
    scene: Scene, slips: dict[str, Slip]
) -> tuple[dict[int, float], dict[int, float]]:
    """Bounds of the force and of the torque of a pair, for any frames: c_k of Σ c_k/r^k."""
    pulls: dict[int, float] = {}
    torques: dict[int, float] = {}
    radius, finite_size = scene.chain.radius, scene.slip.finite_size
    for label, slip in slips.items():
        mode, strength = slip_modes.find(label), float(np.max(np.abs(slip.strength)))
        for sizes, table, factor in (
            (pulls, mode.flow(finite_size), scene.drag.translation),
            (torques, mode.spin(finite_size), scene.drag.rotation / radius),
        ):
            for (basis, power), row in table.items():
                size = strength * factor * largest_flow({(basis, power): row}, 1.0, radius)
                sizes[power] = sizes.get(power, 0.0) + size
    return pulls, torques
