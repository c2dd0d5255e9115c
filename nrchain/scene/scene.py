"""A scene: everything that decides a run, checked before the run starts.

A scene comes from TOML (:func:`nrchain.load_scene`, :meth:`Scene.from_toml`) or from Python. A
section is a table of the file, a field a key of it. In ``[slip]`` each mode has its own key:

    [slip]
    neighbours = 1
    2s = 100.0                                     # one strength for all
    3a = [10.0, 20.0, 30.0]                        # one for each sphere
    4a = {strength = 5.0, axis = [0.0, 1.0, 0.0]}  # with its own body axis

Lengths, times and masses may have any unit, as long as all keys share it. The defaults are the
paper's: a = η = 1 and d = 10.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any, ClassVar, Literal, Self

from nrchain.errors import SceneError, shorten
from nrchain.inputs.about import About
from nrchain.inputs.names import SURE, did_you_mean, nearest
from nrchain.inputs.rules import Section, choice, line, number, optional, section, unknown
from nrchain.notebook import table_html
from nrchain.scene import checks, derived
from nrchain.scene.chain_sections import ChainSpec, ElasticitySpec, RunSpec, StartSpec
from nrchain.scene.derived import Drag, Moduli
from nrchain.scene.effect_sections import (
    EffectSections,
    read_effect_sections,
    with_registration_hint,
)
from nrchain.scene.extensions import default_section, extensions
from nrchain.scene.fluid_sections import FrictionSpec, SlipSpec, read_friction
from nrchain.scene.toml import read_toml, write_toml

Effects = Literal["named", "auto"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Scene(Section):
    """Everything that decides a run. Sections may be given as raw tables.

    With ``effects = "auto"`` a run takes the cheapest set of hydrodynamic effects that keeps every
    sphere within ``tolerance`` radii, and radians, of the full model: see :mod:`nrchain.auto`.

    Raises :class:`~nrchain.errors.SceneError` with the key, the value and what is allowed.

    >>> Scene.from_mapping({"chain": {"particles": 5}, "run": {"end": 1.0}}).length
    40.0
    """

    chain: Annotated[ChainSpec, section(ChainSpec)]
    elasticity: Annotated[ElasticitySpec, section(ElasticitySpec)] = field(
        default_factory=ElasticitySpec
    )
    slip: Annotated[SlipSpec, section(SlipSpec)] = field(default_factory=SlipSpec)
    friction: Annotated[FrictionSpec, read_friction] = field(default_factory=FrictionSpec)
    further: Annotated[Mapping[str, Section], read_effect_sections] = EffectSections()
    start: Annotated[StartSpec, section(StartSpec)] = field(default_factory=StartSpec)
    run: Annotated[RunSpec, section(RunSpec)]
    title: Annotated[str, line()] = ""
    effects: Annotated[Effects, choice(Effects)] = "named"
    tolerance: Annotated[float | None, optional(number(above=0))] = None
    about: ClassVar[Mapping[str, About]] = {
        "title": About("", "", "one line of text", "title of pictures and lists"),
        "effects": About(
            "", "", '"named", "auto"', '"auto" chooses reach, finite size and friction'
        ),
        "tolerance": About(
            "", "a, rad", '> 0, with effects = "auto"', "allowed distance from the full model"
        ),
    }

    @property
    def drag(self) -> Drag:
        """γ_T = 6πηa and γ_R = 8πηa³."""
        return derived.drag(self.chain)

    @property
    def moduli(self) -> Moduli:
        """λ∥, λ⊥, μ∥, μ⊥, as given or by the stiffness rule (paper, Appendix D)."""
        return derived.moduli(self.chain, self.elasticity)

    @property
    def length(self) -> float:
        """L = (N−1) d; of a periodic chain its period, N d."""
        return derived.length(self.chain)

    @property
    def period(self) -> float:
        """The length after which a periodic chain repeats along x; 0 for open chains."""
        return derived.period(self.chain)

    @property
    def pair_accuracy(self) -> float:
        """Largest relative error of sums over all pairs; 0 stands for direct sums."""
        return derived.pair_accuracy(self.slip, self.run)

    @property
    def wavevector(self) -> float:
        """q = wavenumber · π/L, or wavenumber · 2π/L on a periodic chain."""
        return derived.wavevector(self.chain, self.start)

    @property
    def slip_has_sum(self) -> bool:
        """Whether the slip flows of an endless chain converge: a flow of order 1/r does not."""
        return derived.slip_has_sum(self.slip)

    @property
    def can_reach_all(self) -> bool:
        """Whether ``slip.neighbours = "all"`` is possible: any open chain, or flows with a sum."""
        return self.chain.ends != "periodic" or self.slip_has_sum

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
        """The scene in one line; :meth:`to_toml` has all of it."""
        chain = self.chain
        size = f"{chain.particles} spheres, d = {chain.spacing:g}, a = {chain.radius:g}"
        title = f" {shorten(self.title)}" if self.title else ""
        acting = ", ".join((derived.modes_text(self.slip), *self.further))
        return f"<Scene{title}: {size}, {chain.ends} ends, {acting}, to t = {self.run.end:g}>"

    def _repr_html_(self) -> str:
        rows = []
        for name, value in self.to_mapping().items():
            table = value if isinstance(value, dict) else {name: value}
            prefix = f"{name}." if isinstance(value, dict) else ""
            rows += [(f"{prefix}{key}", shorten(item)) for key, item in table.items()]
        return table_html(self.title or "Scene", rows, ("key", "value"))

    def check(self) -> None:
        if self.effects == "auto":
            sections = (self.slip, *self.further.values(), self.friction)
            checks.check_auto_effects(self.tolerance, sections)
        else:
            checks.check_named_effects(self.tolerance)
        checks.check_strengths(self.slip, self.chain)
        if self.chain.ends == "periodic":
            checks.check_periodic(self.start, self.slip, self.friction)
        self._check_derived()
        if self.further or self._has_many_neighbours():
            extensions().check_scene(self)
        checks.check_start(self.start, self.chain)

    def _has_many_neighbours(self) -> bool:
        reaches = (self.slip.neighbours, self.friction.neighbours)
        return any(isinstance(reach, int) and reach > checks.MANY_NEIGHBOURS for reach in reaches)

    def _check_derived(self) -> None:
        """Refuse numbers that are fine one by one and leave the range of floats together."""
        for name, spec in (
            ("drag", self.chain),
            ("length", self.chain),
            ("moduli", self.elasticity),
            ("wavevector", self.start),
        ):
            try:
                found = getattr(self, name)
            except ArithmeticError:
                found = math.inf
            values = found if isinstance(found, tuple) else (found,)
            checks.check_range(name, values, spec, zero=name == "moduli")

    @classmethod
    def spellings(cls) -> tuple[str, ...]:
        """Every dotted key, so that a key without its section is recognised."""
        further = extensions().section_kinds()
        kinds: list[type[Section]] = [ChainSpec, ElasticitySpec, SlipSpec, FrictionSpec]
        kinds += [*further.values(), StartSpec, RunSpec]
        known = [name for name in (*cls.rules(), *further) if name != "further"]
        return (*known, *(spec.key(name) for spec in kinds for name in spec.names()))

    @classmethod
    def from_mapping(cls, table: Mapping[str, Any]) -> Self:
        """The scene of a raw table. A key that is not the scene's own is the section of an effect.

        Raises :class:`~nrchain.errors.SceneError` for a key that no effect has, with the nearest
        known one.
        """
        if not isinstance(table, Mapping):
            raise SceneError("scene", table, "must be a table")
        own = [name for name in cls.rules() if name != "further"]
        further = {name: value for name, value in table.items() if name not in own}
        for name, value in further.items():
            if extensions().section_kind(name) is None:
                raise cls._unknown_key(name, value, own)
        given = {name: value for name, value in table.items() if name in own and value is not None}
        return super(Scene, cls).from_mapping(given | {"further": further})

    @classmethod
    def _unknown_key(cls, name: str, value: Any, own: list[str]) -> SceneError:
        """The error for a key that is neither the scene's own nor the section of an effect."""
        known = [*own, *extensions().section_kinds()]
        if not isinstance(value, Mapping):
            return unknown(name, value, known, cls.spellings())
        meant = nearest(name, known, SURE)
        error = unknown(name, value, known, [meant] if meant else [])
        if meant:
            return error
        return with_registration_hint(error, "an effect", "nrchain.register_effect")

    def to_mapping(self) -> dict[str, Any]:
        """The raw table of the scene, with the sections of effects among the others."""
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
