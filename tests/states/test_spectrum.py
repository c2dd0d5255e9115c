"""Rates of small changes of a finite chain, against differences, plane waves and exponentials."""

import math

import numpy as np
import pytest
from scipy.linalg import expm, null_space
from scipy.optimize import linear_sum_assignment
from support.poses import pose_derivative, random_chain, rigid_motion

import nrchain
from nrchain.comoving.motions import moved
from nrchain.comoving.relative import RelativeChain
from nrchain.errors import SceneError
from nrchain.motion.model import Model
from nrchain.states.newton import find_steady_state
from nrchain.states.spectrum import spectrum

UNITS = {"chain.radius": 1.3, "chain.viscosity": 0.7, "chain.spacing": 6.0}
SOFT = {"elasticity": {"stretch": 30.0, "shear": 40.0, "twist": 900.0, "bend": 700.0}}
MIX = {"slip.2s": 4.0, "slip.3a": 15.0, "slip.3t": -20.0, "slip.4a": 25.0}
ISOTROPIC = {"elasticity.measure": "isotropic"}
EXTENSION = [[0.02, 0.0, 0.0], [0.0, -0.01, 0.0], [0.0, 0.0, -0.01]]
CROWDED = {"kind": "harmonic", "strength": 5.0, "range": 6.0}
FAR = {"slip.neighbours": "all", "slip.accuracy": "direct"}


def chain(count, ends="free", **changes):
    table = {
        "chain": {"particles": count, "ends": ends},
        "start.shape": "straight",
        "run": {"end": 100.0},
    }
    return nrchain.load_scene(table | UNITS | SOFT | changes)


def graded(count, ends="free", **changes):
    """A chain of all modes whose strengths change along it."""
    slope = np.linspace(0.5, 1.5, count)
    strengths = {key: (slope * value).tolist() for key, value in MIX.items()}
    return chain(count, ends, **strengths | changes)


def matrix_of(scene, found):
    """J (n, n) in units of the norm, from differences of the twists of the model."""
    model, state = Model(scene), found.state
    slopes = pose_derivative(lambda r, e: model.twists(r, e), *state.poses)
    count = scene.chain.particles
    matrix = slopes.transpose(0, 1, 2, 3).reshape(6 * count, 6 * count)
    turning = np.zeros((3, 3))
    for k, unit in enumerate(np.eye(3)):
        turning[:, k] = np.cross(state.motion.rotation, unit)
    for i in range(count):
        matrix[6 * i : 6 * i + 3, 6 * i : 6 * i + 3] -= turning
        about = np.cross(np.eye(3), -state.frames[i, 0]).T
        matrix[6 * i + 3 : 6 * i + 6, 6 * i + 3 : 6 * i + 6] += state.motion.turn * about
    units = np.tile(np.repeat([1.0, 2.0 * scene.chain.radius / math.sqrt(3.0)], 3), count)
    free = np.flatnonzero(np.repeat(~model.held, 6))
    return (units[:, None] * matrix / units)[np.ix_(free, free)]


def rigid_columns(state, radius):
    """The six motions of the chain as a whole (6N, 6), in units of the norm."""
    columns = []
    for unit in np.eye(3):
        columns.append(np.hstack([np.tile(unit, (len(state.positions), 1)), 0.0 * state.positions]))
    for unit in np.eye(3):
        around = np.cross(unit, state.positions - state.positions.mean(axis=0))
        columns.append(np.hstack([around, np.tile(unit, (len(around), 1))]))
    units = np.repeat([1.0, 2.0 * radius / math.sqrt(3.0)], 3)
    return np.stack([(column * units).ravel() for column in columns], axis=1)


def assert_same_set(found, expected, tolerance):
    assert len(found) == len(expected)
    distances = np.abs(np.subtract.outer(found, expected))
    rows, columns = linear_sum_assignment(distances)
    assert distances[rows, columns].max() <= tolerance


