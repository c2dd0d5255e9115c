"""D = max |r − r′|/a at the end of a run, with an effect and without: estimated before it runs.

Three sources, of which every estimate says which it rests on:

- the velocities (v, ω) of the scene with and without the effect at the same poses, at the start
  and along the probe: exact there;
- the growth rate of bending waves of the infinite chain with and without it, from its lattice
  operator: exact for small amplitudes, far from the ends;
- a probe: the scene and its changes integrated together on steps of loose tolerance
  (:mod:`nrchain.paired`), whose differences are good to some percent, at a fourth to a sixth of
  the steps of the run for each. It covers the whole span if its budget allows, and otherwise the
  first part, from which the difference is carried on by its own growth, no faster than the lattice
  allows and no farther than the chain can bend.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from nrchain.effects.base import largest_velocity
from nrchain.errors import SceneError
from nrchain.guard import Poses
from nrchain.lattice import Branch, lattice_rates
from nrchain.model import Model
from nrchain.nominal_cost import evaluation_cost
from nrchain.paired import PairedRun, apart
from nrchain.regime import WAVENUMBERS
from nrchain.scene import Scene
from nrchain.scene_changes import Change, changes_of
from nrchain.start import starting_poses

PROBE_TOLERANCE = 3e-5
"""Of the steps of a probe: it tells differences of some 1e-5 radii, see the study ``effects``."""

PROBE_BUDGET = 2.0
"""Nominal seconds that the probes of a plan may take together."""

SAMPLES, EARLY = 17, 8
"""Times at which members of a probe are compared, the start among them; the first interval is
divided once more, and halved so many times, so that a difference is seen before a run that lacks an
effect stops, and a probe its budget ends has something to be carried on from."""

FEWEST_SAMPLES = 4
"""Samples that a difference must have been followed for before it is carried on."""

BEND = 0.25
"""Part of its length by which a chain that bends can be expected to get apart from another."""


@dataclass(frozen=True)
class Estimate:
    """What an effect contributes to a scene, with the scene that lacks it or has it in addition.

    Attributes
    ----------
    velocity, velocity_along
        Largest |Δv|/a or |Δω| of a sphere, in radii and radians per unit time, at the start and
        anywhere along the probe.
    growth
        Its part of the growth rate of the wave named by :class:`Estimates`; None where the chain
        has no plane waves.
    displacement, turn
        Largest distance in radii, and angle in radians, between spheres of the two runs at the
        end: of the scene if its run is expected to stop.
    until
        The time they are estimated for.
    probed
        The time up to which the probe followed both; beyond it ``displacement`` is carried on.
    stops
        Why one of the two is expected to stop before; empty if neither is.
    """

    change: Change
    velocity: float
    velocity_along: float
    growth: float | None
    displacement: float
    turn: float
    until: float
    probed: float
    stops: str

    @property
    def is_probed(self) -> bool:
        """Whether the probe followed both runs to the time they are estimated for."""
        return self.probed >= self.until

    @property
    def source(self) -> str:
        """How ``displacement`` was made."""
        if self.is_probed:
            return "probe"
        return f"probe to t = {self.probed:.3g}, carried on"


@dataclass(frozen=True)
class Estimates:
    """All estimates of a scene, the wave whose growth is told, and what they took.

    ``evaluations`` are right-hand sides of all members of the probe together, ``own_evaluations``
    those of the scene itself, up to the time ``probed``; ``work`` is that of all together, in
    right-hand sides of the scene, by count (:mod:`nrchain.nominal_cost`). ``stopped`` is whether
    the run of the scene itself ends at ``probed``.
    """

    scene: Scene
    wave: float | None
    estimates: list[Estimate]
    evaluations: int
    own_evaluations: int
    work: float
    probed: float
    stopped: bool


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
    poses
        Positions (N, 3) and frames (N, 3, 3) to start from in place of the scene's.
    budget
        Nominal seconds (:mod:`nrchain.nominal_cost`) of the probe: a count, so that the same scene
        gives the same estimates on every machine.
    end
        Time up to which to probe at most; default: the end of the run.

    Raises :class:`~nrchain.errors.SceneError` for a start that a run would refuse.
    """
    changes = changes_of(scene) if changes is None else changes
    begin = starting_poses(scene, *(poses or (None, None)))
    probe = _probe(scene, changes, begin, budget, end or scene.run.end)
    wave = fastest_wave(scene)
    own = growth_at(scene, wave)
    parts = [growth_of(scene, change, wave, own) for change in changes]
    found = [_estimate(scene, c, n + 1, probe, parts[n]) for n, c in enumerate(changes)]
    return Estimates(
        scene,
        wave,
        found,
        sum(probe.evaluations),
        probe.evaluations[0],
        probe.work,
        float(probe.times[-1]),
        0 in probe.stops,
    )


def fastest_wave(scene: Scene) -> float | None:
    """q of the bending wave that grows fastest, the longest if none does; None without waves."""
    d, count = scene.chain.spacing, scene.chain.particles
    waves = np.linspace(math.pi / (count * d), math.pi / d, WAVENUMBERS)
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


@dataclass
class _Probe:
    """Differences (samples, members) from the reference; NaN after a member has ended."""

    times: np.ndarray
    distances: np.ndarray
    turns: np.ndarray
    velocities: np.ndarray
    stops: dict[int, str]
    complete: bool
    evaluations: list[int]
    work: float


