"""Tables of mode PAPER take seconds to build: all tests of the core keep them in one folder."""

import pytest


@pytest.fixture(scope="session")
def table_dir(tmp_path_factory) -> str:
    """A cache folder that lives as long as the session."""
    return str(tmp_path_factory.mktemp("tables"))
