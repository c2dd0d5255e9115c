"""Grids, lists and random numbers: which points they are."""

import numpy as np
import pytest

import nrchain
from nrchain.errors import SceneError
from nrchain.sweeps.axes import read_values
from nrchain.sweeps.points import all_changes, name_of, sites

SCENE = nrchain.load_scene("buckling", **{"chain.particles": 5})


def changes(**given):
    return all_changes(
        SCENE,
        *(given.get(name) for name in ("grid", "points", "random")),
        given.get("samples"),
        given.get("seed", 0),
    )


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("-100:100:5", [-100.0, -50.0, 0.0, 50.0, 100.0]),
        ("1:1000:4:log", [1.0, 10.0, 100.0, 1000.0]),
        ("16,32, 64", [16, 32, 64]),
        ("free,clamped", ["free", "clamped"]),
        ("[1,2],[3,4]", [[1, 2], [3, 4]]),
        ("7", [7]),
    ],
)
def test_a_text_gives_values(text, values):
    found = read_values("key", text)
    assert found == pytest.approx(values) if isinstance(values[0], float) else found == values


FORM = "must be low:high:count, low:high:count:log or values"


@pytest.mark.parametrize(
    ("text", "wrong"),
    [
        *((text, FORM) for text in ("", "1:2", "1:2:x", "1:2:3:lin", "a:b:2")),
        ("0:10:3:log", "both ends of low:high:count:log must be above 0"),
        ("1:2:0", "the count, which is the third number, must be at least 1"),
        ("0:inf:3", "both ends must be finite"),
    ],
)
def test_other_texts_are_refused(text, wrong):
    with pytest.raises(SceneError, match=wrong):
        read_values("key", text)


def test_a_grid_has_all_combinations():
    found = changes(grid={"slip.2s": np.array([1.0, 2.0]), "chain.particles": "4:6:3"})
    assert found == [
        {"slip.2s": strength, "chain.particles": count}
        for strength in (1.0, 2.0)
        for count in (4, 5, 6)
    ]


def test_samples_lie_between_their_ends_and_more_begin_with_the_same():
    random = {"slip.2s": (-100, 100), "elasticity.ratio": "1e5:1e9:log", "chain.particles": (4, 7)}
    found = changes(random=random, samples=400, seed=3)
    assert found[:50] == changes(random=random, samples=50, seed=3)
    assert found[:50] != changes(random=random, samples=50, seed=4)
    strengths = np.array([one["slip.2s"] for one in found])
    assert strengths.min() > -100.0
    assert strengths.max() < 100.0
    # uniform, by Kolmogorov and Smirnov at one in a thousand
    for sample in ((strengths + 100.0) / 200.0, np.log10([o["elasticity.ratio"] for o in found])):
        part = np.sort(sample if sample.max() <= 1.0 else (sample - 5.0) / 4.0)
        assert np.abs(part - (np.arange(400) + 0.5) / 400).max() < 1.95 / np.sqrt(400)
    counts = [one["chain.particles"] for one in found]
    assert set(counts) == {4, 5, 6, 7}
    assert min(map(counts.count, (4, 5, 6, 7))) > 60


def test_samples_are_combined_with_each_point_of_a_grid():
    found = changes(grid={"chain.particles": [4, 5]}, random={"slip.2s": (0, 1)}, samples=3)
    assert [one["chain.particles"] for one in found] == [4, 4, 4, 5, 5, 5]
    assert [one["slip.2s"] for one in found[:3]] == [one["slip.2s"] for one in found[3:]]


def test_equal_scenes_are_one_point_and_others_have_other_names():
    found = sites(
        SCENE, [{"slip.2s": 100.0}, {"slip.2s": 100}, {}, {"slip.2s": 100.00000000000001}]
    )
    assert len(found) == 2
    assert found[0].name == name_of(SCENE)


def test_all_points_that_are_refused_are_counted_and_some_are_named():
    bad = [{"chain.spacing": value} for value in (1.0, 10.0, 1.5, 0.5, 1.2)]
    with pytest.raises(SceneError) as error:
        sites(SCENE, bad)
    assert error.value.key == "chain.spacing"
    named = "; ".join(f"chain.spacing = {value}" for value in ("1", "1.5", "0.5"))
    assert f"(refused at 4 of 5 points: {named} and 1 more)" in str(error.value)
