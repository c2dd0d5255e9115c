"""Cells are halved along boundaries, and nowhere else."""

import numpy as np

import nrchain
from nrchain.diagrams.mesh import Mesh, corners
from nrchain.diagrams.plane import Axis, Plane


def plane(count=5, levels=3):
    scene = nrchain.load_scene("buckling", **{"chain.particles": 5})
    return Plane(
        scene, Axis("slip.2s", -2.0, 2.0, count), Axis("slip.3t", -2.0, 2.0, count), levels
    )


def explored(given, inside, most=10**6):
    """The mesh and its labels, refined until nothing changes."""
    mesh, labels = Mesh(given), {}
    sites = mesh.sites()
    while sites:
        labels |= {site: inside(*given.place(site)) for site in sites}
        sites = mesh.refine(labels, most - len(labels))
    return mesh, labels


def disc(x, y):
    return x * x + y * y < 1.44


def test_cells_fill_the_plane_once():
    given = plane()
    mesh, _ = explored(given, disc)
    covered = np.zeros(given.ends, int)
    for i, j, side in mesh.cells:
        covered[i : i + side, j : j + side] += 1
    assert np.all(covered == 1)


def test_every_cell_that_holds_the_boundary_is_of_the_finest():
    given = plane()
    mesh, labels = explored(given, disc)
    whole = {site: disc(*given.place(site)) for site in np.ndindex(*(np.array(given.ends) + 1))}
    for cell in mesh.cells:
        if cell[2] > 1:
            assert len({whole[site] for site in corners(cell)}) == 1
    # a circle crosses 4 · 2r/h squares of side h; what is labelled is of that order, not of 1/h²
    assert len(labels) < len(whole) / 2


def test_a_boundary_that_enters_a_cell_between_its_corners_is_followed():
    def strip(x, y):
        return abs(y - 0.5) < 0.2 and x < 1.7

    given = plane()
    _, alone = explored(given, strip)
    assert not any(alone.values())  # no point of the coarse grid lies in it
    _, labels = explored(given, lambda x, y: strip(x, y) or disc(x, y))
    assert any(one and given.place(site)[0] > 1.3 for site, one in labels.items())


def test_a_budget_is_kept_and_each_level_comes_before_the_next():
    given = plane()
    _, coarse = explored(given, disc, most=25)
    assert len(coarse) == 25
    mesh, labels = explored(given, disc, most=60)
    assert 50 < len(labels) <= 60
    assert min(side for *_, side in mesh.cells) >= 2
    assert mesh.mixed(labels)


def test_values_at_the_ends_of_an_axis_are_exact():
    given = Plane(plane().scene, Axis("slip.2s", -0.3, 0.7, 4), Axis("slip.3t", 0.1, 0.2, 7), 2)
    assert given.place((0, 0)) == (-0.3, 0.1)
    assert given.place(given.ends) == (0.7, 0.2)
