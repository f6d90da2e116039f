"""Chair and dock from the files of seater_config."""

from __future__ import annotations

from pathlib import Path
from typing import TypeVar

import yaml

from seater_common.geometry import Chair, Dock
from seater_common.params import ParameterError, load

T = TypeVar("T")


def load_chair(path: str | Path) -> Chair:
    """Raises ParameterError, naming file and key."""
    return _load(Chair, path)


def load_dock(path: str | Path) -> Dock:
    """Raises ParameterError, naming file and key."""
    return _load(Dock, path)


def _load(cls: type[T], path: str | Path) -> T:
    try:
        values = yaml.safe_load(Path(path).read_text())
    except (OSError, yaml.YAMLError) as error:
        raise ParameterError(f"cannot read {path}: {error}") from error
    return load(cls, values, str(path))
