"""Each line of a plan against an independent number, and a plan for every scene."""

import math

import numpy as np
import pytest
from support.poses import moved

import nrchain
from nrchain import measure, rod
from nrchain.errors import SceneError
from nrchain.motion.model import Model
from nrchain.planning.plan import plan
from nrchain.scene.poses import initial_poses

OPPOSED = [100.0] * 10 + [-250.0] * 10
GAMMA = 6 * math.pi


def lines(name, **changes):
    return {line.quantity: line for line in plan(nrchain.load_scene(name, **changes)).lines}


def numbers(text):
    found = []
    for word in text.replace("/", " ").replace("(", " ").replace(",", " ").split():
        try:
            found.append(float(word))
        except ValueError:
            continue
    return found


def force_on_the_left_half(count, strength, neighbours):
    """Σ of the slip forces that the right half of a straight chain exerts on the left one."""
    positions = 10.0 * np.arange(count)[:, None] * np.eye(3)[0]
    frames = np.broadcast_to(np.eye(3), (count, 3, 3))
    strengths = np.where(np.arange(count) < count // 2, 0.0, strength)
    forces, _ = nrchain.active_wrenches(positions, frames, {"2s": strengths}, neighbours=neighbours)
    return forces[: count // 2, 0].sum()


@pytest.mark.parametrize("name", nrchain.scene_names())
def test_shipped_scenes_have_a_plan_without_warnings(name):
    planned = plan(nrchain.load_scene(name))
    assert not planned.warnings
    always = {"closest approach", "tension", "stretch", "shear", "growth", "spins", "rounding"}
    assert always <= {x.quantity for x in planned.lines}


@pytest.mark.parametrize(
    "changes",
    [
        {"slip.2s": None},
        {"slip.2s": OPPOSED},
        {"friction": "pairwise"},
        {"slip.2s": None, "friction": {"kind": "pairwise", "neighbours": 2}},
        {"chain.ends": "periodic", "slip.4a": 1e3},
    ],
)
def test_every_chain_is_judged_and_uniform_ones_are_compared(changes):
    planned = lines("buckling", **changes)
    assert {"tension", "stretch", "shear", "growth", "spins", "closest approach"} <= set(planned)
    assert "chain" not in planned
    differ = changes.get("slip.2s") is OPPOSED
    assert ("waves: rates" in planned) is not differ
    assert all("infinite" in planned[name].meaning for name in planned if name.startswith("waves:"))


def test_closest_approach_is_that_of_the_start():
    positions = initial_poses(nrchain.load_scene("spiral-left"))[0]
    apart = np.linalg.norm(positions[:, None] - positions, axis=2) + 1e9 * np.eye(len(positions))
    assert numbers(lines("spiral-left")["closest approach"].value) == [
        pytest.approx(apart.min(), rel=1e-3)
    ]


@pytest.mark.parametrize("neighbours", [1, 3, "all"])
def test_the_tension_is_the_force_of_one_half_on_the_other(neighbours):
    changes = {"slip.neighbours": neighbours, "elasticity.ratio": None, "chain.ends": "free"}
    planned = lines("buckling", **changes)
    expected = -force_on_the_left_half(20, 100.0, neighbours)
    moduli = nrchain.load_scene("buckling").moduli
    for name, modulus in (("stretch", moduli.stretch), ("shear", moduli.shear)):
        tension, stiffness, strain = numbers(planned[name].value)
        assert tension == pytest.approx(expected, rel=5e-3)
        assert stiffness == pytest.approx(10.0 * modulus, rel=5e-3)
        assert strain == pytest.approx(expected / (10.0 * modulus), rel=2e-2)


def test_a_chain_of_two_strengths_is_judged_by_its_own_links():
    """Each half alone would carry 44 or −110; together they carry neither."""
    scene = nrchain.load_scene("buckling", **{"slip.2s": OPPOSED, "chain.ends": "free"})
    positions = 10.0 * np.arange(20)[:, None] * np.eye(3)[0]
    forces, _ = nrchain.active_wrenches(
        positions, np.broadcast_to(np.eye(3), (20, 3, 3)), {"2s": np.array(OPPOSED)}, neighbours=1
    )
    tension = np.cumsum(forces[:, 0].mean() - forces[:, 0])[:-1]
    most = int(np.argmax(np.abs(tension)))
    planned = {line.quantity: line for line in plan(scene).lines}
    assert planned["tension"].value == f"T = {tension[most]:.4g} in link {most}"
    swims = {line.quantity: line for line in plan(scene).lines}["swims"].value
    assert numbers(swims) == [pytest.approx(forces[:, 0].mean() / GAMMA, rel=1e-3)]


@pytest.mark.parametrize("changes", [{}, {"slip.2s": None}, {"friction": "pairwise"}])
def test_rates_are_those_of_a_ring_of_spheres(changes):
    """A ring of 24 spheres holds the longest wave of 12; of many rings, one nearly the fastest."""
    stiff = {"ratio": None, "stretch": 500.0, "shear": 500.0}
    scene = nrchain.load_scene(
        "buckling", **changes, elasticity=stiff, **{"chain.particles": 12, "chain.ends": "free"}
    )
    passive = "slip.2s" in changes
    ring = nrchain.load_scene(scene, **{"chain.ends": "periodic"})
    sizes = [24] if passive else range(12, 25, 3)
    values = np.concatenate(
        [
            np.linalg.eigvals(derivative(Model(nrchain.load_scene(ring, **{"chain.particles": n}))))
            for n in sizes
        ]
    )
    planned = {line.quantity: line for line in plan(scene).lines}
    slowest, fastest = numbers(planned["waves: rates"].value)
    assert fastest == pytest.approx(np.abs(values).max(), rel=2e-2)
    if passive:
        assert planned["waves: growth"].value == "none"
        assert values.real.max() < 1e-6
        assert slowest == pytest.approx(np.abs(values)[np.abs(values) > 1e-5].min(), rel=1e-2)
    else:
        grows = numbers(planned["waves: growth"].value)[0]
        assert grows == pytest.approx(values.real.max(), rel=0.02)


def derivative(model):
    """∂(v, ω)/∂(u, φ) (6N, 6N) of a straight chain, column by column."""
    count = model.count
    positions = 10.0 * np.arange(count)[:, None] * np.eye(3)[0]
    frames = np.broadcast_to(np.eye(3), (count, 3, 3)).copy()
    model.linearise(positions, frames, np.empty((count, 2 * model.reach + 1, 6, 6)))
    matrix = np.zeros((6 * count, count, 6))
    for n, column in enumerate(matrix):
        if model.is_banded:
            ahead, behind = (
                model.twists(*moved(positions, frames, n // 6, n % 6, step))
                for step in (1e-6, -1e-6)
            )
            column[:] = (ahead - behind) / 2e-6
        else:
            model.add_product(np.eye(6 * count)[n].reshape(count, 6), column)
    return matrix.reshape(6 * count, 6 * count).T


def test_waves_are_those_of_the_papers_law():
    """Re Λ = A x² − B x⁴ at x = qd, greatest at x² = A/2B: Eq. 2s_tr_displ and Eq. pass_ac."""
    count, ratio = 20, 1e12
    planned = lines("buckling", **{"elasticity.ratio": ratio})
    law = rod.Rod.of(nrchain.load_scene("buckling", **{"elasticity.ratio": ratio}))
    x = np.linspace(0.01, 1.0, 2000)
    rates = rod.beam_rates(law, x / 10.0).real.max(axis=1)
    growth, phase = numbers(planned["waves: growth"].value)
    assert growth == pytest.approx(rates.max(), rel=5e-3)
    assert phase == pytest.approx(x[np.argmax(rates)], abs=math.pi / 60)
    longest = numbers(planned["waves: longest"].value)[0]
    exact = rod.beam_rates(law, [math.pi / (10.0 * count)]).real.max()
    assert longest == pytest.approx(exact, rel=1e-2)
    assert lines("stable")["waves: growth"].value == lines("stable")["growth"].value == "none"


def test_growth_is_that_of_this_chain_and_turns_are_those_of_its_bend():
    """A ring as long as many waves grows as the infinite chain, and turns by qd a link."""
    planned = lines(
        "buckling",
        **{"chain.ends": "periodic", "chain.particles": 96, "elasticity.ratio": 1e11},
    )
    rate, tens = numbers(planned["growth"].value)[0], numbers(planned["growth"].meaning)[0]
    fastest, phase = numbers(planned["waves: growth"].value)
    assert rate == pytest.approx(fastest, rel=2e-2)
    assert tens == pytest.approx(rate * 1000.0 / math.log(10), rel=1e-2)
    assert numbers(planned["turns"].value)[0] == pytest.approx(phase, rel=0.1)


@pytest.mark.parametrize("strengths", [[100.1, -33.3, 33.3, -100.1], [0.1, 0.2, -0.2, -0.1]])
def test_a_chain_whose_halves_cancel_neither_swims_nor_spins_by_rounding(strengths):
    own = {"chain.particles": 4, "chain.spacing": 7.3, "chain.radius": 1.3, "chain.ends": "free"}
    assert "swims" not in lines("passive", **own, **{"slip.3t": strengths})
    assert lines("passive", **own, **{"slip.4a": strengths})["spins"].value == "Ω = 0"
    uneven = [*strengths[:-1], 0.9999 * strengths[-1]]
    assert numbers(lines("passive", **own, **{"slip.3t": uneven})["swims"].value)[0] > 0.0
    assert numbers(lines("passive", **own, **{"slip.4a": uneven})["spins"].value)[0] < 0.0


def test_motion_is_that_of_a_chain_that_moves():
    """A straight free chain in a run; each of its ends is pushed from one side only."""
    scene = nrchain.load_scene("spiral-left", **{"run.end": 0.5, "start.shape": "straight"})
    planned = {line.quantity: line for line in plan(scene).lines}
    spun = measure.turned_angle(nrchain.simulate(nrchain.load_scene(scene, slip={"3a": 0})))
    assert numbers(planned["waves: spins"].value) == [pytest.approx(-7.26)]
    assert numbers(planned["spins"].value) == [pytest.approx(-7.26 * 0.95, rel=1e-3)]
    assert spun[-1] / 0.5 == pytest.approx(-7.26 * 0.95, rel=1e-2)
    turns = numbers(planned["spins"].meaning)[0]
    assert turns == pytest.approx(-7.26 * 0.95 * 0.5 / (2 * math.pi), rel=1e-3)
    assert lines("wave")["swims"].value == "V = 0.76"
    assert lines("wave")["waves: swims"].value == "V₀ = 0.8"
    assert "swims" not in lines("wave", **{"chain.ends": "clamped"})


def test_what_the_reach_of_slip_leaves_out_is_the_sum_over_the_rest():
    """In the beam limit 2s acts through Σ (1 − cos mθ)/m³ alone, but for its torques."""
    for reach in (1, 4):
        planned = lines("buckling", **{"slip.neighbours": reach, "chain.particles": 40})
        theta = math.pi / 40
        ratio = rod.reach_ratio("2s", theta) / rod.reach_ratio("2s", theta, reach)
        left = numbers(planned["reach of slip"].value)[0] / 100
        assert 0.0 < left < 1.0 - 1.0 / ratio
    assert "reach of slip" not in lines("buckling", **{"slip.neighbours": "all"})


def test_what_the_reach_of_friction_leaves_out_is_the_drag_of_the_rest():
    """1 + Σ 2 cos(mθ)(3a/4md)(1 + 2a²/3m²d²) multiplies the decay of bending waves."""
    changes = {"friction": {"kind": "pairwise", "neighbours": 2}, "elasticity.ratio": 1e12}
    theta, m = math.pi / 20, np.arange(1.0, 1e6)
    terms = 2 * np.cos(m * theta) * 0.075 / m * (1 + 2 / 300 / m**2)
    expected = 1.0 - (1.0 + terms[:2].sum()) / (1.0 + terms.sum())
    left = numbers(lines("passive", **changes)["reach of friction"].value)[0] / 100
    assert left == pytest.approx(abs(expected), rel=0.02)


def test_a_plan_states_the_least_mobility_where_friction_is_cut():
    planned = lines("passive", **{"friction": {"kind": "pairwise", "neighbours": 1}})
    # along the chain, spheres that are pushed against each other: 1 − 2 (3/2ρ − 1/ρ³) at ρ = 10
    assert numbers(planned["friction"].value)[0] == pytest.approx(1 - 2 * (0.15 - 0.001), rel=0.02)
    assert "friction" not in lines("passive", friction="pairwise")


def test_why_there_are_no_plane_waves_is_said_once_and_lists_no_strengths():
    strengths = [30.0 * i for i in range(14)]
    changes = {"chain.particles": 14, "chain.spacing": 8.0, "slip.3t": strengths}
    planned = lines("passive", **changes)
    assert "reach" not in planned
    assert planned["waves"].value == "not compared"
    assert planned["waves"].meaning == (
        "the chain has no plane waves: slip.3t must be one number for all spheres: a plane wave"
        " needs a uniform chain"
    )


def test_what_cannot_be_judged_says_so():
    planned = lines("buckling", **{"slip.neighbours": 2_000_000})
    assert planned["waves"].value == "not compared"
    assert "use 'all'" in planned["waves"].meaning
    assert planned["growth"].value != "not judged"
    planned = lines("buckling", **{"chain.particles": 1001, "elasticity.ratio": 1e14})
    assert planned["chain"].value == "not judged"
    assert "at most 1000" in planned["chain"].meaning
    beyond = plan(nrchain.load_scene("buckling", **{"slip.2s": 1e200}))
    assert any("cannot be judged" in text for text in beyond.warnings)


def test_a_start_that_a_run_would_refuse_is_refused():
    with pytest.raises(SceneError, match="turned by"):
        plan(nrchain.load_scene("buckling", **{"start.amplitude": 50.0}))


def test_tolerances_below_rounding_are_announced_with_a_floor():
    scene = nrchain.load_scene(
        "buckling",
        **{
            "elasticity.ratio": 1e12,
            "chain.particles": 64,
            "run.atol": 1e-13,
            "run.integrator": "cvode",
        },
    )
    planned = [text for text in plan(scene).warnings if "rounding" in text]
    assert len(planned) == 1
    floor = float(planned[0].split()[-1])
    looser = nrchain.load_scene(scene, **{"run.atol": 2 * floor})
    assert not plan(looser).warnings
    assert not plan(nrchain.load_scene(scene, **{"run.integrator": "radau"})).warnings
