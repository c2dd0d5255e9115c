"""Branches of states: thresholds, amplitude laws, folds, families, and files that are continued."""

from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np
import pytest
from support.selection import few_of

import nrchain
from nrchain import rules
from nrchain.errors import SceneError, TrajectoryError

SIX = {"chain.particles": 6, "elasticity.ratio": 1e8}
ISOTROPIC = {**SIX, "elasticity.measure": "isotropic"}


def clamped(**changes):
    return nrchain.load_scene("buckling", **{**SIX, **changes})


def test_a_chain_buckles_where_the_leading_rate_of_its_spectrum_vanishes():
    scene = clamped(**{"chain.radius": 1.25, "chain.viscosity": 0.5})
    found = nrchain.continue_state(scene, {"slip.2s": (0.0, 2500.0)}, branches=1)
    first = found.special[0]
    assert (first.kind, first.multiplicity, first.frequency) == ("pitchfork", 2, 0.0)
    threshold = nrchain.critical_strength(scene, "slip.2s", (0.7 * first.value, 1.3 * first.value))
    assert first.value == pytest.approx(threshold.value, rel=1e-8)
    # every further one as well: rates of the spectrum have other signs on both sides
    for special in found.special:
        counts = []
        for side in (0.999, 1.001):
            near = nrchain.load_scene(scene, **{"slip.2s": side * special.value})
            counts.append(int((nrchain.spectrum(near).rates.real > 0.0).sum()))
        assert counts[1] - counts[0] == special.multiplicity
    straight = found.branches[0]
    assert straight.is_stable.tolist() == (straight.values < first.value).tolist()


def test_the_buckled_branch_is_that_of_find_state_and_grows_as_the_square_root():
    scene = clamped(**ISOTROPIC)
    found = nrchain.continue_state(scene, {"slip.2s": (700.0, 1100.0)}, branches=2, step=0.02)
    _, bent = found.branches
    assert bent.parent == (0, 0)
    onset = found.special[0].value
    assert bent.values[0] == onset
    assert bent.amplitude[0] == pytest.approx(0.0, abs=1e-6)
    near = np.flatnonzero(bent.values < 1.02 * onset)[1:]
    assert len(near) >= 4
    slope = np.polyfit(np.log(bent.values[near] - onset), np.log(bent.amplitude[near]), 1)[0]
    assert slope == pytest.approx(0.5, abs=0.01)
    last = len(bent) - 1
    searched = nrchain.find_state(
        nrchain.load_scene(scene, **{"slip.2s": bent.values[last]}), nudge=0.1
    )
    largest = np.linalg.norm(searched.positions[:, 1:], axis=1).max()
    assert bent.amplitude[last] == pytest.approx(largest, abs=1e-6)
    kept = bent.rates[last]
    assert kept.real == pytest.approx(searched.spectrum.rates[: len(kept)].real, rel=1e-6)
    state = bent.state(last)
    assert state.error < 1e-9
    assert state.positions == pytest.approx(bent.positions[last], abs=1e-9)


@pytest.mark.slow
def test_a_buckled_chain_snaps_at_folds_that_mirror_each_other():
    """With a weight across it, the upper state ends at −f where the lower one ends at f."""
    scene = clamped(**{**ISOTROPIC, "slip.2s": 1000.0, "field.force": [0.0, 1e-2, 0.0]})
    up = nrchain.find_state(scene, nudge=0.1)
    if up.positions[:, 1].mean() < 0.0:
        up = nrchain.find_state(scene, nudge=-0.1)
    found = nrchain.continue_state(scene, {"field.force[1]": (1e-2, -2.0)}, up, branches=1)
    folds = [special for special in found.special if special.kind == "fold"]
    mirrored = nrchain.continue_state(
        nrchain.load_scene(scene, **{"field.force": [0.0, -1e-2, 0.0]}),
        {"field.force[1]": (-1e-2, 2.0)},
        (up.positions * [1.0, -1.0, 1.0], mirror(up.frames)),
        branches=1,
    )
    others = [special for special in mirrored.special if special.kind == "fold"]
    assert folds
    assert folds[0].value < -0.1
    assert [fold.value for fold in others] == pytest.approx(
        [-fold.value for fold in folds], rel=1e-6
    )
    branch = found.branches[0]
    # up to the fold no state has a stronger weight, and one rate is about to change its sign
    before = slice(0, folds[0].index + 2)
    assert branch.values[before].min() >= folds[0].value - 10.0 * folds[0].error
    sides = branch.unstable[[folds[0].index, folds[0].index + 1]]
    assert sides[1] - sides[0] == 1


