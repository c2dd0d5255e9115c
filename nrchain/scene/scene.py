"""A scene: everything that decides a run, checked before any time is spent.

A scene is made from TOML (:func:`load_scene`, :meth:`Scene.from_toml`) or from Python, and the
two are the same thing: a section is a table of the file, a field a key of it. In ``[slip]`` every
mode is a key of its own,

    [slip]
    neighbours = 1
    2s = 100.0                                     # one strength for all
    3a = [10.0, 20.0, 30.0]                        # one a sphere
    4a = {strength = 5.0, axis = [0.0, 1.0, 0.0]}  # its own body axis

Lengths, times and masses may have any unit as long as all share it; the defaults are the paper's,
a = η = 1 and d = 10.
"""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any, Literal, NamedTuple, Self

from nrchain.errors import SceneError, shorten
from nrchain.hydrodynamics import slip_modes
from nrchain.hydrodynamics.slip import Slip
from nrchain.inputs.arrays import refuse_rows
from nrchain.inputs.names import SURE, did_you_mean, nearest
from nrchain.inputs.rules import Section, choice, line, number, optional, section, unknown
from nrchain.scene.extensions import default_section, extensions
from nrchain.scene.sections import (
    POSES,
    ChainSpec,
    EffectSections,
    ElasticitySpec,
    FrictionSpec,
    RunSpec,
    SlipSpec,
    StartSpec,
    read_effects,
    read_friction,
    register_first,
)
from nrchain.scene.toml import (
    change,
    parse_assignment,
    read_source,
    read_toml,
    scene_names,
    scene_path,
    write_toml,
)
from nrchain.wording import span

__all__ = [
    "DEFAULT_RATIO",
    "ChainSpec",
    "Drag",
    "ElasticitySpec",
    "FrictionSpec",
    "Moduli",
    "RunSpec",
    "Scene",
    "Slip",
    "SlipSpec",
    "StartSpec",
    "load_scene",
    "parse_assignment",
    "scene_names",
    "scene_path",
]

DEFAULT_RATIO = 1e7
"""R of the stiffness rule when a scene gives no stiffness; the paper's for its snapshots."""

CHOSEN = {
    "slip": ("neighbours", "finite_size"),
    "flow": ("neighbours", "finite_size"),
    "friction": ("kind", "neighbours"),
}
"""The keys of each section that effects = "auto" decides."""

Effects = Literal["named", "auto"]


MANY_NEIGHBOURS = 10_000
"""Beyond these, effects are asked whether the neighbours of an endless chain have a sum."""

NO_SUM = "a flow that falls off as 1/r has no sum over an endless chain: name a number"
"""Why such a flow is refused with all pairs."""

LARGEST_OFFSET = 1e6
"""Of a start, in spacings: of larger ones, rounding leaves too little of a link's rest length."""


class Drag(NamedTuple):
    """γ_T = 6πηa and γ_R = 8πηa³ of one sphere."""

    translation: float
    rotation: float


