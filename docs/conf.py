"""Sphinx settings of the site: ``python -m sphinx -W --keep-going docs build/site`` makes it."""

from __future__ import annotations

import sys
from pathlib import Path

import nrchain

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "docs"))

project = "nrchain"
author = "The nrchain developers"
version = release = nrchain.__version__

extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx_design", "site_parts"]
html_theme = "furo"
html_title = f"nrchain {version}"
html_copy_source = False

myst_enable_extensions = ["colon_fence", "dollarmath"]
myst_heading_anchors = 3

# a notebook whose text did not change takes its results from the cache
nb_execution_mode = "cache"
nb_execution_cache_path = str(ROOT / "build" / "notebooks")
nb_execution_timeout = 120
nb_execution_raise_on_error = True
nb_execution_in_temp = True

autodoc_member_order = "bysource"
autodoc_typehints_format = "short"