def mirror(frames):
    """Frames reflected at y = 0, with e₂ reversed so that they stay right-handed."""
    reflected = frames * [1.0, -1.0, 1.0]
    reflected[:, 1] *= -1.0
    return reflected


def test_shapes_that_go_round_leave_a_hopf_point_of_the_straight_chain():
    changes = {**ISOTROPIC, "chain.particles": 10, "slip.2s": 260.0}
    scene = clamped(**changes)
    found = nrchain.continue_state(scene, {"slip.3t": (12000.0, 16000.0)}, branches=2, step=0.02)
    hopf = next(special for special in found.special if special.kind == "Hopf")
    threshold = nrchain.critical_strength(scene, "slip.3t", (0.9 * hopf.value, 1.1 * hopf.value))
    assert hopf.value == pytest.approx(threshold.value, rel=1e-8)
    assert hopf.frequency == pytest.approx(threshold.frequency, rel=1e-6)
    assert hopf.multiplicity == 2
    waves = next(branch for branch in found.branches if branch.parent == (0, 0))
    rotation = np.abs(waves.rotation[:, 0])
    assert rotation[0] == pytest.approx(hopf.frequency, rel=0.05)
    # Ω − ω and A² are both linear in p − p*
    amplitude, past = waves.amplitude[:4], waves.values[:4] - hopf.value
    assert np.polyfit(np.log(past), np.log(amplitude), 1)[0] == pytest.approx(0.5, abs=0.02)


def turned_about_x(found, angle):
    """A state rotated about x, with all frames turned back about e₁: clamps stay as they are."""
    cosine, sine = np.cos(angle), np.sin(angle)
    rotation = np.array([[1.0, 0.0, 0.0], [0.0, cosine, -sine], [0.0, sine, cosine]])
    frames = found.frames @ rotation.T
    return found.positions @ rotation.T, np.einsum("ab,nbk->nak", rotation.T, frames)


def reversed_chain(found):
    """A state rotated by a half turn about z and numbered from the other end."""
    centre = 0.5 * (found.positions[0] + found.positions[-1])
    half_turn = np.diag([-1.0, -1.0, 1.0])
    frames = (found.frames @ half_turn)[::-1].copy()
    frames[:, :2] *= -1.0
    return ((found.positions - centre) @ half_turn + centre)[::-1], frames


def check_image(scene, found, positions, frames):
    image = nrchain.find_state(scene, (positions, frames))
    assert image.positions == pytest.approx(positions, abs=1e-7)
    assert image.spectrum.rates[:6] == pytest.approx(found.spectrum.rates[:6], rel=1e-5, abs=1e-9)


@pytest.mark.parametrize("measure", ["isotropic", "paper"])
def test_states_come_in_the_families_of_their_symmetry(measure):
    """Isotropic links: a circle of states and its reversal. The paper's: a half turn about x."""
    scene = clamped(**{"elasticity.measure": measure, "slip.2s": 900.0, "chain.radius": 1.25})
    found = nrchain.find_state(scene, nudge=0.1)
    check_image(scene, found, *turned_about_x(found, np.pi))
    if measure == "paper":
        assert len(found.spectrum.neutral.rates) == 0
        return
    # a circle of states has one neutral motion more than the straight chain
    assert len(found.spectrum.neutral.rates) == 1
    check_image(scene, found, *turned_about_x(found, 0.7))
    check_image(scene, found, *reversed_chain(found))


@dataclass(frozen=True, slots=True, kw_only=True)
class LopsidedSpec(nrchain.Section):
    path: ClassVar[str] = "lopsided"
    outward: Annotated[float, rules.number()] = 0.0
    back: Annotated[float, rules.number()] = 1.0


