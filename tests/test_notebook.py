"""What a notebook shows of results: tables whose texts are escaped and whose numbers are theirs."""

from __future__ import annotations

import numpy as np
import pytest
from support.markup import assert_plain_table

import nrchain
from nrchain.notebook import MOST_ROWS, table_html
from nrchain.planning.plan import plan

ODD = '<script>alert(1)</script> & "é" λ∥'


@pytest.fixture(scope="module")
def run():
    changes = {"chain.particles": 4, "run.end": 1.0, "run.snapshots": 3, "title": ODD}
    return nrchain.simulate(nrchain.load_scene("buckling", **changes))


def test_texts_of_a_user_are_escaped(run, tmp_path):
    for one in (run.scene, run, run[-1]):
        html = one._repr_html_()
        assert "<script>" not in html
        assert any("<script>alert(1)" in text for text in assert_plain_table(html))


def test_a_scene_shows_every_key_that_is_set(run):
    texts = assert_plain_table(run.scene._repr_html_())
    for name, section in run.scene.to_mapping().items():
        for key in section if isinstance(section, dict) else ():
            assert f"{name}.{key}" in texts
    assert texts[texts.index("slip.2s") + 1] == "100.0"


def test_a_trajectory_shows_how_far_it_came(run):
    texts = assert_plain_table(run._repr_html_())
    assert texts[texts.index("snapshots") + 1] == "3"
    assert texts[texts.index("t") + 1] == "0 to 1"
    assert texts[texts.index("steps") + 1] == str(run.counters["steps"])
    assert "none finished" in run[:0]._repr_html_()


def test_tables_hold_the_rows_of_their_results(run):
    predicted = plan(run.scene)
    texts = assert_plain_table(predicted._repr_html_())
    assert [line.quantity in texts for line in predicted.lines] == [True] * len(predicted.lines)
    wave = nrchain.load_scene("wave", **{"chain.particles": 5})
    spectrum = nrchain.spectrum(wave)
    assert f"{spectrum.leading.growth:.6g}" in assert_plain_table(spectrum._repr_html_())
    found = nrchain.dispersion(wave, [0.01, 0.02])
    largest = found.lattice.real.max()
    assert f"{largest:.6g}" in assert_plain_table(found._repr_html_())


def test_long_tables_are_cut_and_say_so():
    texts = assert_plain_table(table_html("long", ([n] for n in range(MOST_ROWS + 5))))
    assert texts[-1] == "and 5 more"
    assert len(texts) == MOST_ROWS + 2


def test_numbers_have_six_digits_and_arrays_their_shape():
    html = table_html("", [(1 / 3, np.zeros((2, 3)), 1 + 2j, np.float64(0.1))])
    assert assert_plain_table(html) == ["0.333333", "array (2, 3)", "1+2j", "0.1"]
