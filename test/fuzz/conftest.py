"""A ROS master of its own on a free port for the tests with the gate's node, and that node's surroundings."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "src" / "seater_safety" / "test" / "node"))
sys.path.append(str(Path(__file__).resolve().parents[2] / "src" / "seater_nmpc" / "test"))
from own_master import own_master  # isort: skip  # before rospy
from driver import Driver, end_gates
from shared_programmes import share

share()


@pytest.fixture(scope="session")
def driver() -> Iterator[Driver]:
    """A node in this process that drives the gate; the master ends with it."""
    with own_master():
        try:
            yield Driver()
        finally:
            end_gates()
