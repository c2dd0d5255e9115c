"""Random scenes, valid and invalid: each gives a scene or a documented error.

Half of them are texts of shipped scenes with changed lines and characters; many are refused. The
others are tables of allowed values, also at the limits, with an invalid value now and then; most of
them run. Runs are short; they must complete or stop for a cause, and keep their invariants.
"""

from __future__ import annotations

import random
from collections import Counter
from dataclasses import replace
from typing import Any
from warnings import catch_warnings

import numpy as np

from nrchain import Cause, NrchainError, Scene, SceneWarning, Trajectory, scene_names, simulate
from nrchain.scene.toml import scene_path

_WRONG = (
    *("0", "-1", "1", "2", "3", "1e-300", "1e300", "-1e308", "nan", "inf", "-inf", "1e999"),
    *("true", "false", "''", "'all'", "'free'", "'periodic'", "'clamped'", "'pairwise'", "'wca'"),
    *("[]", "[1, 2]", "[nan]", "[[1]]", "{}", "{strength = 1}", "{strength = 1, axis = [0, 0, 0]}"),
    *("9223372036854775807", "99999999999999999999", "0x10", "1979-05-27"),
    *("'''a\nb'''", "'\\u0000'"),
)
_FAIR = (
    *("0.1", "10.0", "100.0", "5000.0", "-100.0", "1e7", "2.0001", "4", "7"),
    *("'free'", "'random'"),
)
_KEYS = (
    *("particles", "spacing", "radius", "viscosity", "ends", "ratio", "stretch", "shear", "twist"),
    *("bend", "measure", "neighbours", "finite_size", "backend", "2s", "3a", "3t", "4a", "kind"),
    *("shape", "amplitude", "wavenumber", "seed", "end", "snapshots", "rtol", "atol", "strength"),
    *("integrator", "max_steps", "max_seconds", "range", "title", "zzz", "", "2s.strength"),
)
_SECTIONS = ("chain", "elasticity", "slip", "friction", "steric", "start", "run", "2s", "nothing")

_MODES = ((), ("2s",), ("3a",), ("3t",), ("4a",), ("2s", "3a", "3t", "4a"))
_STRENGTHS = (0.0, 1e-12, 1.0, 50.0, -100.0, 1e3, 1e4, 1e8, -1e150, 1e300)
_ODD: tuple[Any, ...] = (
    *(None, True, -1, 0, 0.5, 2**63, float("nan"), float("inf"), -1e308, 1e308, 5e-324),
    *("", "all", "free", [], [1.0], [[]], {}, {"strength": 1.0}, "a\nb", object()),
)

STEPS, SECONDS, END, SNAPSHOTS = 60, 2.0, 0.1, 5
"""Limits of a fuzzed run."""

SMALL = 64
"""Spheres up to which a fuzzed scene is also run."""

NOT_RUN = "read, not run"

ORTHONORMAL = 1e-12


class Broken(Exception):
    """A run violates an invariant."""


def fuzzed(rng: random.Random) -> str:
    """The text of a shipped scene with some lines and characters changed."""
    lines = scene_path(rng.choice(scene_names())).read_text().splitlines()
    for _ in range(rng.choice((1, 1, 1, 2, 4))):
        place = rng.randrange(len(lines) + 1)
        value = rng.choice(_FAIR if rng.random() < 0.5 else _WRONG)
        change = rng.random()
        if change < 0.3:
            lines.insert(place, f"{rng.choice(_KEYS)} = {value}")
        elif change < 0.75 and place < len(lines):
            key, sign, _ = lines[place].partition("=")
            lines[place] = f"{key}= {value}" if sign else lines[place]
        elif change < 0.85:
            lines.insert(place, f"[{rng.choice(_SECTIONS)}]")
        elif change < 0.9:
            del lines[place:]
        elif place < len(lines):
            text = lines[place]
            spot = rng.randrange(len(text) + 1)
            odd = chr(rng.choice((0, 13, 34, 61, 91, 955, 0xFEFF, 0x1F600)))
            lines[place] = text[:spot] + odd + text[spot + rng.randrange(2) :]
    return "\n".join(lines)


