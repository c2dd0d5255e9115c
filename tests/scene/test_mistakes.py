"""All mistakes of a scene are listed, each is refused alone, and nothing right is listed."""

from __future__ import annotations

import pytest

import nrchain
from nrchain.errors import SceneError
from nrchain.scene.mistakes import mistakes_in
from nrchain.scene.scene import Scene
from nrchain.scene.toml import change, read_source

MISTAKES = {
    "titel": ("x", "titel"),
    "tolerance": (1e-3, "tolerance"),
    "chain.spacin": (10.0, "chain.spacin"),
    "chain.ends": ("fre", "chain.ends"),
    "chain.spacing": (1.0, "chain.spacing"),
    "elasticity.stretch": (-1.0, "elasticity.stretch"),
    "slip.2s": ("a", "slip.2s"),
    "slip.4b": (3.0, "slip.4b"),
    "slip.3a": ({"strength": 1.0, "axs": [0, 0, 1]}, "slip.3a.axs"),
    "slip.3t": ([1.0, 2.0], "slip.3t"),
    "friction.kind": ("pair", "friction.kind"),
    "steric.strength": (1.0, "steric.strength"),
    "flow.gradient": ([[1, 0, 0]] * 3, "flow.gradient"),
    "start.wavenumber": (1e3, "start.wavenumber"),
    "run.end": (-1.0, "run.end"),
    "run.rtl": (2.0, "run.rtl"),
    "flo": ({"gradient": 2}, "flo"),
}
"""Changes of a scene that is right, each with the key that its error names."""


def table(*keys):
    changes = {key: MISTAKES[key][0] for key in keys}
    start = {"start.shape": "sine"}
    return change(read_source("wave"), start | changes)


def listed(*keys):
    return {error.key for error in mistakes_in(table(*keys))}


@pytest.mark.parametrize("key", MISTAKES)
def test_one_mistake_is_the_error_that_a_run_gives(key):
    (found,) = mistakes_in(table(key))
    assert found.key == MISTAKES[key][1]
    with pytest.raises(SceneError) as refusal:
        Scene.from_mapping(table(key))
    assert str(found) == str(refusal.value)


def test_mistakes_of_all_sections_are_listed_together():
    assert listed(*MISTAKES) == {MISTAKES[key][1] for key in MISTAKES.keys() - {"start.wavenumber"}}
    # the shortest wave depends on the ends of the chain
    keys = MISTAKES.keys() - {"chain.ends"}
    assert listed(*keys) == {MISTAKES[key][1] for key in keys}


def test_mistakes_between_keys_are_listed_beside_others_where_the_keys_can_be_read():
    wrong = {"chain": {"particles": 1, "spacing": 1.5, "ends": "fre"}, "run": {"end": 1.0}}
    keys = [error.key for error in mistakes_in(wrong)]
    assert keys == ["chain.particles", "chain.ends", "chain.spacing"]
    flow = {"gradient": [[1, 0, 0], [0, 0, 0], [0, 0, 0]], "disturbance": "no"}
    steric = {"strength": 1.0, "range": "far"}
    right = {"chain": {"particles": 5}, "run": {"end": 1.0}}
    both = mistakes_in(right | {"flow": flow, "steric": steric})
    keys = ["flow.disturbance", "flow.gradient", "steric.range", "steric.strength"]
    assert [error.key for error in both] == keys
    # two radii are not known
    wrong["chain"]["radius"] = -1.0
    assert "chain.spacing" not in [error.key for error in mistakes_in(wrong)]
    # the shape needs positions, and those that are given cannot be read
    start = {"shape": "given", "positions": "here"}
    (found,) = mistakes_in({"chain": {"particles": 5}, "start": start, "run": {"end": 1.0}})
    assert found.key == "start.positions"


def test_mistakes_between_sections_are_all_found():
    wrong = {
        "chain": {"particles": 5, "ends": "periodic"},
        "slip": {"2s": 1.0, "backend": "pystokes"},
        "friction": {"backend": "pystokes"},
        "start": {"wavenumber": 0.5},
        "run": {"end": 1.0},
    }
    keys = [error.key for error in mistakes_in(wrong)]
    assert sorted(keys) == ["friction.backend", "slip.backend", "start.wavenumber"]


@pytest.mark.parametrize("name", nrchain.scene_names())
def test_shipped_scenes_have_no_mistakes(name):
    assert mistakes_in(read_source(name)) == []


def test_required_keys_that_are_missing_are_named():
    assert sorted(error.key for error in mistakes_in({})) == ["chain.particles", "run.end"]
    assert [error.key for error in mistakes_in({"chain": {"particles": 3}, "run": {}})] == [
        "run.end"
    ]


@pytest.mark.parametrize("value", [3, "wave", [1]])
def test_a_section_that_is_no_table_is_one_mistake(value):
    (found,) = mistakes_in({"chain": value, "run": {"end": 1.0}})
    assert found.key == "chain"


def test_unknown_keys_name_the_nearest():
    found = {error.key: str(error) for error in mistakes_in(table("titel", "chain.spacin", "flo"))}
    assert found["titel"].endswith("did you mean 'title'?")
    assert found["chain.spacin"].endswith("did you mean 'spacing'?")
    assert found["flo"].endswith("did you mean 'flow'?")