SCENES = {
    "free": lambda: graded(7),
    "clamped": lambda: graded(8, "clamped"),
    "periodic": lambda: chain(7, "periodic", **MIX),
    "all pairs": lambda: graded(6, **FAR, friction="pairwise"),
    "all pairs, clamped": lambda: graded(6, "clamped", **FAR, friction="pairwise"),
    "all pairs, periodic": lambda: chain(6, "periodic", **MIX, **FAR, friction="pairwise"),
    "steric, finite size": lambda: graded(
        6, **{"slip.2s": -10.0, "slip.finite_size": True, "steric": CROWDED}
    ),
    "body force": lambda: graded(6, **{"field.body_force": [3.0, 0.0, 0.0]}),
    "extension between clamps": lambda: graded(6, "clamped", **{"flow.gradient": EXTENSION}),
    "extension": lambda: chain(6, **{"flow.gradient": EXTENSION}, friction="pairwise"),
    "force in the lab": lambda: graded(6, **{"field.force": [3.0, 0.0, 0.0]}),
}


@pytest.mark.parametrize("name", SCENES)
def test_the_rates_are_those_of_differences_of_the_velocities(name):
    scene = SCENES[name]()
    found = spectrum(scene)
    expected = np.linalg.eigvals(matrix_of(scene, found))
    every = np.concatenate([found.rates, found.neutral.rates])
    assert_same_set(every, expected, 2e-6 * np.abs(expected).max())


@pytest.mark.parametrize("name", SCENES)
def test_a_straight_state_is_a_steady_motion(name):
    scene = SCENES[name]()
    state = spectrum(scene).state
    twists, motion = Model(scene).twists(*state.poses), state.motion
    expected = np.hstack(
        [
            motion.velocity + np.cross(motion.rotation, state.positions - state.origin),
            motion.rotation + motion.turn * state.frames[:, 0],
        ]
    )
    assert twists == pytest.approx(expected, abs=1e-11)
    assert state.residual < 1e-11
    assert state.positions[:, 1:] == pytest.approx(0.0, abs=1e-11)


@pytest.mark.parametrize("more", [{}, FAR | {"friction": "pairwise"}, {"slip.neighbours": 2}])
def test_a_periodic_chain_has_the_rates_of_plane_waves(more):
    scene = chain(8, "periodic", **MIX, **more)
    places = np.arange(-3, 5)
    waves = 2.0 * math.pi * places / (8 * scene.chain.spacing)
    # at q = 0 the infinite sums over forces that balance have no meaning; tiny q has
    waves = np.where(places == 0, 1e-9, waves)
    expected = nrchain.lattice_rates(scene, waves, frame="spinning").ravel()
    found = spectrum(scene)
    every = np.concatenate([found.rates, found.neutral.rates])
    assert_same_set(every, expected, 1e-7 * np.abs(expected).max())


def test_the_rates_do_not_depend_on_where_the_chain_is():
    scene = graded(7)
    straight = spectrum(scene)
    positions, frames, turn = rigid_motion(*straight.state.poses)
    there = spectrum(scene, at=(positions, frames))
    assert_same_set(there.rates, straight.rates, 1e-9 * np.abs(straight.rates).max())
    assert there.abscissa == pytest.approx(straight.abscissa, rel=1e-9)
    assert there.state.motion.rotation == pytest.approx(turn @ straight.state.motion.rotation)


@pytest.fixture(scope="module")
def buckled():
    changes = {"slip.2s": 60.0, "start.shape": "random", "start.amplitude": 0.5, "start.seed": 3}
    table = {"chain.particles": 12, "slip.2s": 200.0, "run.end": 20000.0, "run.snapshots": 2}
    return {
        measure: nrchain.simulate(
            nrchain.load_scene("buckling", **changes | table, **{"elasticity.measure": measure})
        )
        for measure in ("paper", "isotropic")
    }


def test_a_settled_run_is_near_a_stable_state(buckled):
    run = buckled["paper"]
    found = spectrum(run.scene, at=run)
    assert found.is_stable
    assert np.abs(found.state.positions - run.positions[-1]).max() < 0.1
    assert np.abs(run.positions[-1, :, 1:]).max() > 1.0


def test_a_buckled_chain_of_isotropic_links_is_free_to_go_round_its_axis(buckled):
    """It keeps one neutral motion; the measure of the paper is not isotropic and has none."""
    round_, stiff = (buckled[name] for name in ("isotropic", "paper"))
    found = spectrum(round_.scene, at=round_)
    assert len(found.neutral.rates) == 1
    assert found.is_stable
    assert len(spectrum(stiff.scene, at=stiff).neutral.rates) == 0


