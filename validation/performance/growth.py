"""How times and memory scale with N."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from nrchain import Scene, load_scene, simulate
from validation.performance.recipe import Recipe
from validation.performance.scenes import PROJECT
from validation.performance.timing import in_child, in_turns, rates_of
from validation.report.recorder import Recorder
from validation.report.threads import one_thread

REACHES: dict[str, dict[str, Any]] = {
    "nearest neighbours": {},
    "all pairs": {"slip.neighbours": "all"},
    "all pairs with friction": {"slip.neighbours": "all", "friction": "pairwise"},
}
Series = dict[str, list[float]]
"""Seconds by reach, one number for every N."""

LOOKS = {
    "nearest neighbours": ("o", "0.1"),
    "all pairs": ("s", "0.35"),
    "all pairs with friction": ("^", "0.6"),
}
WAVE = 16
"""Spheres per wavelength of a start, whatever the length of the chain."""

ASYMPTOTIC = 256
"""Exponents are fitted to chains of at least this many spheres."""

TENFOLD = 14.0
"""Ratio measured when the target of 11 was given up."""


def wavy(count: int, end: float, **changes: Any) -> Scene:
    """A free 2s chain whose stiffness and wavelength do not depend on its length."""
    table = {
        "chain.particles": count,
        "elasticity.stretch": 200.0,
        "elasticity.shear": 200.0,
        "slip.2s": 100.0,
        "start.shape": "sine",
        "start.wavenumber": 2.0 * (count - 1) / WAVE,
        "run.end": end,
        "run.snapshots": 2,
    }
    return load_scene(table, **changes)


def exponent(counts: list[int], values: list[float], least: int = ASYMPTOTIC) -> float:
    """p of value ∝ N^p, fitted to N ≥ ``least``."""
    far = np.array(counts) >= least
    return float(np.polyfit(np.log(np.array(counts)[far]), np.log(np.array(values)[far]), 1)[0])


def cost(recorder: Recorder) -> None:
    """Seconds per right-hand side and per unit of simulated time, from 16 to 4096 spheres."""
    counts = [2**k for k in range(4, 11 if recorder.quick else 13)]
    with one_thread():
        sides, spans = _seconds(recorder, counts)
        _same_steps(recorder)
    rivals = _recipe_sides(counts[: 3 if recorder.quick else 7])
    for name, most in zip(REACHES, (1.1, 2.1, 2.1), strict=True):
        recorder.bound(
            f"exponent of a right-hand side, {name}",
            exponent(counts, sides[name]),
            most=most,
            source="N spheres, or N² pairs",
        )
    rows = [
        (name, exponent(counts, sides[name]), exponent(counts[: len(spans[name])], spans[name]))
        for name in REACHES
    ]
    recorder.table(
        "Exponents",
        ["Reach", "Right-hand side", "Simulated time"],
        rows,
        f"p of seconds ∝ Nᵖ, fitted from N = {ASYMPTOTIC} up.",
    )
    recorder.figure(
        "cost",
        _cost_figure(counts, sides, spans, rivals),
        "Wall time of one right-hand side and of one unit of simulated time against the number of "
        f"spheres, one thread: 2s at V = 100, λ = 200, waves of {WAVE} spheres, tolerance 1e-6. "
        "Open symbols: the right-hand side of the recipe (PyStokes and NumPy). Exponents are "
        f"fitted from N = {ASYMPTOTIC} up.",
    )


def _seconds(recorder: Recorder, counts: list[int]) -> tuple[Series, Series]:
    """Seconds by reach for each of ``counts``, without runs of all pairs on long chains."""
    end, longest = (1.0, 512) if recorder.quick else (10.0, 2048)
    sides: Series = {name: [] for name in REACHES}
    spans: Series = {name: [] for name in REACHES}
    for count in counts:
        tasks = {name: rates_of(wavy(count, end, **reach)) for name, reach in REACHES.items()}
        found = in_turns(tasks, rounds=3 if recorder.quick else 9, sample=0.01)
        for name, reach in REACHES.items():
            sides[name].append(float(np.median(found[name])))
            if count > longest and name != "nearest neighbours":
                continue
            scene = wavy(count, end, **reach)
            times = [simulate(scene).counters["wall_time"] for _ in range(1 if count > 256 else 3)]
            spans[name].append(float(np.median(times)) / end)
    return sides, spans


def _same_steps(recorder: Recorder) -> None:
    """Record the time of a step on ten times as many spheres."""
    small, large = wavy(1000, 1.0), wavy(10_000, 1.0)
    simulate(small)
    turns = [(simulate(small).counters, simulate(large).counters) for _ in range(3)]
    short, long = (
        float(np.median([pair[k]["wall_time"] / pair[k]["steps"] for pair in turns]))
        for k in (0, 1)
    )
    recorder.benchmark(
        "a step at N = 1e4 against N = 1e3",
        long,
        short,
        what=f"nearest neighbours, seconds per step over {turns[0][1]['steps']:.0f} and "
        f"{turns[0][0]['steps']:.0f} steps; 0.1 would be linear",
    )
    recorder.shortfall(
        "N = 1e4 over N = 1e3, nearest neighbours, same number of steps",
        long / short,
        asked=11.0,
        reached=TENFOLD,
        source="factors and derivatives of 1e4 spheres, 80 MB, do not fit into the cache",
    )


def _recipe_sides(counts: list[int]) -> Series:
    """Seconds per right-hand side of the recipe."""
    found: Series = {"nearest neighbours": [], "all pairs with friction": []}
    for name, values in found.items():
        for count in counts:
            scene = wavy(count, 1.0, **REACHES[name])
            positions = np.zeros((count, 3))
            positions[:, 0] = 10.0 * np.arange(count)
            recipe = Recipe(scene, positions, np.broadcast_to(np.eye(3), (count, 3, 3)))

            def side(recipe: Recipe = recipe) -> None:
                recipe.rates(0.0, recipe.start)

            with one_thread():
                values.append(float(np.median(in_turns({name: side}, rounds=3)[name])))
    return found


def _cost_figure(
    counts: list[int],
    sides: Series,
    spans: Series,
    rivals: Series,
) -> Figure:
    figure = Figure(figsize=(7.6, 3.4))
    left, right = figure.subplots(1, 2)
    for name, (marker, color) in LOOKS.items():
        p = exponent(counts, sides[name])
        left.plot(counts, sides[name], marker + "-", color=color, label=f"{name}, N^{p:.2f}")
        right.plot(counts[: len(spans[name])], spans[name], marker + "-", color=color, label=name)
        if name in rivals:
            left.plot(
                counts[: len(rivals[name])],
                rivals[name],
                marker + ":",
                color=color,
                markerfacecolor="none",
                label=f"recipe, {name}",
            )
    left.set(title="one right-hand side", ylabel="seconds")
    right.set(title="one unit of simulated time")
    for panel in (left, right):
        panel.set(xscale="log", yscale="log", xlabel="spheres N")
        panel.legend(loc="upper left", fontsize=6.5)
    return figure


def memory(recorder: Recorder) -> None:
    """Peak resident memory of runs in processes of their own."""
    short = 1e-3
    rows = []
    for name, reach in REACHES.items():
        near = name == "nearest neighbours"
        if recorder.quick and not near:
            continue
        counts = [1000, 10_000, 40_000] if near else [64, 4096, 8192]
        if recorder.quick:
            counts = counts[:2]
        peaks = [in_child(wavy(count, short, **reach))["mebibytes"] for count in counts]
        rows.append((name, ", ".join(map(str, counts)), ", ".join(f"{p:.0f}" for p in peaks)))
        if len(counts) == 3:
            growth = (peaks[2] - peaks[0]) / (peaks[1] - peaks[0])
            linear = (counts[2] - counts[0]) / (counts[1] - counts[0])
            recorder.bound(
                f"memory from N = {counts[1]} to {counts[2]}, {name}: over that of linear growth",
                growth / linear,
                most=1.15,
                source="no array of N × N",
            )
        if name == "all pairs with friction":
            recorder.bound(
                "memory of N = 4096, all pairs with friction (GiB)",
                peaks[1] / 1024,
                most=1.0,
                source=PROJECT,
            )
    if not recorder.quick:
        found = in_child(wavy(100_000, 0.1))
        rows.append(("nearest neighbours", "100000", f"{found['mebibytes']:.0f}"))
        recorder.bound(
            "memory of N = 1e5, nearest neighbours (GiB)",
            found["mebibytes"] / 1024,
            most=2.0,
            source=PROJECT,
        )
    recorder.table(
        "Memory",
        ["Reach", "N", "Peak (MiB)"],
        rows,
        "Peak resident memory of a run, including Python.",
    )