class Moduli(NamedTuple):
    """λ∥, λ⊥, μ∥ and μ⊥ of the elastic potential; 0 stands for a term that is absent."""

    stretch: float
    shear: float
    twist: float
    bend: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Scene(Section):
    """Everything that decides a run. Sections may be given as raw tables.

    With ``effects = "auto"`` a run takes the cheapest set of hydrodynamic effects that keeps every
    sphere within ``tolerance`` radii, and radians, of the full model: see :mod:`nrchain.auto`.

    Raises :class:`~nrchain.errors.SceneError` with the key, the value and what is allowed.
    """

    chain: Annotated[ChainSpec, section(ChainSpec)]
    elasticity: Annotated[ElasticitySpec, section(ElasticitySpec)] = field(
        default_factory=ElasticitySpec
    )
    slip: Annotated[SlipSpec, section(SlipSpec)] = field(default_factory=SlipSpec)
    friction: Annotated[FrictionSpec, read_friction] = field(default_factory=FrictionSpec)
    further: Annotated[Mapping[str, Section], read_effects] = EffectSections()
    start: Annotated[StartSpec, section(StartSpec)] = field(default_factory=StartSpec)
    run: Annotated[RunSpec, section(RunSpec)]
    title: Annotated[str, line()] = ""
    effects: Annotated[Effects, choice(Effects)] = "named"
    tolerance: Annotated[float | None, optional(number(above=0))] = None

    @property
    def drag(self) -> Drag:
        """γ_T = 6πηa and γ_R = 8πηa³."""
        radius, viscosity = self.chain.radius, self.chain.viscosity
        return Drag(6 * math.pi * viscosity * radius, 8 * math.pi * viscosity * radius**3)

    @property
    def moduli(self) -> Moduli:
        """λ∥, λ⊥, μ∥, μ⊥, as given or by the stiffness rule (paper, Appendix D)."""
        given, d = self.elasticity, self.chain.spacing
        translation, rotation = self.drag
        bend = translation * d**2 if given.bend is None else given.bend
        twist = bend if given.twist is None else given.twist
        if given.stretch is not None and given.shear is not None:
            return Moduli(given.stretch, given.shear, twist, bend)
        ratio = DEFAULT_RATIO if given.ratio is None else given.ratio
        links = float(self.chain.particles - 1)
        stiffness = ratio * bend * rotation / (translation * d**4 * links**4)
        return Moduli(stiffness, stiffness, twist, bend)

    @property
    def length(self) -> float:
        """L = (N−1) d, or N d, the period, of a periodic chain."""
        links = self.chain.particles - (self.chain.ends != "periodic")
        return links * self.chain.spacing

    @property
    def wavevector(self) -> float:
        """q = wavenumber · π/L, or wavenumber · 2π/L on a periodic chain."""
        unit = 2 * math.pi if self.chain.ends == "periodic" else math.pi
        return self.start.wavenumber * unit / self.length

    @property
    def can_reach_all(self) -> bool:
        """Whether the slip flows of all pairs have a sum, with all images of a periodic chain."""
        return self.chain.ends != "periodic" or self.slip_has_sum

    @property
    def slip_has_sum(self) -> bool:
        """Whether the slip flows have a sum over an endless chain: that of a force has none."""
        flows = (
            slip_modes.find(label).flow()
            for label, slip in self.slip.modes.items()
            if (any(slip.strength) if isinstance(slip.strength, tuple) else slip.strength)
        )
        return not any(power == 1 for flow in flows for _, power in flow)

    def __getattr__(self, name: str) -> Any:
        """The section that an effect adds to scenes, such as ``scene.steric``."""
        kind: Any = None
        if not name.startswith("_") and name not in type(self).rules():
            kind = extensions().section_kind(name)
        if kind is None:
            hint = "" if name.startswith("_") else did_you_mean(name, dir(self))
            raise AttributeError(f"a scene has no {name!r}{hint}")
        return self.further.get(name) or default_section(kind)

    def __dir__(self) -> list[str]:
        return sorted({*object.__dir__(self), *extensions().section_kinds()})

    def __repr__(self) -> str:
        """What a run of it simulates, in one line; all of it is in :meth:`to_toml`."""
        chain = self.chain
        size = f"{chain.particles} spheres, d = {chain.spacing:g}, a = {chain.radius:g}"
        acting = ", ".join((slip_text(self), *self.further))
        return (
            f"<Scene {shorten(self.title)}: {size}, {chain.ends} ends, {acting}, "
            f"to t = {self.run.end:g}>"
        )

    def check(self) -> None:
        self._check_choice()
        self._check_strengths()
        if self.chain.ends == "periodic":
            self._check_periodic()
        self._check_range()
        if self.further or self._has_many_neighbours():
            extensions().check_scene(self)
        self._check_start()

    def _has_many_neighbours(self) -> bool:
        reaches = (self.slip.neighbours, self.friction.neighbours)
        return any(isinstance(reach, int) and reach > MANY_NEIGHBOURS for reach in reaches)

    def _check_choice(self) -> None:
        """Refuse a choice without its tolerance, and effects both named and left to be chosen."""
        if self.effects == "named":
            if self.tolerance is not None:
                allowed = "is for effects = 'auto'; take it out, or leave the effects to be chosen"
                raise SceneError("tolerance", self.tolerance, allowed)
            return
        if self.tolerance is None:
            allowed = (
                "must be given with effects = 'auto': the largest distance from the full model"
            )
            raise SceneError("tolerance", None, f"{allowed}, in radii")
        for path, names in CHOSEN.items():
            spec = getattr(self, path)
            plain = type(spec)()
            for name in names:
                if getattr(spec, name) != getattr(plain, name):
                    allowed = "is chosen by effects = 'auto'; take one of the two out"
                    raise SceneError(spec.key(name), getattr(spec, name), allowed)

    def _check_strengths(self) -> None:
        """Refuse strengths that are neither one nor one a sphere."""
        for label, slip in self.slip.modes.items():
            if isinstance(slip.strength, tuple) and len(slip.strength) != self.chain.particles:
                allowed = (
                    f"must be one number, or one for each of the {self.chain.particles} spheres,"
                    f" not {len(slip.strength)}"
                )
                raise SceneError(SlipSpec.key(label), slip.strength, allowed)

    def _check_start(self) -> None:
        """Refuse a wave that the lattice of spheres cannot hold, and offsets beyond all meaning."""
        start, spacing = self.start, self.chain.spacing
        for name in POSES:
            refuse_rows(start.key(name), getattr(start, name), self.chain.particles)
        if start.shape in ("straight", "given"):
            return
        if abs(start.amplitude) > LARGEST_OFFSET * spacing:
            allowed = f"must be no more than {LARGEST_OFFSET:g} times chain.spacing = {spacing!r}"
            raise SceneError("start.amplitude", start.amplitude, allowed)
        shortest = self.length / spacing / (2 if self.chain.ends == "periodic" else 1)
        excess = start.wavenumber / shortest - 1.0
        if start.shape == "sine" and abs(excess) < 1e-9:
            allowed = (
                f"must be below {shortest:g}: a sine of that wavenumber is zero at every sphere"
            )
            raise SceneError("start.wavenumber", start.wavenumber, allowed)
        if start.shape != "random" and excess > 1e-9:
            allowed = (
                f"must be at most {shortest:g}, a wave two spheres long: of a shorter one the"
                " spheres show another"
            )
            raise SceneError("start.wavenumber", start.wavenumber, allowed)

    def _check_periodic(self) -> None:
        """Refuse what cannot be repeated along x."""
        if not self.start.wavenumber.is_integer():
            allowed = "must be a whole number on a periodic chain, for the wave to fit its length"
            raise SceneError("start.wavenumber", self.start.wavenumber, allowed)
        for spec in (self.slip, self.friction):
            if spec.backend == "pystokes":
                allowed = (
                    "sums no periodic images; periodic chains need 'native', or choose free or"
                    " clamped ends"
                )
                raise SceneError(spec.key("backend"), spec.backend, allowed)
        if self.slip.neighbours == "all" and not self.can_reach_all:
            raise SceneError("slip.neighbours", self.slip.neighbours, NO_SUM)

    def _check_range(self) -> None:
        """Refuse numbers that are fine by themselves and leave the range of floats together."""
        for name, spec in (
            ("drag", self.chain),
            ("length", self.chain),
            ("moduli", self.elasticity),
            ("wavevector", self.start),
        ):
            try:
                derived = getattr(self, name)
            except ArithmeticError:
                derived = math.inf
            values = derived if isinstance(derived, tuple) else (derived,)
            zero_is_meant = name == "moduli"
            if not all(math.isfinite(v) and (v > 0 or zero_is_meant) for v in values):
                allowed = (
                    f"with the scene's other numbers this puts the {name} beyond the range of"
                    " floating point; choose units closer to 1"
                )
                raise SceneError(spec.path, spec.to_mapping(), allowed)

    @classmethod
    def spellings(cls) -> tuple[str, ...]:
        """Every dotted key, so that one without its section is recognised."""
        further = extensions().section_kinds()
        kinds: list[type[Section]] = [ChainSpec, ElasticitySpec, SlipSpec, FrictionSpec]
        kinds += [*further.values(), StartSpec, RunSpec]
        known = [name for name in (*cls.rules(), *further) if name != "further"]
        return (*known, *(spec.key(name) for spec in kinds for name in spec.names()))

    @classmethod
    def from_mapping(cls, table: Mapping[str, Any]) -> Self:
        """The scene of a raw table, in which a key that every scene has is no effect's section."""
        if not isinstance(table, Mapping):
            raise SceneError("scene", table, "must be a table")
        own = [name for name in cls.rules() if name != "further"]
        further = {name: value for name, value in table.items() if name not in own}
        for name, value in further.items():
            if extensions().section_kind(name) is None:
                known = [*own, *extensions().section_kinds()]
                if isinstance(value, Mapping):
                    meant = nearest(name, known, SURE)
                    refusal = unknown(name, value, known, [meant] if meant else [])
                    if meant:
                        raise refusal
                    raise register_first(refusal, "An effect", "nrchain.register_effect")
                raise unknown(name, value, known, cls.spellings())
        given = {name: value for name, value in table.items() if name in own and value is not None}
        return super(Scene, cls).from_mapping(given | {"further": further})

    def to_mapping(self) -> dict[str, Any]:
        """The raw table of the scene, the sections of its effects among the others."""
        table = super(Scene, self).to_mapping()
        further = {name: s.to_mapping() for name, s in table.pop("further").items()}
        names = ("start", "run", "title", "effects", "tolerance")
        last = {name: table.pop(name) for name in names if name in table}
        return {**table, **further, **last}

    @classmethod
    def from_toml(cls, text: str) -> Self:
        """The scene of TOML text."""
        return cls.from_mapping(read_toml(text))

    def to_toml(self) -> str:
        """The TOML text from which :meth:`from_toml` makes an equal scene."""
        return write_toml(self.to_mapping())


