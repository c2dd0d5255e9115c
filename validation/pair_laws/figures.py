"""The figures of the study of pair laws."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from validation.pair_laws.sources import around, flattened, ours, polar_parts, released
from validation.report import paper
from validation.report.paper import LABELS
from validation.report.recorder import Recorder

Array = NDArray[np.float64]

DEGREE = np.pi / 180
NEAR, SLANT = 3.0, 35.0
ANGLES = [0, 45, 90, 135, 180]
NAMES = {
    "2s": "2s, stresslet",
    "3a": "3a, torque dipole",
    "3t": "3t, source dipole",
    "4a": "4a, chiral octupole",
}


def draw(recorder: Recorder, axis: Array) -> None:
    recorder.figure(
        "ratios",
        _ratios(axis),
        f"What PyStokes returns over the printed law, as released and through the adapter. Above: "
        f"against the angle between axis and line of centres, {NEAR:g} a apart, where the law is "
        f"more than a fifth of its largest value. Below: against the distance, at "
        f"{SLANT:g}°. A vector counts by its part along the law. The force of 2s bends by its "
        "finite-size part; the torque of 3a is another tensor.",
    )
    recorder.figure(
        "R3a",
        _r3a(axis),
        "The angular velocity that a torque dipole induces: half the curl of the flow (line), "
        "through the adapter (crosses), and what `propulsionR3a` returns (circles), in the units "
        "of `propulsionT3a`.",
    )
    recorder.figure(
        "finite size",
        _finite_size(axis),
        "Change of the 2s velocity by finite size: PyStokes as released minus the leading "
        "order (symbols), over the leading order on the axis, and (1 + a²∇²/6)(1 + a²∇²/10) − 1 "
        "(lines). Both parts fall as (a/r)².",
    )


def finite_size_part(axis: Array, distances: Array, degrees: float) -> tuple[Array, Array]:
    """(u − u_leading)/|u_leading on the axis| of 2s, along n and θ, from PyStokes as released."""
    points = around(axis, distances, np.array([degrees * DEGREE]))
    part = -released("propulsionT2s", points, axis) - paper.velocity("2s", points, axis)
    return _over_axis(part, points, axis)


def _over_axis(part: Array, points: Array, axis: Array) -> tuple[Array, Array]:
    r = np.linalg.norm(points, axis=1)
    radial, polar = polar_parts(part, points, axis)
    return radial / (7 / 3 / r**2), polar / (7 / 3 / r**2)


def _along(values: Array, law: Array, points: Array, power: int) -> Array:
    """values·law/law², NaN where |law| is below a fifth of its largest value."""
    v, w = flattened(values, points, power), flattened(law, points, power)
    size = np.sum(w * w, axis=1)
    strong = size > 0.04 * size.max()
    return np.where(strong, np.sum(v * w, axis=1) / np.where(strong, size, 1.0), np.nan)


def _ratios(axis: Array) -> Figure:
    figure = Figure(figsize=(9.6, 5.0))
    panels = figure.subplots(2, 4)
    angles = np.arange(5.0, 180.0, 10.0)
    distances = np.geomspace(2.1, 100.0, 12)
    for column, label in enumerate(LABELS):
        above, below = panels[:, column]
        _draw_ratios(above, angles, label, around(axis, np.array([NEAR]), angles * DEGREE), axis)
        points = around(axis, distances, np.array([SLANT * DEGREE]))
        _draw_ratios(below, distances, label, points, axis)
        above.set(title=NAMES[label], xlabel="angle θ (degrees)", xticks=ANGLES)
        below.set(xlabel="distance r / a", xscale="log")
        below.set_xticks([2, 5, 10, 20, 50, 100], ["2", "5", "10", "20", "50", "100"])
        below.set_xticks([], minor=True)
        for panel in (above, below):
            low, high = panel.get_ylim()
            panel.set_ylim(min(low, -1.6), max(high, 1.6))
    for panel in panels[:, 0]:
        panel.set_ylabel("returned / law")
    handles, names = panels[0, 0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside lower center", ncols=4)
    return figure


def _draw_ratios(panel: Any, x: Array, label: str, points: Array, axis: Array) -> None:
    panel.axhline(1, color="0.8", linewidth=0.8)
    twists = ours(label, points, axis, backend="pystokes")
    for part, law, adapted, marker, cross, color in (
        ("T", paper.velocity(label, points, axis), twists[0], "o", "+", "0.1"),
        ("R", paper.spin(label, points, axis), twists[1], "s", "x", "0.5"),
    ):
        if not law.any():
            continue
        power = paper.VELOCITY_POWER[label] + (part == "R")
        returned = released(f"propulsion{part}{label}", points, axis)
        name = {"T": "force", "R": "torque"}[part]
        style = {"color": color, "linestyle": "none"}
        panel.plot(
            x,
            _along(returned, law, points, power),
            marker=marker,
            markerfacecolor="none",
            markersize=6 if part == "T" else 4,
            label=f"{name}, as released",
            **style,
        )
        panel.plot(
            x,
            _along(adapted, law, points, power),
            marker=cross,
            markersize=4,
            label=f"{name}, adapter",
            **style,
        )


def _finite_size(axis: Array) -> Figure:
    figure = Figure(figsize=(4.6, 3.4))
    panel = figure.subplots()
    distances = np.geomspace(2.1, 100.0, 10)
    for part, degrees, marker, line, color, name in (
        (0, 1e-3, "o", "-", "0.1", "along n, θ = 0"),
        (1, 45.0, "s", "--", "0.5", "along θ, θ = 45°"),
    ):
        points = around(axis, distances, np.array([degrees * DEGREE]))
        law = _over_axis(paper.finite_size_2s(points, axis), points, axis)[part]
        returned = finite_size_part(axis, distances, degrees)[part]
        panel.loglog(1 / distances, np.abs(law), line, color=color)
        panel.loglog(1 / distances, np.abs(returned), marker, color=color, label=name)
    panel.set(xlabel="a / r", ylabel="finite-size part / leading order")
    corner = np.array([0.05, 0.15])
    panel.plot(corner, 0.25 * corner**2, color="0.5", linewidth=0.8)
    panel.text(0.09, 0.0012, "slope 2", color="0.3")
    panel.legend(loc="upper left")
    return figure


def _r3a(axis: Array) -> Figure:
    figure = Figure(figsize=(7.4, 3.1))
    panels = figure.subplots(1, 2, sharey=True)
    smooth, sparse = np.linspace(0.01, 179.99, 181), np.arange(5.0, 180.0, 10.0)
    curves: tuple[tuple[str, str, Array, Callable[[Array], Array]], ...] = (
        ("half the curl", "-", smooth, lambda x: 96 / 13 * paper.spin("3a", x, axis)),
        ("adapter", "x", sparse, lambda x: 96 / 13 * ours("3a", x, axis, backend="pystokes")[1]),
        ("propulsionR3a", "o", sparse, lambda x: released("propulsionR3a", x, axis)),
    )
    for name, style, angles, source in curves:
        points = around(axis, np.array([NEAR]), angles * DEGREE)
        hollow = {"markerfacecolor": "none", "markersize": 6} if style == "o" else {}
        parts = polar_parts(source(points) * NEAR**4, points, axis)
        for panel, values in zip(panels, parts, strict=True):
            panel.plot(angles, values, style, color="0.1", label=name, **hollow)
    for panel, title in zip(panels, ("part along n", "part along θ"), strict=True):
        panel.set(xlabel="angle θ (degrees)", title=title, xticks=ANGLES)
    panels[0].set_ylabel("ω r⁴ / V")
    panels[0].legend()
    return figure
