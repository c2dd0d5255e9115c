"""Scene files with anything in them: what can come out is a scene or a documented refusal."""

from __future__ import annotations

import random
from collections import Counter

from nrchain import NrchainError, scene_names, simulate
from nrchain.scene import Scene, scene_path

_VALUES = (
    *("0", "-1", "1", "2", "3", "1e-300", "1e300", "-1e308", "nan", "inf", "-inf", "1e999"),
    *("true", "false", "''", "'all'", "'free'", "'periodic'", "'clamped'", "'pairwise'", "'wca'"),
    *("[]", "[1, 2]", "[nan]", "[[1]]", "{}", "{strength = 1}", "{strength = 1, axis = [0, 0, 0]}"),
    *(
        "9223372036854775807",
        "99999999999999999999",
        "0x10",
        "1979-05-27",
        "'''a\nb'''",
        "'\\u0000'",
    ),
    *("0.1", "10.0", "100.0", "5000.0", "-100.0", "1e7", "2.0001", "4", "7"),
)
_KEYS = (
    *("particles", "spacing", "radius", "viscosity", "ends", "ratio", "stretch", "shear", "twist"),
    *("bend", "measure", "neighbours", "finite_size", "backend", "2s", "3a", "3t", "4a", "kind"),
    *("shape", "amplitude", "wavenumber", "seed", "end", "snapshots", "rtol", "atol", "strength"),
    *("integrator", "max_steps", "max_seconds", "range", "title", "zzz", "", "2s.strength"),
)
_SECTIONS = ("chain", "elasticity", "slip", "friction", "steric", "start", "run", "2s", "nothing")

BUDGET = {"max_steps": 40, "max_seconds": 2.0}
"""What a run that a fuzzed scene asks for may spend."""

SMALL = 64
"""Spheres and snapshots up to which a fuzzed scene is also run."""


def fuzzed(rng: random.Random) -> str:
    """The text of a shipped scene with some lines and characters changed."""
    lines = scene_path(rng.choice(scene_names())).read_text().splitlines()
    for _ in range(rng.randint(1, 4)):
        place = rng.randrange(len(lines) + 1)
        change = rng.random()
        if change < 0.45:
            lines.insert(place, f"{rng.choice(_KEYS)} = {rng.choice(_VALUES)}")
        elif change < 0.85 and place < len(lines):
            key, sign, _ = lines[place].partition("=")
            lines[place] = f"{key}= {rng.choice(_VALUES)}" if sign else lines[place]
        elif change < 0.92:
            lines.insert(place, f"[{rng.choice(_SECTIONS)}]")
        elif place < len(lines):
            text = lines[place]
            spot = rng.randrange(len(text) + 1)
            lines[place] = (
                text[:spot] + chr(rng.choice((0, 34, 61, 91, 955, 0x1F600))) + text[spot:]
            )
    return "\n".join(lines)


def fate(text: str) -> str:
    """``"refused"``, ``"read"``, or how its run ended; whatever else is raised is not caught."""
    try:
        scene = Scene.from_toml(text)
        if scene.chain.particles > SMALL or scene.run.snapshots > 4 * SMALL:
            return "read"
        table = scene.to_mapping()
        table["run"] |= BUDGET
        ended = simulate(Scene.from_mapping(table))
    except NrchainError:
        return "refused"
    return str(ended.cause or ended.status)


def fuzz(count: int, seed: int = 0) -> tuple[Counter[str], list[str]]:
    """How so many fuzzed scenes fared, and the errors that nobody documented."""
    fates: Counter[str] = Counter()
    undocumented = []
    for number in range(count):
        text = fuzzed(random.Random(f"{seed} {number}"))
        try:
            fates[fate(text)] += 1
        except Exception as error:
            undocumented.append(f"{number}: {type(error).__name__}: {error}")
    return fates, undocumented
