"""(F, T) or (v, ω) of one effect: the base class of effects.

The class of an effect states its name, its equation, whether it acts in a scene, how to remove it,
its cost and its size. An object of the class, built for a scene, adds a wrench or a twist to every
sphere, and gives the derivative. :func:`nrchain.register_effect` makes it available in scenes,
runs, files and decompositions.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar, Literal, NamedTuple

import numpy as np

from nrchain._addresses import Term
from nrchain.errors import SceneError
from nrchain.inputs.rules import Section
from nrchain.scene.extensions import default_section
from nrchain.scene.loading import load_scene
from nrchain.scene.poses import initial_poses
from nrchain.scene.scene import Scene


class Cost(NamedTuple):
    """The work of an effect in one evaluation: the number of links, pairs or spheres it sums over.

    A pair counts twice, once for each sphere that feels the other.
    """

    visits: int
    unit: Literal["links", "pairs", "spheres"]

    def __str__(self) -> str:
        return f"{self.visits} {self.unit}"


class Effect:
    """(F, T) or (v, ω) of every sphere, due to one cause.

    Your own class states ``name``, ``summary``, ``equation`` and ``Section``. It defines
    :meth:`add_wrenches` or :meth:`add_twists`, and the derivative by :meth:`linearise`,
    :meth:`add_blocks` and :meth:`add_product`. If the effect on a sphere depends on its own pose
    alone, derive from :class:`OneBodyEffect`, which needs less.

    Attributes
    ----------
    name
        Its name in lists and decompositions.
    key
        The scene key that switches it on.
    summary, equation
        One line each.
    absence
        The line for a scene without it; by default the summary.
    gives
        ``"wrench"`` or ``"twist"``; ``"mobility"`` if it turns the wrenches of other
        effects into twists.
    Section
        The table ``[name]`` of a scene, with a default for every key; None if other sections
        switch the effect on.
    example
        Changes to a scene that switch it on, used by tests and by :func:`nrchain.check_effect`.
    covariant
        Whether wrenches or twists move and rotate with the chain as a whole.
    placed
        Whether it depends on absolute positions in the lab, and not only on differences of
        positions.
    carries
        Whether it may translate or spin the chain as a whole; charts then move with the chain.
    torque_free
        Whether its wrench is a force without torque, for all frames.
    fused
        Whether the model sums it in one pass with other effects.
    places
        Number of neighbours on either side for which :meth:`add_blocks` gives the whole derivative;
        None if only :meth:`add_product` does.
    whole_term
        Whether :meth:`term` gives the derivative beyond those neighbours, too.

    >>> from nrchain.effects.registry import effects
    >>> all(issubclass(effect, Effect) for effect in effects())
    True
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
    whole_term: bool = False

    def __init_subclass__(cls) -> None:
        if not hasattr(cls, "absence") and hasattr(cls, "summary"):
            cls.absence = cls.summary

    def __init__(self, scene: Scene) -> None:
        self.scene = scene

    def __reduce__(self) -> tuple[Any, ...]:
        # the scene defines an effect; the last point of linearisation is not kept
        return type(self), (self.scene,)

    @classmethod
    def section(cls, scene: Scene) -> Any:
        """The section of the effect in a scene, or the default one."""
        kind: Any = cls.Section
        return scene.further.get(kind.path) or default_section(kind)

    @classmethod
    def acts(cls, scene: Scene) -> bool:
        """Whether it contributes to a scene; by default, whether the scene has its section."""
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
        """Whether its forces on all spheres sum to zero, as internal forces do."""
        return False

    @classmethod
    def states_balance(cls) -> bool:
        """Whether the class defines :meth:`balanced` itself."""
        return vars(Effect)["balanced"].__func__ is not getattr(cls.balanced, "__func__", None)

    @classmethod
    def detail(cls, scene: Scene) -> str:
        """How it acts in a scene, in a few words."""
        return ", ".join(f"{k} {_text(v)}" for k, v in _given(cls.section(scene)).items())

    @classmethod
    def value(cls, scene: Scene) -> object:
        """The value of :attr:`key` in a scene; of a section, the keys that are set."""
        name, _, key = cls.key.partition(".")
        section = getattr(scene, name)
        return section.to_mapping().get(key) if key else _given(section)

    @classmethod
    def cost(cls, scene: Scene) -> Cost:
        """Its work in one evaluation; by default, one visit of every sphere."""
        return Cost(scene.chain.particles, "spheres")

    @classmethod
    def scale(cls, scene: Scene) -> float:
        """max (|v|, a|ω|): the size of its velocities; by default, that at the start."""
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
        """(F, T) or (v, ω) (6,) of a sphere of the infinite straight chain, and ∂/∂(u, φ) (6, 6).

        For effects that are the same for every sphere and depend on its own pose alone. Raises
        SceneError if the chain does not stay straight, or if the class does not define it.
        """
        allowed = (
            "is not part of the theory of the infinite straight chain"
            f" ({cls.__name__}.straight is not defined): remove it from the scene"
        )
        raise SceneError(cls.key, cls.value(scene), allowed)

    def add_wrenches(self, positions: np.ndarray, frames: np.ndarray, wrenches: np.ndarray) -> None:
        """wrenches (N, 6) += (F, T) on every sphere, in the lab."""
        raise NotImplementedError

    def add_twists(self, positions: np.ndarray, frames: np.ndarray, twists: np.ndarray) -> None:
        """twists (N, 6) += (v, ω) of every sphere, in the lab."""
        raise NotImplementedError

    def linearise(self, positions: np.ndarray, frames: np.ndarray) -> None:
        """Take the derivative here, for :meth:`add_blocks` and :meth:`add_product`.

        Later evaluations of wrenches or twists at other poses do not change it.
        """
        raise NotImplementedError

    def add_blocks(self, blocks: np.ndarray) -> None:
        """blocks (N, 2w + 1, 6, 6)[i, w + m] += ∂(F, T)_i or ∂(v, ω)_i / ∂(u, φ)_{i+m}.

        u displaces and φ rotates a sphere in the lab. Derivatives beyond w neighbours are left out.
        """
        raise NotImplementedError

    def add_product(self, poses: np.ndarray, out: np.ndarray) -> None:
        """out (N, 6) += ∂(F, T) or ∂(v, ω) · ``poses`` (N, 6), the whole derivative."""
        raise NotImplementedError

    def term(self) -> Term | None:
        """The effect as machine code; None where compiled code has to call its methods."""
        return None

    def carrying_term(self) -> Term | None:
        """What of the effect moves the chain as a whole; None for all of it."""
        return None

    energy: Any = None
    """``energy(positions, frames)`` = V if F = −∂V/∂r and T = −∂V/∂φ; otherwise None."""


class OneBodyEffect(Effect):
    """An effect that depends on the own pose of a sphere alone: :meth:`derivative` is enough.

    >>> from nrchain.effects.field import Field
    >>> issubclass(Field, OneBodyEffect)
    True
    """

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


def _given(section: Section) -> dict[str, Any]:
    """The keys of a section that differ from their default."""
    plain = type(section)()
    return {k: v for k, v in section.to_mapping().items() if getattr(plain, k) != v}


def _text(value: Any) -> str:
    if isinstance(value, tuple):
        return "[" + ", ".join(map(_text, value)) + "]"
    return f"{value:g}" if isinstance(value, float) else str(value)
