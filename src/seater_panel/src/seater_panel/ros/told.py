"""Which chair and dock it is about: those that the docking node was told, unless files are given."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import rospkg
import rospy

from seater_common.geometry import Chair, Dock
from seater_common.params import load, read_yaml


def told(docking: str, chair_file: Path | None, dock_file: Path | None) -> tuple[Chair, Dock]:
    """`docking`: name of the docking node. Without it and without files: those of seater_config.

    Raises:
        ParameterError: a file or a parameter of the node is wrong.
    """
    config = Path(rospkg.RosPack().get_path("seater_config"))
    chair = _values(f"{docking}/chair", chair_file, config / "chair.yaml")
    dock = _values(f"{docking}/dock", dock_file, config / "docks" / "default.yaml")
    return load(Chair, chair[0], chair[1]), load(Dock, dock[0], dock[1])


def _values(parameter: str, file: Path | None, default: Path) -> tuple[Any, str]:
    """The nested mapping, and where it is from."""
    name = rospy.resolve_name(parameter)
    values = rospy.get_param(name, None) if file is None else None
    if values is not None:
        return values, name
    return read_yaml(file or default), str(file or default)
