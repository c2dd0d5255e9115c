"""A commented scene explains every key and is the same scene."""

from __future__ import annotations

import re
import tomllib

import numpy as np
import pytest

import nrchain
from nrchain.scene.commented import commented_toml
from nrchain.scene.scene import Scene

OTHERS = {
    "many sections": {
        "chain": {"particles": 5, "radius": 1.5, "spacing": 8.0},
        "elasticity": {"stretch": 1.0, "shear": 2.0, "twist": 0.0},
        "slip": {"neighbours": "all", "3a": {"strength": [1.0] * 5, "axis": [0.0, 1.0, 0.0]}},
        "friction": "pairwise",
        "steric": {"kind": "wca", "strength": 0.5},
        "flow": {"gradient": [[0, 1, 0], [0, 0, 0], [0, 0, 0]]},
        "title": 'with "quotes" # and \\ λ',
        "run": {"end": 3.0, "max_steps": 7, "until": "settled"},
    },
    "chosen effects": {
        "chain": {"particles": 5},
        "effects": "auto",
        "tolerance": 1e-3,
        "run": {"end": 3.0},
    },
    "given poses": {
        "chain": {"particles": 2},
        "start": {"shape": "given", "positions": np.array([[0.0, 0, 0], [10.1, 0, 0]])},
        "run": {"end": 3.0},
    },
}


def scenes():
    shipped = [(name, nrchain.load_scene(name)) for name in nrchain.scene_names()]
    return shipped + [(name, Scene.from_mapping(table)) for name, table in OTHERS.items()]


@pytest.mark.parametrize(("name", "scene"), scenes(), ids=lambda given: str(given)[:20])
def test_a_commented_scene_is_the_same_scene(name, scene):
    assert Scene.from_toml(commented_toml(scene)) == scene


def test_every_key_is_there_set_or_behind_a_sign():
    text = commented_toml(nrchain.load_scene("buckling"))
    section, found = "", set()
    for line in text.splitlines():
        if match := re.fullmatch(r"\[(\w+)\]", line):
            section = match[1] + "."
        elif match := re.match(r"(?:# )?(\w+) =", line):
            found.add(section + match[1])
    keys = set(Scene.spellings()) - {"chain", "elasticity", "slip", "friction", "start", "run"}
    assert found == keys - {"steric", "field", "flow"}


@pytest.mark.parametrize("name", nrchain.scene_names())
def test_a_default_behind_a_sign_is_the_default_and_comments_are_narrow(name):
    scene = nrchain.load_scene(name)
    text = commented_toml(scene)
    assert all(len(line) <= 80 for line in text.splitlines() if line.startswith("#"))
    # with every default made active, the scene stays what it is
    active = re.sub(r"^# (\w+ = (?!.*# example).+)$", r"\1", text, flags=re.M)
    assert active != text
    assert Scene.from_mapping(tomllib.loads(active)) == scene


def test_a_key_without_a_default_has_an_example_that_its_rule_takes():
    text = commented_toml(nrchain.load_scene("wave"))
    assert not re.search(r"^# \w+ =\s*$", text, flags=re.M)
    active = tomllib.loads(re.sub(r"^# (\w+ = .+)$", r"\1", text, flags=re.M))
    examples = re.findall(r"^# (\w+) = .+# example$", text, flags=re.M)
    assert {"tolerance", "stretch", "2s", "frames", "max_steps"} <= set(examples)
    for section, key in (("elasticity", "stretch"), ("slip", "2s"), ("run", "max_steps")):
        changed = {f"{section}.{key}": active[section][key]}
        changed |= {"elasticity.shear": 1.0} if key == "stretch" else {}
        assert nrchain.load_scene({"chain": {"particles": 5}, "run": {"end": 1.0}}, **changed)


def test_comments_have_symbol_unit_allowed_values_and_default():
    text = commented_toml(nrchain.load_scene("buckling", **{"chain.spacing": 12.0}))
    assert "# d, in L: rest distance of neighbours. Allowed: > 2a. Default: 10.0." in text
    assert "spacing = 12.0" in text
    assert "# N: number of spheres. Allowed: whole number ≥ 2. Required." in text