def table(rng: random.Random) -> dict[str, Any]:
    """The table of a scene with allowed values, and an invalid one now and then."""
    modes, pick = rng.choice(_MODES), rng.choice
    periodic = rng.random() < 0.2
    scene: dict[str, Any] = {
        "chain": {
            "particles": rng.randint(2, 8),
            "spacing": pick((2.0001, 2.5, 4.0, 10.0, 1e3)),
            "ends": "periodic" if periodic else pick(("free", "clamped")),
        },
        "elasticity": {
            "ratio": 10.0 ** rng.uniform(-3, 15),
            "measure": pick(("paper", "isotropic")),
        },
        "slip": {
            "neighbours": pick((1, 1, 3) if periodic else (1, 1, 3, "all")),
            **{label: pick(_STRENGTHS[: 7 if rng.random() < 0.7 else None]) for label in modes},
        },
        "start": {
            "shape": pick(("straight", "sine", "helix-left", "helix-right", "random")),
            "amplitude": pick((0.0, 1e-12, 0.1, 0.1, 3.0, 50.0, 1e200)),
            "wavenumber": pick((1.0, 2.0)),
            "seed": rng.randrange(2**32),
        },
        "run": {
            "end": 10.0 ** rng.uniform(-9, 2),
            "snapshots": rng.randint(2, 5),
            "rtol": 10.0 ** rng.uniform(-13, -1),
            "atol": 10.0 ** rng.uniform(-13, -1),
            "integrator": pick(("cvode", "cvode", "radau", "scipy-bdf")),
        },
    }
    if rng.random() < 0.1:
        strength = 10.0 ** rng.uniform(-3, 6)
        scene["steric"] = {"kind": pick(("wca", "harmonic")), "strength": strength}
    if rng.random() < 0.1:
        scene["friction"] = {"kind": "pairwise", "neighbours": pick((1, "all"))}
    if rng.random() < 0.15:
        part = scene[pick(list(scene))]
        part[pick((*part, "zzz"))] = pick(_ODD)
    return scene


def fate(scene: Scene) -> str:
    """The end of a short run of the scene, or :data:`NOT_RUN` if the scene is too large.

    Undocumented errors propagate; a run that violates an invariant raises :class:`Broken`.
    """
    if scene.chain.particles > SMALL:
        return NOT_RUN
    run = replace(
        scene.run,
        end=min(scene.run.end, END),
        snapshots=min(scene.run.snapshots, SNAPSHOTS),
        max_steps=min(scene.run.max_steps or STEPS, STEPS),
        max_seconds=min(scene.run.max_seconds or SECONDS, SECONDS),
    )
    with catch_warnings(action="ignore", category=SceneWarning):
        ended = simulate(replace(scene, run=run))
    _check(ended)
    return str(ended.cause or ended.status)


def _check(ended: Trajectory) -> None:
    gram = np.einsum("...ak,...bk->...ab", ended.frames, ended.frames)
    if not np.abs(gram - np.eye(3)).max() < ORTHONORMAL:
        raise Broken("frames are not orthonormal")
    if not np.isfinite(ended.positions).all() or not (np.diff(ended.time) > 0).all():
        raise Broken("positions are not finite, or times do not increase")
    if (ended.status == "completed") != (ended.cause is None) or ended.cause is Cause.ERROR:
        raise Broken(f"{ended.status} with {ended.cause}")
    if ended.status == "completed" and len(ended.time) != ended.scene.run.snapshots:
        raise Broken("completed with snapshots missing")


def fuzz(count: int, seed: int = 0) -> tuple[dict[str, Counter[str]], list[str]]:
    """Counts of how fuzzed texts and tables end, and the undocumented errors."""
    fates: dict[str, Counter[str]] = {"texts": Counter(), "tables": Counter()}
    undocumented = []
    for number in range(count):
        rng = random.Random(f"{seed} {number}")
        kind = "tables" if number % 2 else "texts"
        try:
            if kind == "texts":
                scene = Scene.from_toml(fuzzed(rng))
            else:
                scene = Scene.from_mapping(table(rng))
            fates[kind][fate(scene)] += 1
        except NrchainError:
            fates[kind]["refused"] += 1
        except Exception as error:
            undocumented.append(f"{kind} {number}: {type(error).__name__}: {error}")
    return fates, undocumented