def test_an_oscillation_that_goes_round_is_a_state_of_steady_motion():
    """2s = 60, 3t = 1000: the middle sphere goes round at 4.39 a to 4.57 a, with period 373.

    Seen along its axis the shape turns as a whole, and each sphere turns back about its own axis.
    """
    start = {"start.shape": "random", "start.amplitude": 0.5, "start.seed": 3}
    given = {"slip.2s": 60.0, "slip.3t": 1000.0, "elasticity.ratio": 1e8, **ISOTROPIC}
    run = nrchain.simulate(nrchain.load_scene("buckling", **given, **start, **{"run.end": 12000.0}))
    found = spectrum(run.scene, at=run)
    motion = found.state.motion
    assert 2.0 * math.pi / abs(motion.rotation[0]) == pytest.approx(373.0, abs=0.5)
    assert motion.turn == pytest.approx(-motion.rotation[0])
    assert 4.39 < math.hypot(*found.state.positions[10, 1:]) < 4.57
    assert len(found.neutral.rates) == 1
    assert found.is_stable
    # the run comes back to the shape of the state at the rate of the slowest mode
    axis = found.state.positions[:, 1:]
    distance = [
        abs(np.hypot(*positions[10, 1:]) - np.hypot(*axis[10])) for positions in run.positions
    ]
    late = slice(len(distance) // 3, 2 * len(distance) // 3)
    envelope = [max(distance[k : k + 3]) for k in range(late.start, late.stop)]
    decay = np.polyfit(run.time[late], np.log(envelope), 1)[0]
    assert decay == pytest.approx(found.leading.growth, rel=0.05)


@pytest.mark.parametrize(("measure", "count"), [("paper", 6), ("isotropic", 7)])
def test_a_bent_free_chain_has_six_neutral_motions_and_a_turn_of_isotropic_links(measure, count):
    """The twists go along with each of them, to the accuracy of differences."""
    scene = graded(5, **{"elasticity.measure": measure})
    poses = random_chain(5, spacing=6.0, bend=0.3, noise=0.5)
    point = RelativeChain(scene, poses).at(poses)
    assert point.neutral.shape[1] == count
    columns = point.neutral / point.chain.units[:, None]
    twists = Model(scene).twists
    for column in columns.T:
        step = 1e-6 * column.reshape(5, 6)
        change = (twists(*moved(*poses, step)) - twists(*moved(*poses, -step))) / 2e-6
        # a motion along with the chain rotates the twists; their invariants stay
        speeds = np.linalg.norm(twists(*poses).reshape(5, 2, 3), axis=2)
        growth = (change * twists(*poses)).reshape(5, 2, 3).sum(axis=2)
        assert np.abs(growth).max() < 1e-6 * (speeds**2).max()


@pytest.mark.parametrize("unit", [1e-6, 1e6])
def test_the_rates_do_not_depend_on_the_unit_of_length(buckled, unit):
    run = buckled["isotropic"]
    scaled = {"chain.spacing": 10.0 * unit, "chain.radius": unit, "slip.2s": 200.0 * unit}
    scene = nrchain.load_scene(run.scene, **scaled)
    found, there = (
        spectrum(given, at=(run.positions[-1] * size, run.frames[-1]))
        for given, size in ((run.scene, 1.0), (scene, unit))
    )
    assert len(there.neutral.rates) == len(found.neutral.rates) == 1
    assert there.leading.rate == pytest.approx(found.leading.rate, rel=1e-9)
    assert there.abscissa == pytest.approx(found.abscissa, rel=1e-9)
    # friction between spheres: one by one they would all move alike, and every rotation remain
    field = {"field.force": [0.0, 0.0, 1.0], "chain.ends": "free", "friction": "pairwise"}
    lengths = {"chain.spacing": 6.0 * unit, "chain.radius": 1.3 * unit}
    small = RelativeChain(chain(4, **field), poses := random_chain(4, spacing=6.0))
    other = nrchain.load_scene(chain(4, **field), **lengths)
    large = RelativeChain(other, (poses[0] * unit, poses[1]))
    # translations and the rotation about the force
    assert small.allowed.shape[1] == large.allowed.shape[1] == 4


def test_translations_across_the_axis_of_a_spinning_chain_turn_with_it():
    found = spectrum(chain(6, **{"slip.4a": 50.0}))
    spin = found.state.motion.rotation[0]
    assert abs(spin) > 1e-3
    turning = [0.0, 0.0, 1j * spin, 1j * spin, -1j * spin, -1j * spin]
    assert_same_set(found.neutral.rates, np.array(turning), 1e-9)
    assert found.neutral.names == tuple(
        f"{motion} {axis}" for motion in ("translation along", "rotation about") for axis in "xyz"
    )
    assert found.neutral.error < 1e-10


def test_a_chain_in_an_extension_rests_about_its_stagnation_point():
    """The straight start lies to one side of it. The rotation about the axis is neutral."""
    found = spectrum(SCENES["extension"]())
    assert found.state.positions.mean(axis=0) == pytest.approx([0.0, 0.0, 0.0], abs=1e-8)
    assert np.ptp(found.state.positions[:, 0]) > 5.0 * 6.0
    # translation along the flow grows at the rate of the extension
    assert np.abs(found.rates - 0.02).min() < 1e-3
    assert len(found.neutral.rates) == 1


@pytest.mark.parametrize("friction", ["one-body", "pairwise"])
def test_a_passive_chain_decays_without_oscillation(friction):
    found = spectrum(chain(8, "clamped", friction=friction))
    assert found.is_stable
    assert np.abs(found.rates.imag).max() == 0.0
    if friction == "one-body":
        assert found.abscissa == pytest.approx(found.leading.growth, rel=1e-10)
        assert found.transient_growth() == (1.0, 0.0)


def test_left_modes_read_the_amplitude_of_each_right_mode():
    scene = graded(7)
    found = spectrum(scene, modes=20)
    right = np.concatenate([mode.right for mode in found.modes]).reshape(-1, 42)
    left = np.concatenate([mode.left for mode in found.modes]).reshape(-1, 42)
    assert left.conj() @ right.T == pytest.approx(np.eye(len(right)), abs=1e-8)
    units = np.tile(np.repeat([1.0, 2.0 * scene.chain.radius / math.sqrt(3.0)], 3), 7)
    rigid = rigid_columns(found.state, scene.chain.radius) / units[:, None]
    assert np.abs(left.conj() @ rigid).max() < 1e-9 * np.abs(left).max()
    assert np.linalg.norm(right * units, axis=1) == pytest.approx(1.0)
    assert all(np.isrealobj(mode.right) for mode in found.modes if not mode.frequency)


@pytest.mark.parametrize("number", [1, 3, 6])
def test_as_many_leading_modes_are_given_as_asked_for(number):
    found = spectrum(graded(7), modes=number)
    counts = [mode.multiplicity * (2 if mode.frequency else 1) for mode in found.modes]
    assert sum(counts) >= number > sum(counts) - counts[-1]
    assert [mode.growth for mode in found.modes] == sorted(
        (mode.growth for mode in found.modes), reverse=True
    )
    assert all(mode.frequency >= 0.0 for mode in found.modes)
    assert found.leading.rate == pytest.approx(found.rates[0])


def test_rates_go_from_the_fastest_growth_on_and_pairs_with_the_positive_frequency_first():
    rates = spectrum(graded(7)).rates
    assert (np.diff(rates.real) <= 0.0).all()
    pairs = np.flatnonzero((np.diff(rates.real) == 0.0) & (rates[:-1] == rates[1:].conj()))
    turning = pairs[rates[pairs].imag != 0.0]
    assert len(turning) > 3
    assert (rates[turning].imag > 0.0).all()


def test_the_error_of_a_rate_covers_the_rounding_of_a_stiff_chain():
    """The same chain elsewhere is rounded differently: its rates differ by less than the errors."""
    changes = {"chain.particles": 12, "chain.ends": "free", "elasticity.ratio": 1e12}
    scene = nrchain.load_scene("buckling", **changes)
    found = spectrum(scene)
    positions, frames, _ = rigid_motion(*found.state.poses, seed=3)
    there = spectrum(scene, at=(positions, frames))
    for mode in found.modes:
        other = min(there.modes, key=lambda one: abs(one.rate - mode.rate))
        assert abs(other.rate - mode.rate) <= 3.0 * (mode.error + other.error)
        assert mode.error < 1e-5 * abs(mode.rate)


@pytest.mark.parametrize("ends", ["free", "clamped", "periodic"])
def test_sensitivities_are_differences_of_spectra(ends):
    scene = chain(7, ends, **MIX, friction="pairwise", **FAR)
    found = spectrum(scene)
    rates = found.sensitivities()
    assert {"chain.spacing", "chain.radius", "chain.viscosity"} < set(rates)
    assert {"elasticity.stretch", "elasticity.bend", "slip.2s", "slip.3a"} < set(rates)
    moduli = {"elasticity.twist": 900.0, "elasticity.bend": 700.0, "elasticity.stretch": 30.0}
    chains = {"chain.spacing": 6.0, "chain.radius": 1.3, "chain.viscosity": 0.7}
    leading = found.leading.rate
    size = abs(leading)
    for key, value in (MIX | moduli | chains).items():
        step = 1e-3 * abs(value)
        ends_of = [
            spectrum(nrchain.load_scene(scene, **{key: value + sign * step})).modes
            for sign in (1.0, -1.0)
        ]
        nearest = [min(modes, key=lambda m: abs(m.rate - leading)).rate for modes in ends_of]
        expected = (nearest[0] - nearest[1]) / (2.0 * step)
        assert rates[key] * value == pytest.approx(expected * value, rel=1e-3, abs=1e-5 * size), key


def test_sensitivities_of_each_sphere_add_up_to_that_of_all():
    each = {key: [value] * 8 for key, value in MIX.items()}
    single = spectrum(chain(8, "clamped", **each)).sensitivities()
    whole = spectrum(chain(8, "clamped", **MIX)).sensitivities()
    for key in MIX:
        total = sum(single[f"{key}[{i}]"] for i in range(8))
        assert total == pytest.approx(whole[key], rel=1e-6, abs=1e-9)


WAVERING = {"slip.2s": 60.0, "slip.3t": 500.0, "elasticity.ratio": 1e8}


@pytest.mark.parametrize(
    ("name", "changes"),
    [("wave", {}), pytest.param("buckling", WAVERING, marks=pytest.mark.slow)],
)
def test_transient_growth_is_the_largest_norm_of_the_exponential(name, changes):
    scene = nrchain.load_scene(name, **changes)
    found = spectrum(scene)
    matrix = matrix_of(scene, found)
    if scene.chain.ends == "free":
        shapes = null_space(rigid_columns(found.state, scene.chain.radius).T)
        matrix = shapes.T @ matrix @ shapes
    highest = np.linalg.eigvalsh(matrix + matrix.T)[-1] / 2
    assert found.abscissa == pytest.approx(highest, rel=1e-4)
    growth = found.transient_growth()
    assert growth.growth > 1.1
    times = growth.time * np.linspace(0.0, 3.0, 61)
    norms = [np.linalg.norm(expm(matrix * time), 2) for time in times]
    assert growth.growth == pytest.approx(max(norms), rel=1e-5)
    assert growth.time == pytest.approx(times[int(np.argmax(norms))], rel=0.06)


@pytest.mark.parametrize("changes", [{"slip.2s": 100.0}, MIX, {"slip.3t": 60.0, "slip.2s": 20.0}])
def test_a_small_mode_grows_at_its_rate(changes):
    """A run from the state, a little off it along the mode, against exp(Λ t)."""
    scene = chain(8, "clamped", **changes, **ISOTROPIC)
    found = spectrum(scene)
    mode, small = found.leading, 1e-6
    end = 1.0 / abs(mode.rate)
    begin = moved(*found.state.poses, small * mode.right[0].real)
    tight = {"run.end": end, "run.snapshots": 2, "run.rtol": 1e-10, "run.atol": 1e-13}
    positions, frames = begin
    run = nrchain.simulate(nrchain.load_scene(scene, **tight), positions=positions, frames=frames)
    expected = small * (mode.right[0] * np.exp(mode.rate * end)).real[:, :3]
    reached = run.positions[-1] - found.state.positions
    assert reached == pytest.approx(expected, abs=2e-4 * np.abs(expected).max())


@pytest.mark.filterwarnings("ignore::nrchain.SceneWarning")
@pytest.mark.parametrize(
    ("changes", "key"),
    [
        ({"flow.gradient": [[0, 1.0, 0], [0, 0, 0], [0, 0, 0]]}, "flow.gradient"),
        ({"field.torque": [0.0, 300.0, 0.0]}, "field"),
        ({"slip.2s": {"strength": 5.0, "axis": [1.0, 1.0, 0.0]}}, "slip"),
    ],
)
def test_what_forbids_a_straight_state_is_refused_by_its_key(changes, key):
    with pytest.raises(SceneError) as refused:
        spectrum(chain(6, **changes))
    assert refused.value.key == key


def test_a_flow_in_which_a_chain_tumbles_is_named_with_the_velocity_that_is_left():
    """A stiff chain in a shear has no steady orientation."""
    stiff = {"elasticity": {"stretch": 3e3, "shear": 3e3, "twist": 9e4, "bend": 9e4}}
    scene = chain(6, **{"flow.gradient": [[0, 0.1, 0], [0, 0, 0], [0, 0, 0]]}, **stiff)
    positions = np.outer(np.arange(6.0), [4.0, 4.0, 0.0])
    with pytest.raises(SceneError, match=r"flow.gradient.*spheres move .* at up to \d") as refused:
        spectrum(scene, at=(positions, np.broadcast_to(np.eye(3), (6, 3, 3))))
    assert refused.value.key == "flow.gradient"


def test_poses_far_from_any_state_are_refused_with_their_velocity():
    scene = graded(8)
    state = spectrum(scene).state
    generator = np.random.default_rng(2)
    shape = np.hstack([4.0 * generator.standard_normal((8, 3)), generator.standard_normal((8, 3))])
    poses = moved(*state.poses, shape)
    with pytest.raises(SceneError, match=r"is no state: spheres move .* at up to \d") as refused:
        spectrum(scene, at=poses)
    assert refused.value.key == "at"


def test_arguments_are_checked():
    scene = chain(6)
    with pytest.raises(SceneError, match=r"must be \(positions, frames\) or a trajectory"):
        spectrum(scene, at=3)
    with pytest.raises(SceneError, match=r"the shape must be \(6, 3\)"):
        spectrum(scene, at=(np.zeros((5, 3)), np.zeros((5, 3, 3))))
    with pytest.raises(SceneError, match="load_scene"):
        spectrum("buckling")


def test_what_cannot_be_computed_is_refused():
    with pytest.raises(SceneError, match=r"chain.particles = 2: leaves no sphere free"):
        spectrum(chain(2, "clamped"))
    with pytest.raises(SceneError, match="effects = 'auto': must be chosen first"):
        spectrum(chain(6, effects="auto", tolerance=0.1))
    with pytest.raises(SceneError, match="the straight chain"):
        spectrum(chain(6, **{"slip.3t": 1e300}))
    remedy = r"spheres touch at link 6, .*; raise elasticity.ratio or weaken the slip"
    with pytest.raises(SceneError, match=remedy):
        spectrum(chain(8, "clamped", **{"slip.3t": 1500.0}))


def test_the_smallest_chains_have_spectra():
    for count, ends in ((2, "free"), (3, "clamped"), (2, "periodic")):
        found = spectrum(chain(count, ends, **{"slip.2s": 1.0}))
        free = count - 2 * (ends == "clamped")
        assert len(found.rates) + len(found.neutral.rates) == 6 * free


def test_spheres_without_links_stay_where_they_are():
    slack = {f"elasticity.{name}": 0.0 for name in ("stretch", "shear", "twist", "bend")}
    found = spectrum(chain(4, **slack))
    assert np.abs(found.rates).max() < 1e-14
    assert not found.is_stable


def test_newtons_method_converges_fast_and_says_how_far_it_came():
    scene = graded(9, **FAR)
    state = spectrum(scene).state
    assert state.found
    assert state.steps <= 8
    assert state.error < 1e-9
    again = find_steady_state(scene, state.poses)
    assert again.steps == 1
