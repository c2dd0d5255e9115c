"""Curves of zero growth, against circles and lines that are known."""

import math

import numpy as np
import pytest

import nrchain
from nrchain.diagrams.curves import trace
from nrchain.diagrams.linear import Length, Lengths, Rate
from nrchain.diagrams.mesh import Mesh
from nrchain.diagrams.plane import Axis, Plane

RADIUS = 1.3


def plane(levels=3):
    scene = nrchain.load_scene("buckling", **{"chain.particles": 5})
    return Plane(scene, Axis("slip.2s", -2.0, 2.0, 5), Axis("slip.3t", -2.0, 2.0, 5), levels)


def traced(given, growth, frequency=lambda x, y: 0.0):
    """The curves of a known growth, whose zeros are found by bisection."""
    mesh, rates = Mesh(given), {}
    sites = mesh.sites()
    while sites:
        for site in sites:
            rates[site] = Rate(growth(*given.place(site)), frequency(*given.place(site)))
        sites = mesh.refine({site: rate.sign for site, rate in rates.items()})

    def do(jobs):
        return [zero(job) for job in jobs]

    def zero(job):
        scene, key, low, high = job.arguments
        x, y = (float(scene.slip.modes[label].strength) for label in ("2s", "3t"))

        def at(value):
            return (value, y) if key == "slip.2s" else (x, value)

        ends = [low, high]
        for _ in range(60):
            middle = 0.5 * sum(ends)
            ends[(growth(*at(middle)) > 0.0) == (growth(*at(high)) > 0.0)] = middle
        return {"value": ends[1], "error": 1e-15, "frequency": frequency(*at(ends[1]))}

    return trace(given, mesh, rates, do)[0]


def test_a_circle_is_one_closed_curve():
    (curve,) = traced(plane(), lambda x, y: RADIUS**2 - x * x - y * y)
    assert (curve.x[0], curve.y[0]) == (curve.x[-1], curve.y[-1])
    assert np.hypot(curve.x, curve.y) == pytest.approx(RADIUS, abs=1e-12)
    length = np.hypot(np.diff(curve.x), np.diff(curve.y)).sum()
    assert length == pytest.approx(2.0 * math.pi * RADIUS, rel=1e-3)


def test_two_lines_are_two_curves_that_end_at_the_edges():
    curves = traced(plane(), lambda x, y: math.cos(1.5 * (x - 0.3 * y)))
    found = sorted(abs(curve.x[0] - 0.3 * curve.y[0]) for curve in curves)
    assert found == pytest.approx([math.pi / 3.0] * 2, abs=1e-12)
    for curve in curves:
        ends = [max(abs(curve.x[k]), abs(curve.y[k])) for k in (0, -1)]
        assert ends == pytest.approx([2.0, 2.0])


def test_a_curve_ends_where_buckling_meets_flutter():
    curves = traced(plane(), lambda x, y: x + 0.1, lambda x, y: max(y, 0.0))
    assert sorted(curve.flutters for curve in curves) == [False, True]
    for curve in curves:
        assert curve.x == pytest.approx(-0.1)
        assert np.all((curve.y > 0.0) == curve.flutters)


def test_a_saddle_is_joined_by_the_sign_of_its_middle():
    for level in (0.05, -0.05):
        curves = traced(plane(levels=0), lambda x, y, c=level: (x - 0.5) * (y - 0.5) + c)
        assert len(curves) == 2
        for curve in curves:
            assert len({x > 0.5 for x in np.round(curve.x, 9)}) == 1 or level < 0.0


def test_points_of_the_straight_chain_are_those_of_critical_strength():
    scene = nrchain.load_scene("buckling", **{"chain.particles": 6, "slip.3t": 400.0})
    expected = nrchain.critical_strength(scene, "slip.2s", (200.0, 2000.0))
    x, y = ("slip.2s", 0.0, 1000.0, 2), ("slip.3t", 400.0, 500.0, 2)
    given = Plane(scene, Axis(*x), Axis(*y), 0)
    mesh = Mesh(given)
    rates = {site: Rate(-1.0 if site[0] == 0 else 1.0, 0.0) for site in mesh.sites()}
    (curve,), _ = trace(
        given, mesh, rates, lambda jobs: [job.function(*job.arguments) for job in jobs]
    )
    at = int(np.argmin(curve.y))
    assert curve.x[at] == pytest.approx(expected.value, rel=1e-9)
    assert 0.0 < curve.x_error[at] < 1e-6 * expected.value


def test_runs_last_longer_where_the_straight_chain_is_slow():
    scene = nrchain.load_scene("buckling", **{"chain.particles": 5})
    coarse = [Rate(-0.1, 0.0), Rate(-0.01, 0.0), Rate(0.05, 0.2, 0.2), Rate(why="no state")]
    lengths = Lengths(scene, coarse, None)
    usual, slow = lengths.of(Rate(-1.0, 0.0)), lengths.of(Rate(-0.01, 0.0))
    assert usual.end == pytest.approx(40.0 / 0.05)
    assert slow.end == pytest.approx(40.0 / 0.01)
    critical = lengths.of(Rate(1e-9, 0.0))
    assert critical.is_capped
    assert critical.end == pytest.approx(10.0 * usual.end)
    turning = lengths.of(Rate(0.05, 0.2, 0.4))
    assert turning.end == pytest.approx(40.0 / 0.05 + 40.0 * 2.0 * math.pi / 0.2)
    assert turning.end / (turning.snapshots - 1) < 2.0 * math.pi / 0.4 / 20.0
    assert Lengths(scene, coarse, 100.0).of(coarse[0]).end == 100.0


def test_a_second_run_waits_for_the_slow_modes_of_the_state_that_it_nears():
    first = Length(100.0, 401)
    assert first.longer().end == 500.0
    assert first.longer(-0.001).end == pytest.approx(100.0 + 40.0 / 0.001)
    assert first.longer(0.001).end == first.longer(-0.001).end
    # a state that the run has left is no reason to wait
    assert first.longer(0.5).end == 500.0
    capped = Length(100.0, 401, most=200.0).longer(-0.001)
    assert capped.end == 200.0
    assert capped.is_capped
    assert Length(100.0, 401, most=120.0).longer() is None