class Lopsided(nrchain.OneBodyEffect):
    """F_y = p y − c y²: a straight chain stays one, and a branch crosses it at an angle."""

    name = "lopsided"
    summary = "a force that depends on y"
    equation = "F_y = p y − c y²"
    Section = LopsidedSpec
    covariant = False

    def add_wrenches(self, positions, frames, wrenches):
        y, given = positions[:, 1], self.scene.lopsided
        wrenches[:, 1] += given.outward * y - given.back * y**2

    def derivative(self, positions, frames):
        own = np.zeros((len(positions), 6, 6))
        given = self.scene.lopsided
        own[:, 1, 1] = given.outward - 2.0 * given.back * positions[:, 1]
        return own


@pytest.fixture
def lopsided():
    nrchain.register_effect(Lopsided)
    yield
    nrchain.unregister_effect(Lopsided)


@pytest.mark.slow
def test_a_branch_that_crosses_at_an_angle_is_transcritical(lopsided):
    scene = clamped(**{"slip.2s": 0.0, "lopsided.outward": 0.1, "lopsided.back": 3.0})
    found = nrchain.continue_state(scene, {"lopsided.outward": (0.1, 100.0)}, branches=3)
    first = found.special[0]
    assert (first.kind, first.multiplicity) == ("transcritical", 1)
    sides = [branch for branch in found.branches if branch.parent == (0, 0)]
    # p − p* has another sign on each side: its part that is linear in the amplitude
    shifts = [branch.values[1] - first.value for branch in sides]
    assert sorted(np.sign(shifts)) == [-1.0, 1.0]


@pytest.mark.slow
def test_two_keys_vary_together_along_a_line():
    scene = clamped(**{"slip.2s": 0.0, "slip.3t": 10.0})
    ends = {"slip.2s": (0.0, 900.0), "slip.3t": (10.0, 250.0)}
    found = nrchain.continue_state(scene, ends, branches=1)
    special = found.special[0]
    assert special.kind == "pitchfork"
    both = found.line.values(special.value)
    assert both["slip.3t"] == pytest.approx(10.0 + 240.0 * special.value / 900.0)
    at = nrchain.load_scene(scene, **both)
    rates = nrchain.spectrum(at).rates
    assert np.abs(rates.real).min() < 1e-6 * np.abs(rates).max()


def test_held_spheres_move_apart_where_the_spacing_varies():
    scene = clamped(**{"slip.2s": 760.0})
    found = nrchain.continue_state(scene, {"chain.spacing": (9.0, 14.0)}, branches=1)
    branch = found.branches[0]
    lengths = branch.positions[:, -1, 0] - branch.positions[:, 0, 0]
    assert lengths == pytest.approx(5.0 * branch.values, rel=1e-12)
    threshold = nrchain.critical_strength(scene, "chain.spacing", (9.0, 14.0))
    assert found.special[0].value == pytest.approx(threshold.value, rel=1e-7)


def test_a_start_inside_the_range_is_followed_both_ways():
    scene = clamped(**{"slip.2s": 900.0})
    bent = nrchain.find_state(scene, nudge=0.1)
    found = nrchain.continue_state(scene, {"slip.2s": (800.0, 1000.0)}, bent, branches=2)
    up, down = found.branches
    assert (up.values[0], up.values[-1]) == (900.0, 1000.0)
    assert (down.values[0], down.parent) == (900.0, None)
    assert (np.diff(down.values) < 0.0).all()


def test_no_scene_beyond_the_ends_of_the_range_is_asked_for():
    """Spheres may not overlap: this range begins where scenes do."""
    scene = clamped(**{"slip.2s": 0.0})
    found = nrchain.continue_state(scene, {"chain.spacing": (2.0001, 10.0)}, branches=1)
    assert found.branches[0].values[0] == 2.0001
    assert found.branches[0].values[-1] == 10.0
    thin = nrchain.continue_state(clamped(), {"elasticity.bend": (700.0, 0.0)}, branches=1)
    assert thin.branches[0].values.min() >= 0.0


def test_a_beginning_without_a_direction_is_refused():
    """Links without twist leave spheres free to turn: no branch is determined."""
    with pytest.raises(SceneError, match=r"along.*elasticity\.twist = 0.*is no place"):
        nrchain.continue_state(clamped(), {"elasticity.twist": (0.0, 100.0)}, branches=1)


