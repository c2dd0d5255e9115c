"""The look of pictures: seen on white, by the colour-blind and in grey."""

from itertools import combinations

import matplotlib
import numpy as np
import pytest
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from nrchain.view import style

SEEN_BY = {
    "anyone": np.eye(3),
    # G. M. Machado, M. M. Oliveira, L. A. F. Fernandes, IEEE Trans. Vis. Comput. Graph. 15, 1291
    # (2009), table 1, severity 1.0
    "protanopes": [
        [0.152286, 1.052583, -0.204868],
        [0.114503, 0.786281, 0.099216],
        [-0.003882, -0.048116, 1.051998],
    ],
    "deuteranopes": [
        [0.367322, 0.860646, -0.227968],
        [0.280085, 0.672501, 0.047413],
        [-0.011820, 0.042940, 0.968881],
    ],
    "tritanopes": [
        [1.255528, -0.076749, -0.178779],
        [-0.078411, 0.930809, 0.147602],
        [0.004733, 0.691367, 0.303900],
    ],
}

XYZ = [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750]]
XYZ += [[0.0193339, 0.1191920, 0.9503041]]


def lab(colour, eyes=None):
    """CIE L*a*b* of a colour, under D65."""
    given = np.array(to_rgb(colour))
    linear = np.where(given <= 0.04045, given / 12.92, ((given + 0.055) / 1.055) ** 2.4)
    seen = np.clip(np.array(SEEN_BY["anyone"] if eyes is None else eyes) @ linear, 0.0, 1.0)
    x, y, z = np.array(XYZ) @ seen / [0.95047, 1.0, 1.08883]
    x, y, z = (np.cbrt(v) if v > 216 / 24389 else 841 / 108 * v + 4 / 29 for v in (x, y, z))
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])


def test_contrast_is_that_of_the_guidelines():
    """The example of WCAG: #767676 is the lightest grey with 4.5 on white."""
    assert style.contrast("#767676") == pytest.approx(4.54, abs=0.005)
    assert style.contrast("#777777") == pytest.approx(4.48, abs=0.005)


@pytest.mark.parametrize("colour", [*style.COLOURS, style.INK, style.PALE])
def test_each_colour_is_seen_on_white(colour):
    assert style.contrast(colour) >= style.LEAST_CONTRAST


@pytest.mark.parametrize("count", [1, 2, 6, 40])
def test_each_time_is_seen_on_white_and_a_later_one_is_darker(count):
    colours = style.time_colours(count)
    found = [style.contrast(colour[:3]) for colour in colours]
    assert len(found) == count
    assert min(found) >= style.LEAST_CONTRAST
    assert np.all(np.diff(found) > 0.0)


@pytest.mark.parametrize("eyes", SEEN_BY)
def test_colours_differ_for_each_kind_of_sight(eyes):
    """A distance of 2.3 is just seen; thin lines need some ten times that."""
    seen = [lab(colour, SEEN_BY[eyes]) for colour in (*style.COLOURS, style.INK)]
    assert min(np.linalg.norm(a - b) for a, b in combinations(seen, 2)) > 18.0


def test_lines_and_points_differ_without_colour():
    assert len(set(style.DASHES)) == len(style.DASHES) >= 5
    assert len(set(style.MARKERS)) == len(style.MARKERS) >= 7
    looks = [(one["color"], one["linestyle"]) for one in map(style.line_look, range(30))]
    assert len(set(looks)) == 30


def test_two_neighbours_in_turn_differ_in_grey():
    lightness = [lab(colour)[0] for colour in style.COLOURS[:2]]
    assert abs(np.diff(lightness)[0]) > 30.0


def test_axes_of_a_caller_are_styled_without_a_change_of_settings():
    before = dict(matplotlib.rcParams)
    axes = Figure().subplots()
    style.style_axes(axes)
    style.write_title(axes, "title")
    style.write_letter(axes, "a")
    style.write_key(axes.figure, {"line": axes.plot([1, 2], **style.line_look(3))[0]}, 1)
    assert dict(matplotlib.rcParams) == before
    assert axes.xaxis.label.get_size() == style.LABEL == 8.0
