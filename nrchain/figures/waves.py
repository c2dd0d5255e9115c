"""Panel (c): growth rate or phase velocity of bending waves, by law, by lattice and measured.

A run starts with one wavelength on a periodic chain, so low that its tension does not count, and
its growth and frequency are fitted. Periodic chains make a plane wave an exact mode.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from nrchain.analysis import measure
from nrchain.figures.sheet import key_place
from nrchain.figures.squirmer import CHIRAL
from nrchain.run.simulation import simulate
from nrchain.scene.loading import load_scene
from nrchain.scene.scene import Scene
from nrchain.theory.lattice import Branch, lattice_rates
from nrchain.theory.rod import Rod, dispersion
from nrchain.view.style import COLOURS, DASHES, INK, LINE, TEXT, marker_look, style_axes
from nrchain.view.units import label

SLACK = 1e-4
"""μ/λd² of the chains: the tilt follows the slope."""

TENSION = 1e-6
"""λA²/2μ of a start of height A."""

RANGE = (0.05, 0.45)
"""qd that is shown."""

CURVE = 60
"""Points of each curve."""


@dataclass(frozen=True)
class Waves:
    """The bending waves of one mode of slip at several strengths.

    Attributes
    ----------
    label
        Of the mode.
    strengths
        V, from the largest.
    shape
        Of the start: ``"sine"`` or ``"helix-right"``.
    part
        ``"growth"``, Re Λ, or ``"velocity"``, −Im Λ/q.
    """

    label: str
    strengths: tuple[float, ...]
    shape: str
    part: str

    def scene(self, strength: float, count: int) -> Scene:
        """One wavelength around N spheres."""
        given = {"chain": {"particles": count, "ends": "periodic"}, "run": {"end": 1.0}}
        bend = load_scene(given).moduli.bend
        spacing = load_scene(given).chain.spacing
        stiffness = bend / (SLACK * spacing**2)
        return load_scene(
            given,
            **{
                "elasticity": {"stretch": stiffness, "shear": stiffness},
                "slip": {self.label: strength},
                "start": {
                    "shape": self.shape,
                    "amplitude": math.sqrt(2 * TENSION * bend / stiffness),
                },
                "run": {"end": 1.0, "snapshots": 101, "rtol": 1e-8, "atol": 1e-11},
            },
        )

    def law(self, strength: float, wavenumbers: np.ndarray) -> np.ndarray:
        """Λ of right-handed waves in the beam limit."""
        return dispersion.transverse(Rod.of(self.scene(strength, 16)), wavenumbers)

    def lattice(self, strength: float, wavenumbers: np.ndarray) -> np.ndarray:
        """Λ of right-handed waves of the infinite discrete chain."""
        return lattice_rates(self.scene(strength, 16), wavenumbers)[:, Branch.BEND_PLUS]

    def measured(self, strength: float, count: int) -> tuple[float, complex]:
        """q and Λ of one wave around N spheres, from a run over about one e-fold or radian."""
        scene = self.scene(strength, count)
        spacing = scene.chain.spacing
        q = 2.0 * math.pi / (count * spacing)
        passive = (q * spacing) ** 4
        rate = abs(complex(self.law(strength, np.array([q]))[0]) + passive)
        scene = load_scene(scene, **{"run.end": 1.0 / (rate + passive)})
        kind: measure.Kind = "y" if self.shape == "sine" else "right"
        found = measure.rate(measure.wave(simulate(scene), kind=kind))
        return q, complex(found.value)

    def shown(self, wavenumbers: np.ndarray, rates: np.ndarray) -> np.ndarray:
        """What is drawn of rates."""
        if self.part == "growth":
            return np.real(rates)
        return -np.imag(rates) / wavenumbers


def draw_waves(axes: Any, waves: Waves, lengths: tuple[int, ...], strengths: int) -> float:
    """Draw laws, lattice and measured points of each strength; return the largest difference.

    The difference is that of measured points from the lattice, over |Λ| of the lattice.
    """
    style_axes(axes)
    scene = waves.scene(waves.strengths[0], 16)
    spacing = scene.chain.spacing
    q = np.linspace(*RANGE, CURVE) / spacing
    worst = 0.0
    entries = {}
    for number, strength in enumerate(waves.strengths[:strengths]):
        colour = COLOURS[number % len(COLOURS)]
        look = LINE | {"color": colour, "linewidth": 1.0}
        lattice = waves.lattice(strength, q)
        axes.plot(q * spacing, waves.shown(q, lattice), **look)
        law = waves.shown(q, waves.law(strength, q))
        axes.plot(q * spacing, law, **look | {"linestyle": DASHES[1]})
        found = [waves.measured(strength, count) for count in lengths]
        at, rates = np.array([one[0] for one in found]), np.array([one[1] for one in found])
        exact = waves.lattice(strength, at)
        worst = max(worst, float(np.abs(rates / exact - 1.0).max()))
        (points,) = axes.plot(
            at * spacing, waves.shown(at, rates), **marker_look(number, hollow=True)
        )
        entries[f"V = {strength:+g}".replace("-", "−")] = points
    axes.set(xlim=RANGE, xlabel="$qd$", xticks=[0.1, 0.2, 0.3, 0.4])
    if waves.label in CHIRAL:
        place = {"transform": axes.transAxes, "ha": "left", "va": "bottom"}
        axes.text(0.03, 0.03, "right-handed waves", color=INK, size=TEXT - 1, **place)
    symbol = label(r"{\rm Re}\,\Lambda", scene, "rate")
    if waves.part == "velocity":
        symbol = label(r"-{\rm Im}\,\Lambda/q", scene, "speed")
    # of low axes only the symbol has room
    words = {"growth": "growth rate  ", "velocity": "phase velocity  "}[waves.part]
    axes.set_ylabel(words * (key_place(axes)[0] is axes) + symbol)
    _write_key(axes, entries, scene)
    return worst


def _write_key(axes: Any, entries: dict[str, Any], scene: Scene) -> None:
    """Write the key below the axes: strengths, and what lines and marks are."""
    from matplotlib.lines import Line2D

    look = LINE | {"color": INK, "linewidth": 1.0}
    lines = {
        "law": Line2D([], [], **look | {"linestyle": DASHES[1]}),
        "lattice": Line2D([], [], **look),
        "runs": Line2D([], [], **marker_look(0, hollow=True) | {"markeredgecolor": INK}),
    }
    every = entries | lines
    owner, place = key_place(axes)
    owner.legend(
        every.values(),
        every.keys(),
        title=label("V", scene, "speed"),
        title_fontsize=TEXT - 1,
        ncols=3,
        frameon=False,
        fontsize=TEXT - 1,
        labelcolor=INK,
        handlelength=1.8,
        handletextpad=0.4,
        columnspacing=0.8,
        **place,
    )