def load_scene(source: str | os.PathLike[str] | Mapping[str, Any] | Scene, **changes: Any) -> Scene:
    """The scene of a source, with changes made before it is checked.

    Parameters
    ----------
    source
        The name of a shipped scene, the path of a TOML file, a table with nested or dotted keys,
        or a scene.
    changes
        Dotted keys, ``**{"slip.2s": 50, "chain.spacing": 12}``, or sections,
        ``chain={"particles": 30}``, of which the keys given are changed; a section given as an
        object (``chain=ChainSpec(...)``) replaces the whole. None takes a key out:
        ``**{"elasticity.ratio": None}``.

    Raises :class:`~nrchain.errors.SceneError` for what cannot be found, read or simulated.
    """
    if isinstance(source, Scene):
        table = source.to_mapping()
    elif isinstance(source, Mapping):
        table = dict(source)
    elif isinstance(source, (str, os.PathLike)):
        table = read_source(source)
    else:
        allowed = "must be the name of a shipped scene, a path, a table or a Scene"
        raise SceneError("scene", source, allowed)
    return Scene.from_mapping(change(table, changes))


def require_scene(given: Any) -> Scene:
    """The scene given, or a SceneError that says how to come by one."""
    if not isinstance(given, Scene):
        allowed = "must be a Scene: load_scene makes one of a name, a path or a table"
        raise SceneError("scene", given, allowed)
    return given


def slip_text(scene: Scene) -> str:
    """The modes of a scene and their strengths, such as ``"2s +100, 3a −5000"``."""
    words = []
    for label, slip in scene.slip.modes.items():
        given = slip.strength
        strengths = given if isinstance(given, tuple) else (given,)
        ends = span(f"{min(strengths):+g}", f"{max(strengths):+g}")
        words.append(f"{label} {ends}".replace("-", "−"))
    return ", ".join(words) or "passive"
