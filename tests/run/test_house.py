"""A scene given to ``simulate`` passes few rooms, and only downwards, to its first step.

The way is traced with :func:`sys.setprofile`, which reports every call of a Python function. Calls
of functions of nrchain are kept, from ``simulate`` to the first ``step`` of the integrator. A room
is the first package below nrchain; the files that lie in nrchain itself count as one. A short run
before the trace loads all modules, so that nothing is in it that runs only on import.

A call climbs if its caller, the innermost function of nrchain that is on the stack, stands on a
lower floor than the function called. The floors are those of the contract in ``pyproject.toml``.
One object is called upwards on purpose: the registry of effects, which registers itself with
scenes, and which a scene asks for the sections that effects add.
"""

from __future__ import annotations

import ast
import sys
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest
from support.selection import few_of

import nrchain
from nrchain.effects.registry import section_kinds

PACKAGE = Path(nrchain.__file__).parent
ROOT = Path(__file__).parents[2]
GROUND = "ground"
REGISTRY = "effects/registry.py"
MOST_ROOMS = 12


class FirstStep(Exception):
    """Ends the trace where the integrator takes its first step."""


def floors():
    """The height of every room, from the contract that lint-imports checks."""
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    contract = settings["tool"]["importlinter"]["contracts"][0]
    heights = {}
    for height, layer in enumerate(reversed(contract["layers"])):
        rooms = layer.replace(":", "|").split("|")
        heights |= {GROUND if height == 0 else room.strip(): height for room in rooms}
    return heights


def place(code):
    """The file of a function, from nrchain on; None for the functions of others."""
    path = Path(code.co_filename)
    return path.relative_to(PACKAGE).as_posix() if path.is_relative_to(PACKAGE) else None


def room(file):
    return file.split("/")[0] if "/" in file else GROUND


@contextmanager
def traced() -> Iterator[list[tuple[str | None, str]]]:
    """The calls made meanwhile, up to the first step: the files of caller and function."""
    calls: list[tuple[str | None, str]] = []

    def note(frame, event, _):
        file = place(frame.f_code) if event == "call" else None
        if file is None:
            return
        back = frame.f_back
        while back is not None and place(back.f_code) is None:
            back = back.f_back
        calls.append((place(back.f_code) if back else None, file))
        if frame.f_code.co_name in ("advance", "step") and file.startswith("motion/integrators/"):
            raise FirstStep

    sys.setprofile(note)
    try:
        with suppress(FirstStep):
            yield calls
    finally:
        sys.setprofile(None)


@pytest.mark.parametrize("name", few_of(nrchain.scene_names(), {"buckling", "wave"}))
def test_a_scene_goes_down_through_few_rooms_to_its_first_step(name):
    scene = nrchain.load_scene(name)
    nrchain.simulate(nrchain.load_scene(scene, **{"run.end": 1e-3, "run.snapshots": 2}))
    with traced() as calls:
        nrchain.simulate(scene)
    heights = floors()
    assert calls[-1][1] == "motion/integrators/radau.py"
    assert len({room(file) for _, file in calls}) <= MOST_ROOMS
    climbs = {
        (caller, file)
        for caller, file in calls
        if caller and heights[room(caller)] < heights[room(file)]
    }
    assert {file for _, file in climbs} <= {REGISTRY}


def test_scenes_name_no_section_of_an_effect():
    """Docstrings may mention one as an example; the code of the scene names none."""
    named = set()
    for file in (PACKAGE / "scene").glob("*.py"):
        tree = ast.parse(file.read_text(encoding="utf-8"))
        texts = (node.value for node in ast.walk(tree) if isinstance(node, ast.Constant))
        named |= {text.partition(".")[0] for text in texts if isinstance(text, str)}
    assert not named & section_kinds().keys()
