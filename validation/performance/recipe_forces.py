"""(v, ω) of a chain by PyStokes and NumPy: the right-hand side of the recipe.

Arrays are component-major, as in PyStokes: positions (3, N), frames (component, vector, N).
It shares only the table of PyStokes' factors with the package.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from nrchain import Scene, slip_modes
from nrchain.hydrodynamics import pystokes as adapter

Array = NDArray[np.float64]

TURNS = (np.array([1, 0, 2]), np.array([2, 1, 0]))
"""Frame vectors of the two spheres of a link in the products of twist and bend."""


class PairSlip:
    """Σ_j (u, w) by ``pystokes.unbounded.Rbm``, with the factors of the installed release."""

    def __init__(self, scene: Scene) -> None:
        import pystokes

        chain, reach = scene.chain, scene.slip.neighbours
        count = chain.particles
        self.pairs: list[tuple[Array, int]] = []
        if reach != "all" and int(reach) < count - 1:
            spheres = np.arange(count)
            gaps = range(1, int(reach) + 1)
            self.pairs = [(np.stack([spheres[:-m], spheres[m:]], 1), m) for m in gaps]
        self.routines = []
        for label, slip in scene.slip.modes.items():
            mode = adapter.RELEASES[pystokes.__version__][label]
            power = max(k for _, k in slip_modes.find(label).velocity)
            finite = scene.slip.finite_size and mode.finite_size is not None
            for part, routine in enumerate(
                (mode.finite_size if finite else mode.velocity, mode.spin)
            ):
                if routine is None:
                    continue
                handed = routine.size * chain.radius
                rbm = pystokes.unbounded.Rbm(
                    radius=handed, particles=2 if self.pairs else count, viscosity=chain.viscosity
                )
                factor = chain.radius**power / (float(routine.ratio) * handed**routine.power)
                strengths = factor * np.broadcast_to(slip.strength, count)
                self.routines.append((getattr(rbm, routine.method), part, mode.rank, strengths))

    def tensors(self, axis: Array) -> list[Array]:
        """V (e…e − traces) of every routine, its factor included: (2l + 1, N) each."""
        bare = {rank: irreducible(rank, axis) for rank in {row[2] for row in self.routines}}
        return [strengths * bare[rank] for _, _, rank, strengths in self.routines]

    def add(self, centres: Array, tensors: list[Array], out: Array) -> None:
        """out (2, 3, N) += (Σu, Σw) at ``centres`` (3, N)."""
        for (method, part, _, _), tensor in zip(self.routines, tensors, strict=True):
            if not self.pairs:
                method(out[part].reshape(-1), centres.reshape(-1), tensor.reshape(-1))
            for pairs, gap in self.pairs:
                two = np.zeros((len(pairs), 6))
                places = centres[:, pairs].transpose(1, 0, 2).reshape(len(pairs), -1)
                shapes = tensor[:, pairs].transpose(1, 0, 2).reshape(len(pairs), -1)
                for result, place, shape in zip(two, places, shapes, strict=True):
                    method(result, place, shape)
                first, second = two.reshape(-1, 3, 2).transpose(2, 1, 0)
                out[part, :, :-gap] += first
                out[part, :, gap:] += second


class PairFriction:
    """(v, ω) = μ·(F, T) by the four ``mobility*`` routines, all pairs."""

    def __init__(self, scene: Scene) -> None:
        import pystokes

        chain = scene.chain
        self.rbm = pystokes.unbounded.Rbm(
            radius=chain.radius, particles=chain.particles, viscosity=chain.viscosity
        )

    def add(self, centres: Array, forces: Array, torques: Array, out: Array) -> None:
        """out (2, 3, N) += the twists that forces and torques (3, N) cause."""
        places, f, t = centres.reshape(-1), forces.reshape(-1), torques.reshape(-1)
        velocities, spins = out[0].reshape(-1), out[1].reshape(-1)
        self.rbm.mobilityTT(velocities, places, f)
        self.rbm.mobilityTR(velocities, places, t)
        self.rbm.mobilityRT(spins, places, f)
        self.rbm.mobilityRR(spins, places, t)


class Elasticity:
    """F = −∂V/∂r and T = −Σ_a e_a × ∂V/∂e_a of the paper's Appendix B, all links at once."""

    def __init__(self, scene: Scene) -> None:
        from scipy.sparse import csr_array

        count, d = scene.chain.particles, scene.chain.spacing
        average, difference = np.zeros((2, count - 1, count))
        for link in range(count - 1):
            inner = 0 < link < count - 2
            spheres = slice(link - 1, link + 3) if inner else slice(link, link + 2)
            average[link, spheres] = [-1 / 16, 9 / 16, 9 / 16, -1 / 16] if inner else [0.5, 0.5]
            weights = [1 / 24, -27 / 24, 27 / 24, -1 / 24] if inner else [-1, 1]
            difference[link, spheres] = np.array(weights) / d
        self.average, self.difference = csr_array(average), csr_array(difference)
        self.spread, self.divergence = csr_array(average.T), csr_array(difference.T)
        stretch, shear, twist, bend = scene.moduli
        self.stiffness = d**2 * np.array([[stretch], [shear], [shear]])
        self.turning = np.array([[twist], [bend], [bend]])

    def wrenches(self, centres: Array, frames: Array) -> tuple[Array, Array]:
        """Forces and torques (3, N) for ``frames`` (component, vector, N)."""
        count = centres.shape[1]
        tangent = (self.difference @ centres.T).T
        middle = (self.average @ frames.reshape(9, count).T).T.reshape(3, 3, count - 1)
        tension = (middle * tangent[:, None]).sum(axis=0)
        tension[0] -= 1.0
        tension *= self.stiffness
        forces = -(self.divergence @ (middle * tension).sum(axis=1).T).T
        pull = tangent[:, None] * tension
        slope = (self.spread @ pull.reshape(9, count - 1).T).T.reshape(3, 3, count).copy()
        a, b = TURNS
        left, right = frames[:, a, :-1], frames[:, b, 1:]
        moment = self.turning * (left * right).sum(axis=0)
        slope[:, a, :-1] += moment * right
        slope[:, b, 1:] += moment * left
        return np.ascontiguousarray(forces), -cross(frames, slope).sum(axis=1)


def irreducible(rank: int, e: Array) -> Array:
    """e…e − traces of unit vectors (3, N): the components of PyStokes, in its order."""
    x, y, z = e
    if rank == 1:
        return e
    if rank == 2:
        return np.stack([x * x - 1 / 3, y * y - 1 / 3, x * y, x * z, y * z])
    fifth = 1 / 5
    return np.stack(
        [
            x * (x * x - 3 * fifth),
            y * (y * y - 3 * fifth),
            y * (x * x - fifth),
            z * (x * x - fifth),
            x * (y * y - fifth),
            x * y * z,
            z * (y * y - fifth),
        ]
    )


_NEXT, _LAST = np.array([1, 2, 0]), np.array([2, 0, 1])


def cross(a: Array, b: Array) -> Array:
    """a × b along the first axis."""
    return a[_NEXT] * b[_LAST] - a[_LAST] * b[_NEXT]
