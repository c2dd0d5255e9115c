"""(F, T) or (v, ω) of one effect: what an effect is, and what it must know of itself.

An effect is a class. The class says what it is called, what it does in one line and one equation,
whether a scene calls for it, how to take it out, what it costs and how large it is; an object of
it, made for a scene, gives a wrench or a twist to every sphere, and its derivative. Registered with
:func:`nrchain.register_effect` it takes part wherever effects do: in scenes, runs, files,
decompositions and tests.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, Literal, NamedTuple

import numpy as np

from nrchain.errors import SceneError
from nrchain.inputs.rules import Section
from nrchain.scene.extensions import default_section
from nrchain.scene.poses import initial_poses
from nrchain.scene.scene import Scene, load_scene


class Cost(NamedTuple):
    """The work of an effect at every right-hand side: how many links, pairs or spheres it visits.

    A pair counts twice, once for each sphere that feels the other.
    """

    visits: int
    unit: Literal["links", "pairs", "spheres"]

    def __str__(self) -> str:
        return f"{self.visits} {self.unit}"


class Effect:
    """What one cause does to every sphere: a wrench (F, T), or a twist (v, ω).

    A class of your own states ``name``, ``summary``, ``equation`` and ``Section``, gives
    :meth:`add_wrenches` or :meth:`add_twists`, and the derivative by :meth:`linearise`,
    :meth:`add_blocks` and :meth:`add_product`; :class:`OneBodyEffect` asks for less where a sphere
    feels its own pose alone.

    Attributes
    ----------
    name
        What lists and decompositions call it.
    key
        The scene key that calls for it.
    summary, equation
        One line each.
    absence
        What is said of a scene without it; the summary unless given.
    gives
        ``"wrench"`` or ``"twist"``; ``"mobility"`` for what turns the wrenches of others to twists.
    Section
        The table ``[name]`` of a scene, every key with a default; None for an effect that other
        sections call for.
    example
        Changes to a scene that call for it: what the tests of all effects run it with.
    covariant
        Whether a chain that is moved and turned as a whole takes what it feels along.
    placed
        Whether it depends on where in the lab a sphere is, and not only on differences of
        positions, which keep their digits however far a chain swims.
    carries
        Whether it may carry or spin the chain as a whole, so that charts had better move with it.
    torque_free
        Whether its wrench is a force alone, however the spheres are turned.
    fused
        Whether the model does its work in one pass with that of others.
    places
        How far along the chain the blocks of :meth:`add_blocks` are the whole derivative; None if
        only :meth:`add_product` is.
    """

    name: ClassVar[str]
    key: ClassVar[str]
    summary: ClassVar[str]
    equation: ClassVar[str]
    absence: ClassVar[str]
    gives: ClassVar[Literal["wrench", "twist", "mobility"]] = "wrench"
    Section: ClassVar[type[Section] | None] = None
    example: ClassVar[Mapping[str, Any]] = {}
    covariant: ClassVar[bool] = True
    placed: ClassVar[bool] = True
    carries: ClassVar[bool] = False
    torque_free: ClassVar[bool] = False
    fused: ClassVar[bool] = False
    places: int | None = None

    def __init_subclass__(cls) -> None:
        if not hasattr(cls, "absence") and hasattr(cls, "summary"):
            cls.absence = cls.summary

    def __init__(self, scene: Scene) -> None:
        self.scene = scene

    def __reduce__(self) -> tuple[Any, ...]:
        # the scene is all there is to an effect; what it was last evaluated at is not kept
        return type(self), (self.scene,)

    @classmethod
    def section(cls, scene: Scene) -> Any:
        """The section of the effect in a scene, or the default one."""
        kind: Any = cls.Section
        return scene.further.get(kind.path) or default_section(kind)

    @classmethod
    def acts(cls, scene: Scene) -> bool:
        """Whether it contributes to a scene; unless said better, whether any key is not default."""
        assert cls.Section is not None
        return cls.Section.path in scene.further

    @classmethod
    def without(cls, scene: Scene) -> Scene:
        """The scene with this effect taken out, and nothing else changed."""
        assert cls.Section is not None
        return load_scene(scene, **{cls.Section.path: None})

    @classmethod
    def check(cls, scene: Scene) -> None:
        """Refuse a scene in which the effect has no meaning, with a SceneError."""

    @classmethod
    def balanced(cls, scene: Scene) -> bool:
        """Whether its forces on all spheres add up to nothing, as internal forces do."""
        return False

    @classmethod
    def states_balance(cls) -> bool:
        """Whether the class says itself what :meth:`balanced` is."""
        return vars(Effect)["balanced"].__func__ is not getattr(cls.balanced, "__func__", None)

    @classmethod
    def detail(cls, scene: Scene) -> str:
        """How it acts in a scene, in a few words."""
        section = cls.section(scene)
        plain = type(section)()
        given = {k: v for k, v in section.to_mapping().items() if getattr(plain, k) != v}
        return ", ".join(f"{k} {_text(v)}" for k, v in given.items())

    @classmethod
    def cost(cls, scene: Scene) -> Cost:
        """What it visits at every right-hand side where it acts."""
        return Cost(scene.chain.particles, "spheres")

    @classmethod
    def scale(cls, scene: Scene) -> float:
        """The size of its velocities, max (|v|, a|ω|); unless better known, that at the start."""
        out = np.zeros((scene.chain.particles, 6))
        effect, poses = cls(scene), initial_poses(scene)
        if cls.gives == "wrench":
            effect.add_wrenches(*poses, out)
            out /= np.repeat(scene.drag, 3)
        else:
            effect.add_twists(*poses, out)
        return largest_velocity(out, scene.chain.radius)

    @classmethod
    def straight(cls, scene: Scene) -> tuple[np.ndarray, np.ndarray]:
        """What it does to a sphere of the infinite straight chain: (6,), and (6, 6) with its pose.

        A wrench, or a twist, and its derivative with (u, φ), when every sphere feels the same, by
        its own pose alone. Refused where no straight chain stays as it is, and by a class that
        does not say.
        """
        allowed = (
            f"has no part in the laws of the endless straight chain ({cls.__name__}.straight does"
            " not say what it does there): take it out of the scene"
        )
        raise SceneError(cls.key, cls.detail(scene), allowed)

    def add_wrenches(self, positions: np.ndarray, frames: np.ndarray, wrenches: np.ndarray) -> None:
        """wrenches (N, 6) += (F, T) on every sphere, in the lab."""
        raise NotImplementedError

    def add_twists(self, positions: np.ndarray, frames: np.ndarray, twists: np.ndarray) -> None:
        """twists (N, 6) += (v, ω) of every sphere, in the lab."""
        raise NotImplementedError

    def linearise(self, positions: np.ndarray, frames: np.ndarray) -> None:
        """Take the derivative here, for :meth:`add_blocks` and :meth:`add_product`.

        It stays as it is while wrenches or twists are evaluated elsewhere.
        """
        raise NotImplementedError

    def add_blocks(self, blocks: np.ndarray) -> None:
        """blocks (N, 2w + 1, 6, 6)[i, w + m] += ∂(F, T)_i or ∂(v, ω)_i / ∂(u, φ)_{i+m}.

        u displaces and φ turns a sphere in the lab. Derivatives beyond w places are left out.
        """
        raise NotImplementedError

    def add_product(self, poses: np.ndarray, out: np.ndarray) -> None:
        """out (N, 6) += the change of the wrenches or twists with ``poses`` (N, 6), all of it."""
        raise NotImplementedError

    energy: Any = None
    """``energy(positions, frames)`` is V of an effect with F = −∂V/∂r and T = −∂V/∂φ, if any."""


class OneBodyEffect(Effect):
    """An effect that a sphere feels by its own pose alone: only :meth:`derivative` is asked for."""

    places = 0

    def derivative(self, positions: np.ndarray, frames: np.ndarray) -> np.ndarray:
        """∂(F, T)_i or ∂(v, ω)_i / ∂(u, φ)_i (N, 6, 6)."""
        raise NotImplementedError

    def linearise(self, positions: np.ndarray, frames: np.ndarray) -> None:
        self._own = self.derivative(positions, frames)

    def add_blocks(self, blocks: np.ndarray) -> None:
        blocks[:, blocks.shape[1] // 2] += self._own

    def add_product(self, poses: np.ndarray, out: np.ndarray) -> None:
        out += np.einsum("npq,nq->np", self._own, poses)


def largest_velocity(twists: np.ndarray, radius: float) -> float:
    """max (|v|, a|ω|) of twists (N, 6)."""
    velocities = np.linalg.norm(twists[:, :3], axis=1)
    spins = np.linalg.norm(twists[:, 3:], axis=1)
    return float(max(velocities.max(), radius * spins.max()))


def cross_matrix(vectors: np.ndarray) -> np.ndarray:
    """The matrices (N, 3, 3) of w ↦ v × w for vectors v (N, 3)."""
    matrices = np.zeros((len(vectors), 3, 3))
    for k in range(3):
        matrices[:, k, (k + 1) % 3] = -vectors[:, (k + 2) % 3]
        matrices[:, k, (k + 2) % 3] = vectors[:, (k + 1) % 3]
    return matrices


def _text(value: Any) -> str:
    if isinstance(value, tuple):
        return "[" + ", ".join(map(_text, value)) + "]"
    return f"{value:g}" if isinstance(value, float) else str(value)
