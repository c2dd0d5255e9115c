"""``nrchain spectrum`` shows the state, its modes and their sensitivities."""

import pytest
from support.command_line import assert_refused, call

import nrchain
from nrchain.states import transient


def test_the_modes_of_a_clamped_chain_are_shown():
    changes = ["--set", "chain.particles=8", "--set", "slip.2s=20"]
    result = call("spectrum", "buckling", *changes)
    assert result.exit_code == 0
    scene = nrchain.load_scene("buckling", **{"chain.particles": 8, "slip.2s": 20.0})
    found = nrchain.spectrum(scene)
    for part in ("the straight chain is at rest", "neutral motions: none", "stable", "slip.2s"):
        assert part in result.stdout
    assert f"{found.leading.growth:.6g}" in result.stdout
    assert f"{0.01 * 20.0 * found.sensitivities()['slip.2s'].real:+.3g}" in result.stdout


def test_the_motion_of_a_spinning_chain_is_shown_with_its_neutral_motions():
    result = call("spectrum", "spiral-left", "--set", "chain.particles=6", "--modes", "2")
    assert result.exit_code == 0
    assert "rotates at Ω = (-" in result.stdout
    assert "neutral motions: 6 (translation along x" in result.stdout


def test_growing_modes_are_counted():
    result = call("spectrum", "buckling")
    assert "unstable: 4 of 108 modes grow\n" in result.stdout
    flutter = ["--set", "slip.2s=60", "--set", "slip.3t=1000", "--set", "elasticity.ratio=1e8"]
    result = call("spectrum", "buckling", *flutter, "--modes", "6")
    assert "unstable: 4 of 108 modes grow\n" in result.stdout
    assert "±0.0191554" in result.stdout
    result = call("spectrum", "buckling", "--modes", "2")
    assert "unstable: 4 of 108 modes grow\n" in result.stdout


def test_transient_growth_is_shown_where_it_is_computed(monkeypatch):
    wavering = ["--set", "slip.2s=60", "--set", "slip.3t=500", "--set", "elasticity.ratio=1e8"]
    result = call("spectrum", "buckling", *wavering)
    assert "small changes grow up to 1.665 times, at t = 205" in result.stdout
    monkeypatch.setattr(transient, "SPHERES", 10)
    result = call("spectrum", "buckling", *wavering)
    assert "transient growth is not computed for so many spheres" in " ".join(result.stdout.split())
    assert "decay from the start" in call("spectrum", "stable").stdout


def test_the_end_of_a_run_may_be_given(tmp_path):
    scene = ["--set", "chain.particles=6", "--set", "run.end=500"]
    assert call("run", "stable", *scene, "-o", tmp_path / "run").exit_code == 0
    result = call("spectrum", "stable", *scene, "--at", tmp_path / "run")
    assert result.exit_code == 0
    assert "the chain is at rest" in result.stdout


@pytest.mark.filterwarnings("ignore::nrchain.SceneWarning")
def test_what_has_no_state_is_refused_in_one_line(tmp_path):
    shear = "flow.gradient=[[0,1,0],[0,0,0],[0,0,0]]"
    refused = call("spectrum", "passive", "--set", "chain.ends=free", "--set", shear)
    assert_refused(refused, "flow.gradient", "does not stay straight")
    assert_refused(call("spectrum", "passive", "--at", tmp_path), "no such trajectory")
