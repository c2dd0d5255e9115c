"""``nrchain branch`` follows states along a key, writes them and draws them."""

import pytest
from support.command_line import assert_refused, call

import nrchain

SIX = ("--set", "chain.particles=6", "--set", "elasticity.ratio=1e8")


def test_branches_are_followed_written_and_drawn(tmp_path):
    folder = tmp_path / "found"
    words = ("branch", "buckling", "--along", "slip.2s=700:900", *SIX, "--branches", "2")
    words += ("--set", "elasticity.measure=isotropic")
    result = call(*words, "-o", folder)
    assert result.exit_code == 0
    found = nrchain.BranchDiagram.open(folder)
    special = found.special[0]
    for part in ("pitchfork", f"{special.value:.9g}", f"{len(found.branches[0])}"):
        assert part in result.stdout
    assert (folder / "branches.png").stat().st_size > 10_000
    assert call(*words, "-o", folder).stdout == result.stdout


def test_branches_begin_at_the_end_of_a_run(tmp_path):
    changes = {"chain.particles": 6, "elasticity.ratio": 1e8, "slip.2s": 900.0}
    changes |= {"start.amplitude": 0.3, "run.end": 300.0}
    nrchain.simulate(nrchain.load_scene("buckling", **changes), output=tmp_path / "run")
    result = call(
        *("branch", "buckling", "--along", "slip.2s=900:950", *SIX, "--set", "slip.2s=900"),
        *("--from", tmp_path / "run", "--branches", "1", "-o", tmp_path / "found"),
    )
    assert result.exit_code == 0
    found = nrchain.BranchDiagram.open(tmp_path / "found")
    assert found.branches[0].amplitude.min() > 0.1
    assert found.branches[0].is_stable.all()


@pytest.mark.parametrize("along", ["slip.2s", "slip.2s=5", "slip.2s=a:b", "slip.2s=1:2:3"])
def test_a_range_that_is_none_is_refused(along, tmp_path):
    result = call("branch", "buckling", "--along", along, "-o", tmp_path / "found")
    assert_refused(result, "--along", along, "KEY=LOW:HIGH")
    assert not (tmp_path / "found").exists()


@pytest.mark.slow
def test_cycles_that_leave_hopf_points_are_followed_and_drawn(tmp_path):
    keys = {"slip.2s": 200, "chain.particles": 12, "elasticity.ratio": 1e8}
    changes = [part for key, value in keys.items() for part in ("--set", f"{key}={value}")]
    result = call(
        *("branch", "buckling", "--along", "slip.3t=4100:4245", *changes, "--branches", "1"),
        *("--cycles", "-o", tmp_path),
    )
    assert result.exit_code == 0
    (onset,) = nrchain.BranchDiagram.open(tmp_path).special
    folder = tmp_path / f"cycles-{onset.value:.6g}"
    found = nrchain.CycleDiagram.open(folder)
    assert len(found.branches) == 2
    for branch in found.branches:
        assert f"{branch.periods[-1]:.6g}" in result.stdout
    assert (folder / "cycles.png").stat().st_size > 10_000


def test_a_key_that_is_given_twice_is_refused(tmp_path):
    twice = ("--along", "slip.2s=0:1", "--along", "slip.2s=0:3")
    result = call("branch", "buckling", *twice, "-o", tmp_path / "found")
    assert_refused(result, "--along", "each key once")


def test_the_limit_of_branches_is_noted_where_it_is_reached(tmp_path):
    limit = ("--branches", "1", "-o", tmp_path / "found")
    result = call("branch", "buckling", "--along", "slip.2s=700:800", *SIX, *limit)
    assert "no more than 1 branches are followed" in result.stderr
