"""Settings from files."""

from __future__ import annotations

from pathlib import Path
from typing import TypeVar

import yaml

from seater_common.params import ParameterError, load

T = TypeVar("T")


def load_file(cls: type[T], path: str | Path) -> T:
    """A parameter dataclass from a YAML file. Raises ParameterError, naming file and key."""
    try:
        values = yaml.safe_load(Path(path).read_text())
    except (OSError, yaml.YAMLError) as error:
        raise ParameterError(f"cannot read {path}: {error}") from error
    return load(cls, values, str(path))