def same(one, other):
    for name in ("values", "positions", "frames", "rates"):
        assert getattr(one, name) == pytest.approx(getattr(other, name), abs=1e-9)
    assert [s.kind for s in one.special] == [s.kind for s in other.special]
    assert one.reason == other.reason


@pytest.mark.parametrize("nudge", few_of([0.0, 0.1], {0.1}), ids=["straight", "bent"])
def test_an_interrupted_continuation_goes_on_where_it_was(nudge, tmp_path):
    """From the straight chain, a branch that leaves it; from the bent one, both ways."""
    scene, along = clamped(**ISOTROPIC, **{"slip.2s": 850.0}), {"slip.2s": (700.0, 1000.0)}
    begin = nrchain.find_state(scene, nudge=nudge) if nudge else None
    whole = nrchain.continue_state(scene, along, begin, branches=2)
    assert len(whole.branches) == 2
    assert whole.special
    seen = []

    def interrupt(branch):
        seen.append(len(branch))
        if len(seen) == len(whole.branches[0]) + 3:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        nrchain.continue_state(
            scene, along, begin, branches=2, output=tmp_path / "a", progress=interrupt
        )
    begun = nrchain.BranchDiagram.open(tmp_path / "a")
    assert sum(map(len, begun.branches)) < sum(map(len, whole.branches))
    assert len(begun.branches[-1]) >= 1
    more = []
    resumed = nrchain.continue_state(
        *(scene, along, begin),
        branches=2,
        output=tmp_path / "a",
        progress=lambda branch: more.append(1),
    )
    # what is in the folder is not computed again
    kept = sum(map(len, begun.branches))
    assert 0 < len(more) <= sum(map(len, resumed.branches)) - kept + 1
    again = nrchain.BranchDiagram.open(tmp_path / "a")
    for one, other, read in zip(whole.branches, resumed.branches, again.branches, strict=True):
        assert one.special[0].value == pytest.approx(other.special[0].value) if one.special else 1
        assert other.values[-1] == one.values[-1]
        same(other, read)


def test_a_folder_of_another_request_is_left_alone(tmp_path):
    scene = clamped()
    nrchain.continue_state(scene, {"slip.2s": (0.0, 100.0)}, branches=1, output=tmp_path)
    for other, along, what in (
        (scene, {"slip.2s": (0.0, 120.0)}, "range"),
        (clamped(**{"chain.radius": 1.1}), {"slip.2s": (0.0, 100.0)}, "scene"),
    ):
        with pytest.raises(
            TrajectoryError, match=f"branch-000.h5: holds a branch of another {what}"
        ):
            nrchain.continue_state(other, along, branches=1, output=tmp_path)
    (tmp_path / "branch-000.h5").write_bytes(b"no branch")
    with pytest.raises(TrajectoryError, match=r"branch-000\.h5"):
        nrchain.BranchDiagram.open(tmp_path)
    with pytest.raises(TrajectoryError, match="holds no branch"):
        nrchain.BranchDiagram.open(tmp_path / "nothing")


@pytest.mark.parametrize(
    ("along", "message"),
    [
        ({"run.end": (1.0, 2.0)}, "run.end.*must be a number on which the motion depends"),
        ({"start.amplitude": (0.0, 1.0)}, "start.amplitude"),
        ({"chain.particles": (6, 12)}, "chain.particles"),
        ({"slip.neighbours": (1, 3)}, "slip.neighbours"),
        ({"slip.2s": (1.0, 1.0)}, "two different finite numbers"),
        ({"slip.2s": 5.0}, "two different finite numbers"),
        ({"slip.9z": (0.0, 1.0)}, "9z"),
        ({"chain.spacing": (1.0, 12.0)}, "chain.spacing"),
        ({}, "must name a key"),
    ],
)
def test_what_cannot_vary_is_refused_by_its_key(along, message):
    with pytest.raises(SceneError, match=message):
        nrchain.continue_state(clamped(), along)


@pytest.mark.parametrize("name", ["branches", "steps", "step"])
def test_numbers_that_mean_nothing_are_refused(name):
    with pytest.raises(SceneError, match=name):
        nrchain.continue_state(clamped(), {"slip.2s": (0.0, 1.0)}, **{name: 0})
