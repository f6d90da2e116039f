"""The ROS master, before a program waits for it in silence."""

from __future__ import annotations

import rosgraph

from seater_common.params import ParameterError


def require_master(what: str) -> None:
    """Raises ParameterError where no master answers; `what` has to be started then."""
    if not rosgraph.is_master_online():
        raise ParameterError(f"no ROS master answers at {rosgraph.get_master_uri()}: start {what} first")
