"""The table of modes against the closed forms as printed, and its vector calculus."""

from fractions import Fraction as F

import pytest

from nrchain import slip_modes
from nrchain.errors import SceneError
from nrchain.hydrodynamics.flow_tables import curl, divergence, laplacian
from nrchain.hydrodynamics.slip_mode import SlipMode
from nrchain.planning.effect_changes import possible_changes
from nrchain.scene.loading import load_scene

# Physics reference, section 2: a w / V over powers of a/r, written out by hand.
PRINTED_SPINS = {
    "2s": {("x", 3): (0, F(7, 2))},
    "3a": {("n", 4): (F(-13, 24), 0, F(65, 24)), ("e", 4): (0, F(-13, 12))},
    "3t": {},
    "4a": {
        ("e", 5): (F(-1089, 80), 0, F(5445, 80)),
        ("n", 5): (0, F(5445, 80), 0, F(-12705, 80)),
    },
}


@pytest.mark.parametrize("label", PRINTED_SPINS)
def test_half_the_curl_is_the_printed_torque_law(label):
    assert slip_modes.find(label).spin() == PRINTED_SPINS[label]


@pytest.mark.parametrize("mode", slip_modes.modes(), ids=lambda mode: mode.label)
def test_finite_size_changes_the_velocity_of_2s_alone(mode):
    assert (mode.flow(True) != mode.flow()) == (mode.label == "2s")
    assert mode.spin(True) == mode.spin()


def test_finite_size_of_2s_as_released_by_pystokes():
    # 3(1 − (8/3)s²)(c² − 1/3) n + (16/5) s² (c e − n/3), times 7/6: propulsionT2s of 2.3.2
    flow = slip_modes.find("2s").flow(finite_size=True)
    assert flow["n", 4] == (F(28, 9) - F(56, 45), 0, F(-28, 3))
    assert flow["e", 4] == (0, F(56, 15))


@pytest.mark.parametrize("mode", slip_modes.modes(), ids=lambda mode: mode.label)
def test_vorticity_is_harmonic(mode):
    assert laplacian(curl(mode.flow())) == {}


def test_unknown_label_names_the_nearest():
    with pytest.raises(SceneError, match="did you mean '2s'"):
        slip_modes.find("2S")


def test_a_label_cannot_be_taken_twice():
    other = SlipMode("2s", "impostor", 2, False, False, {("n", 2): (1, 0, -3)})
    with pytest.raises(SceneError, match="taken"):
        slip_modes.register(other)


@pytest.mark.parametrize("row", [("y", 2), ("n", 0)])
def test_rows_outside_the_basis_are_refused(row):
    with pytest.raises(SceneError, match="power of a/r"):
        SlipMode("9z", "nonsense", 9, False, False, {row: (1,)})


@pytest.mark.parametrize("mode", slip_modes.modes(), ids=lambda mode: mode.label)
def test_flows_have_no_divergence(mode):
    for finite_size in (False, True):
        assert divergence(mode.flow(finite_size)) == {}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"velocity": {("n", 4): (0, 1)}}, "no divergence"),
        ({"velocity": {("x", 3): (0, 0, 1)}, "polar": True, "chiral": True}, "Stokes flow"),
        ({"velocity": {}}, "at least one row"),
        ({"velocity": {("n", 2): ("x",)}}, "coefficients"),
        ({"velocity": {("n", 2): ("1/0",)}}, r"row n \(a/r\)\^2 = \('1/0',\): coefficients"),
        ({"velocity": {("n", 2): (float("inf"),)}}, "coefficients"),
        ({"velocity": {("n", 2): (10**400,)}}, "coefficients"),
        ({"velocity": {("n", 2): "12"}}, "coefficients"),
        ({"velocity": {("n", 2): 5}}, "coefficients"),
        ({"velocity": {("n", 2, 3): (1,)}}, "keyed by one of n, e, x"),
        ({"velocity": {5: (1,)}}, "keyed by one of n, e, x"),
        ({"velocity": {("n", "2"): (1,)}}, "keyed by one of n, e, x"),
        ({"velocity": {("n", 2.5): (1,)}}, "keyed by one of n, e, x"),
        ({"velocity": {("n", 2): (-(10**101), 0, 3 * 10**101)}}, "of at most 1e100"),
        ({"velocity": None}, "must be {"),
        ({"order": "2"}, "order of mode 9z = '2': must be a whole number"),
        ({"polar": None}, "true or false"),
        ({"name": None}, "printable text"),
        ({"label": 9}, "a digit followed"),
        ({"velocity": {("n", 2): (1,)}}, "no net flux"),
        ({"velocity": {("n", 2): (1, 0, 1)}}, "no net flux"),
        ({"polar": True}, "odd in e"),
        ({"chiral": True}, "e × n"),
        ({"label": "backend"}, "a digit followed"),
        ({"label": ""}, "a digit followed"),
    ],
)
def test_modes_that_are_no_such_flow_are_refused(changes, message):
    good = {
        "label": "9z",
        "name": "stresslet",
        "order": 2,
        "polar": False,
        "chiral": False,
        "velocity": {("n", 2): (-1, 0, 3)},
    }
    SlipMode(**good)
    with pytest.raises(SceneError, match=message):
        SlipMode(**(good | changes))


def test_a_flow_as_of_a_force_has_no_sum_over_images():
    """(e + n c) a/r: images on both sides push the same way, and Σ 1/m diverges."""
    stokeslet = {("e", 1): (1,), ("n", 1): (0, 1)}
    slip_modes.register(SlipMode("1s", "stokeslet", 1, True, False, stokeslet))
    try:
        ends = {"slip.2s": None, "slip.1s": 1.0, "chain.ends": "periodic"}
        scene = load_scene("buckling", **ends)
        with pytest.raises(SceneError, match=r"^slip\.neighbours = 'all': .*1/r has no sum"):
            load_scene(scene, **{"slip.neighbours": "all"})
        assert load_scene(scene, **{"slip.neighbours": "all", "slip.1s": 0.0})
        assert load_scene(scene, **{"slip.neighbours": "all", "chain.ends": "free"})
        assert "slip of all pairs" not in [change.effect for change in possible_changes(scene)]
    finally:
        slip_modes.unregister("1s")


def test_only_modes_can_be_registered():
    with pytest.raises(SceneError, match="SlipMode"):
        slip_modes.register(5)
