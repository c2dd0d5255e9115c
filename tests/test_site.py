"""The site of the documentation: each public name has one page, and docstrings keep their text."""

import sys
from collections import Counter
from pathlib import Path

import pytest

import nrchain

DOCS = Path(nrchain.__file__).parents[1] / "docs"


@pytest.fixture(scope="module")
def site_parts():
    sys.path.insert(0, str(DOCS))
    try:
        import site_parts

        yield site_parts
    finally:
        sys.path.remove(str(DOCS))


def test_each_public_name_is_on_one_page_of_the_reference(site_parts):
    pages = [site_parts.rooms_of(page) for page in sorted((DOCS / "reference").glob("*.md"))]
    named = Counter(room for rooms in pages for room in rooms)
    assert set(named.values()) == {1}
    own = {site_parts.room_of(name) for name in nrchain.__all__} & set(named)
    shown = [n for rooms in pages for n in site_parts.names_of(rooms, set(named))]
    assert sorted(shown) == sorted(nrchain.__all__)
    assert own >= {"scene", "run", "states", "theory", "view"}


def test_a_section_of_a_docstring_becomes_terms_and_bars_stay(site_parts):
    lines = [
        "|u| and left*.",
        "",
        "Parameters",
        "----------",
        "scene, x",
        "    The |x| of ``|y|``.",
    ]
    lines += ["", "See :func:`resume`.", ">>> a * b"]
    site_parts.rewrite_docstring(None, "function", "f", None, None, lines)
    assert lines == [
        *(r"\|u\| and left\*.", "", ".. rubric:: Parameters", "", "", "``scene, x``"),
        *(r"    The \|x\| of ``|y|``.", "", "See :func:`resume`.", ">>> a * b"),
    ]


def test_links_to_files_above_docs_lead_to_their_pages(site_parts):
    source = ["[R](../README.md#run-it) [S](scenes.md)"]
    site_parts.show_project_file(None, "running", source)
    assert source == ["[R](project/readme.md#run-it) [S](scenes.md)"]
    source = ["[R](../../CONTRIBUTING.md)"]
    site_parts.show_project_file(None, "howto/modes", source)
    assert source == ["[R](../project/contributing.md)"]
    source = [""]
    site_parts.show_project_file(None, "project/readme", source)
    assert "](../running.md#installation)" in source[0]
    assert "](../../validation/images/buckling.png)" in source[0]