def _probe(scene: Scene, changes: list[Change], begin: Poses, budget: float, end: float) -> _Probe:
    scenes = [scene, *(change.scene for change in changes)]
    times = np.linspace(0.0, end, SAMPLES)
    costs = np.array([evaluation_cost(one) for one in scenes])
    early = times[1] * np.union1d(np.arange(1, EARLY) / EARLY, 0.5 ** np.arange(1, EARLY))
    due = np.concatenate([early, times[1:]])
    radius = scene.chain.radius
    run = PairedRun(scenes, begin, PROBE_TOLERANCE)
    models = run.models
    rows = [_compare(run, models, radius)]
    for _ in run.go(due):
        rows.append(_compare(run, models, radius))
        if float(costs @ run.evaluations) > budget:
            break
    if 0 in run.stops and run.time > rows[-1][0]:
        rows.append(_compare(run, models, radius))
    reached = np.array([row[0] for row in rows])
    table = np.array([row[1] for row in rows])
    return _Probe(
        reached,
        table[..., 0],
        table[..., 1],
        table[..., 2],
        {member: f"{stop.cause} at t = {stop.time:.3g}" for member, stop in run.stops.items()},
        bool(reached[-1] >= scene.run.end or 0 in run.stops),
        run.evaluations,
        float(costs @ run.evaluations) / costs[0],
    )


def _compare(run: PairedRun, models: list[Model], radius: float) -> tuple[float, np.ndarray]:
    """The time reached, and for each member its distance, turn and velocity difference."""
    row = np.full((len(models), 3), np.nan)
    with np.errstate(all="ignore"):
        own = models[0].twists(*run.poses[0])
        others = [model.twists(*run.poses[0]) for model in models]
    for member, other in enumerate(others):
        row[member, 2] = largest_velocity(other - own, radius) / radius
        if member in run.members and 0 in run.members:
            row[member, :2] = apart(run.poses[member], run.poses[0], radius)
    return run.time, row


def _estimate(
    scene: Scene, change: Change, member: int, probe: _Probe, growth: float | None
) -> Estimate:
    followed = np.isfinite(probe.distances[:, member])
    last = int(np.flatnonzero(followed)[-1])
    probed, distance = float(probe.times[last]), float(probe.distances[last, member])
    turn, until = float(probe.turns[last, member]), probed
    if not probe.complete and member not in probe.stops:
        until = scene.run.end
        distances = probe.distances[: last + 1, member]
        limit = _fastest_growth(scene, change.scene)
        most = BEND * scene.length / scene.chain.radius
        distance = carry_on(probe.times[: last + 1], distances, until, limit, most)
        turns = probe.turns[: last + 1, member]
        turn = min(carry_on(probe.times[: last + 1], turns, until, limit, math.pi), math.pi)
    stops = [
        f"{who} stops: {probe.stops[m]}"
        for m, who in ((0, "the scene"), (member, _described(change)))
        if m in probe.stops
    ]
    return Estimate(
        change,
        float(probe.velocities[0, member]),
        float(np.nanmax(probe.velocities[:, member])),
        growth,
        distance,
        turn,
        until,
        probed,
        "; ".join(stops),
    )


def _described(change: Change) -> str:
    return "without it the run" if change.kind == "drop" else "with it the run"


def growth_of(
    scene: Scene, change: Change, wave: float | None, own: float | None = None
) -> float | None:
    """The effect's own part of the growth rate at q = ``wave``: with it, less without it.

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


def _fastest_growth(*scenes: Scene) -> float:
    """The fastest growth of bending that a lattice operator allows; infinite without waves."""
    d, count = scenes[0].chain.spacing, scenes[0].chain.particles
    waves = np.linspace(math.pi / (count * d), math.pi / d, WAVENUMBERS)
    rates = [bending_growth(scene, waves) for scene in scenes]
    if any(found is None for found in rates):
        return math.inf
    return max(0.0, *(float(found.max()) for found in rates if found is not None))


def carry_on(
    times: np.ndarray, values: np.ndarray, end: float, fastest: float, most: float
) -> float:
    """A difference followed over ``times`` from 0, carried on to ``end``.

    Over the second half of what was followed, ln D is fitted by a line in t and by one in ln t. The
    better one is followed: e^{st} with s at most ``fastest`` and D at most ``most``, or t^p with p
    between 0 and 1, as of a drift. Differences that shrink are kept as they are.
    """
    late = (times >= 0.5 * times[-1]) & (values > 0.0)
    last = float(values[-1])
    if np.count_nonzero(late) < FEWEST_SAMPLES or last <= 0.0:
        return last * end / float(times[-1]) if times[-1] > 0.0 else last
    logarithm = np.log(values[late])
    fits = {}
    for name, x in (("exponential", times[late]), ("power", np.log(times[late]))):
        slope, shift = np.polyfit(x, logarithm, 1)
        fits[name] = float(slope), float(np.square(logarithm - slope * x - shift).sum())
    (rate, rough), (power, rougher) = fits["exponential"], fits["power"]
    if rate <= 0.0:
        return last
    if rough < rougher and rate * times[-1] > 2.0:
        exponent = min(min(rate, fastest) * (end - times[-1]), 700.0)
        return max(last, min(last * math.exp(exponent), most))
    return last * (end / float(times[-1])) ** min(max(power, 0.0), 1.0)
