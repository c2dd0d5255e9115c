"""A library that is not installed is an error that says what to install."""

import pytest

from nrchain.errors import MissingLibraryError
from nrchain.inputs.optional import optional


def test_a_missing_library_names_its_extra():
    with pytest.raises(MissingLibraryError) as error:
        optional("no_such_library.part", "exchange", "a GSD file")
    assert str(error.value).startswith(
        "a GSD file needs no_such_library: pip install 'nrchain[exchange]'"
    )


def test_a_library_that_is_there_is_returned():
    assert optional("json", "exchange", "text").loads("1") == 1
