from collections.abc import Iterator

import pytest
from browser import PROGRAM, Browser


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    if PROGRAM is None:
        pytest.skip("no chromium-headless-shell: ./seater setup installs it")
    with Browser() as running:
        yield running
