"""D = max |r − r′|/a at the end of a run, with an effect and without: estimated before it runs.

There are three sources:

- the velocities (v, ω) of the scene with and without the effect at the same poses, at the start and
  along the probe: exact there;
- the growth rate of bending waves of the infinite chain with and without it, from its lattice
  operator: exact for small amplitudes, far from the ends;
- a probe: the scene and one of its changes, integrated on shared steps of loose tolerance
  (:mod:`nrchain.planning.shared_steps`), whose difference is good to some percent. Each change has
  its own probe, so that one that makes the chain stiff or tears it apart delays no other.

A probe ends with the run, when one of the two stops, or when its part of a budget is spent. The
budget counts right-hand sides and not seconds. The estimate is the difference at the time reached,
and names that time. It says nothing about later times: a difference grows, saturates and shrinks by
laws of its own.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nrchain.effects.base import largest_velocity
from nrchain.errors import SceneError
from nrchain.motion.model import Model
from nrchain.notebook import record_html
from nrchain.planning.checked_start import starting_poses
from nrchain.planning.counted_work import evaluation_work
from nrchain.planning.effect_changes import Change, possible_changes
from nrchain.planning.shared_steps import SharedStepRun, largest_distance
from nrchain.scene.scene import Scene
from nrchain.theory.lattice import Branch, chain_waves, lattice_rates
from nrchain.types import Poses
from nrchain.wording import brief

PROBE_TOLERANCE, RESOLUTION = 3e-6, 1e-4
"""Tolerance of the steps of a probe, and the smallest difference in radii and radians that it
resolves: see the study ``effects``. Errors of the steps cancel only where poses agree."""

PROBE_BUDGET = 3.0
"""Nominal seconds that the probes of a plan may take together."""

OWN_SHARE, PASSES = 0.1, 3
"""Part of the budget for the scene alone, and how often unspent parts go to other probes."""

SAMPLES, EARLY = 17, 8
"""Times along the run at which velocities are compared, and parts into which the first interval is
divided again, evenly and by halves, so that a fast start is seen."""


@dataclass(frozen=True)
class Estimate:
    """What one effect contributes to a run: the difference with and without it.

    Attributes
    ----------
    change
        The effect, and the scene that lacks it or has it in addition.
    velocity, velocity_along
        Largest |Δv|/a or |Δω| of a sphere, in radii and radians per unit time, at the start and
        anywhere along the probe.
    growth
        Its part of the growth rate Re Λ of the wave named by :class:`Estimates`; None where the
        chain has no plane waves.
    displacement, turn
        Largest distance in radii, and angle in radians, between spheres of the two runs at the
        time ``until``.
    until
        The end of the run, the time at which one of the two stops, or as far as the probe went.
    ends
        Whether one of the two runs ends there; if not, nothing is known about later times.
    stops
        Why one of the two runs would stop before its end; empty if neither would.
    """

    change: Change
    velocity: float
    velocity_along: float
    growth: float | None
    displacement: float
    turn: float
    until: float
    ends: bool
    stops: str

    __repr__ = brief
    _repr_html_ = record_html


@dataclass(frozen=True)
class Estimates:
    """All estimates of a scene, with the wave whose growth they give, and their work.

    ``wave`` is its wavenumber q in 1/length, or None. ``probed`` is the time to which the scene
    alone was followed, for velocities along the way. ``work`` is that of all probes, counted in
    right-hand sides of the scene (:mod:`nrchain.planning.counted_work`).
    """

    scene: Scene
    wave: float | None
    estimates: list[Estimate]
    work: float
    probed: float

    __repr__ = brief
    _repr_html_ = record_html


def estimate_effects(
    scene: Scene,
    changes: list[Change] | None = None,
    *,
    poses: Poses | None = None,
    budget: float = PROBE_BUDGET,
    end: float | None = None,
) -> Estimates:
    """What each effect of a scene, or each of the ``changes``, contributes to its run.

    Parameters
    ----------
    changes
        The changes to estimate; default: all that the scene allows.
    poses
        Positions (N, 3) and frames (N, 3, 3) to start from in place of the scene's, as for
        :func:`nrchain.simulate`.
    budget
        Nominal seconds (:mod:`nrchain.planning.counted_work`) of the probe: a count, so that the
        same scene gives the same estimates on every machine.
    end
        Time up to which to probe at most; default: the end of the run.

    Raises :class:`~nrchain.errors.SceneError` for a start that a run would refuse.
    """
    changes = possible_changes(scene) if changes is None else changes
    begin = starting_poses(scene, *(poses or (None, None)))
    end = scene.run.end if end is None else end
    own = SharedStepRun([scene], begin, PROBE_TOLERANCE)
    velocities = _velocities(own, [change.scene for change in changes], end, OWN_SHARE * budget)
    pairs = [SharedStepRun([scene, change.scene], begin, PROBE_TOLERANCE) for change in changes]
    _integrate_pairs(pairs, end, budget - own.work)
    wave = fastest_wave(scene)
    growth = growth_at(scene, wave)
    found = [
        _estimate(change, along, growth_of(scene, change, wave, growth), pair)
        for change, along, pair in zip(changes, velocities, pairs, strict=True)
    ]
    work = (own.work + sum(pair.work for pair in pairs)) / evaluation_work(scene)
    return Estimates(scene, wave, found, work, own.time)


def fastest_wave(scene: Scene) -> float | None:
    """q of the fastest growing bending wave, or the longest if none grows; None without waves."""
    waves = chain_waves(scene)
    rates = bending_growth(scene, waves)
    if rates is None:
        return None
    return float(waves[int(np.argmax(rates))] if rates.max() > 0.0 else waves[0])


def bending_growth(scene: Scene, waves: np.ndarray) -> np.ndarray | None:
    """Re Λ of the faster of the two bending branches at each q; None without plane waves."""
    try:
        rates = lattice_rates(scene, waves, frame="spinning")
    except (SceneError, FloatingPointError, np.linalg.LinAlgError):
        return None
    return rates[..., [Branch.BEND_PLUS, Branch.BEND_MINUS]].real.max(axis=-1)


def _velocities(
    run: SharedStepRun, others: list[Scene], end: float, budget: float
) -> list[tuple[float, float]]:
    """Largest |Δv|/a or |Δω| from each of the others, at the start and along a run."""
    scene, times = run.scenes[0], np.linspace(0.0, end, SAMPLES)
    early = times[1] * np.union1d(np.arange(1, EARLY) / EARLY, 0.5 ** np.arange(1, EARLY))
    models = [Model(other) for other in others]

    def differences() -> list[float]:
        poses, radius = run.poses[0], scene.chain.radius
        with np.errstate(all="ignore"):
            own = run.models[0].twists(*poses)
            return [largest_velocity(m.twists(*poses) - own, radius) / radius for m in models]

    rows = [differences()]
    rows += [differences() for _ in run.advance(np.concatenate([early, times[1:]]), budget)]
    if run.time < end:
        rows.append(differences())
    return list(zip(rows[0], np.fmax.reduce(rows).tolist(), strict=True))


def _integrate_pairs(pairs: list[SharedStepRun], end: float, budget: float) -> None:
    """Integrate each pair to the end, or as far as its share of the budget goes."""
    left, going = budget, pairs
    for _ in range(PASSES):
        if not going or left <= 0.0:
            return
        before = sum(pair.work for pair in going)
        for pair in going:
            for _ in pair.advance([end], left / len(going)):
                pass
        left -= sum(pair.work for pair in going) - before
        going = [pair for pair in going if pair.time < end and not pair.stops]


def _estimate(
    change: Change, velocities: tuple[float, float], growth: float | None, pair: SharedStepRun
) -> Estimate:
    until, own, other = pair.first_stops.get(1, (pair.time, pair.poses[0], pair.poses[1]))
    stops = [
        f"{who} stops: {pair.stops[m].cause} at t = {pair.stops[m].time:.3g}"
        for m, who in ((0, "the scene"), (1, _run_text(change)))
        if m in pair.stops
    ]
    ends = bool(stops) or until >= pair.scenes[0].run.end
    with np.errstate(all="ignore"):
        distance, turn = largest_distance(own, other, pair.scenes[0].chain.radius)
    return Estimate(change, *velocities, growth, distance, turn, until, ends, "; ".join(stops))


def _run_text(change: Change) -> str:
    return "the run without it" if change.kind == "drop" else "the run with it"


def growth_of(
    scene: Scene, change: Change, wave: float | None, own: float | None = None
) -> float | None:
    """The part of the growth rate Re Λ at q = ``wave`` that is due to the effect.

    ``own`` is the growth rate of the scene there, if it is known.
    """
    own = growth_at(scene, wave) if own is None else own
    other = growth_at(change.scene, wave)
    if own is None or other is None:
        return None
    return own - other if change.kind == "drop" else other - own


def growth_at(scene: Scene, wave: float | None) -> float | None:
    """Re Λ of the faster bending branch at one q; None without plane waves."""
    rates = None if wave is None else bending_growth(scene, np.array([wave]))
    return None if rates is None else float(rates[0])
