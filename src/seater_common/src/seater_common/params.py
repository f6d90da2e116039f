"""Typed parameters: one dataclass per component holds default, unit, range and meaning of each value in one place.

    @dataclass(frozen=True)
    class Limits:
        v_max: float = param(0.6, "m/s", "largest forward speed", low=0.0, high=3.0)

    limits = load(Limits, rospy.get_param("~limits"), "limits")

`load` takes the nested mapping that YAML or the parameter server gives. It is strict: every key has to be there, an
unknown key is an error (it is most often a misspelt one), so nothing is silently defaulted. All problems are reported
at once, each with the full key, the value and what is allowed. Fields of a nested dataclass type, lists of dataclasses
and lists of numbers work too. Defaults serve programs and tests that make the dataclass themselves.
"""

from __future__ import annotations

import dataclasses
import math
import types
import typing
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

import yaml

T = TypeVar("T")


class ParameterError(ValueError):
    """One or several parameters are missing, unknown, of the wrong type or out of range."""


def param(
    default: Any,
    unit: str,
    doc: str,
    *,
    low: float | None = None,
    high: float | None = None,
    choices: Sequence[Any] | None = None,
    length: int | None = None,
) -> Any:
    """A dataclass field with unit, meaning and what is allowed (bounds are inclusive and hold for each list entry)."""
    metadata = {"unit": unit, "doc": doc, "low": low, "high": high, "choices": choices, "length": length}
    if isinstance(default, list | dict):
        return dataclasses.field(default_factory=lambda: type(default)(default), metadata=metadata)
    return dataclasses.field(default=default, metadata=metadata)


class _Loader(yaml.SafeLoader):
    """Knows OpenCV's matrices."""


_Loader.add_constructor("tag:yaml.org,2002:opencv-matrix", lambda loader, node: loader.construct_mapping(node, True))


def read_yaml(path: str | Path) -> Any:
    """What a YAML file holds; also one that OpenCV's FileStorage has written.

    Raises:
        ParameterError: naming the file, which cannot be read.
    """
    try:
        text = Path(path).read_text()
        if text.startswith("%YAML:"):  # OpenCV's first line, which is no YAML
            text = text.partition("\n")[2]
        return yaml.load(text, _Loader)
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise ParameterError(f"cannot read {path}: {why(error)}") from error


def load_file(cls: type[T], path: str | Path) -> T:
    """`load` of what a YAML file holds. Raises ParameterError, naming file and key."""
    return load(cls, read_yaml(path), str(path))


def why(error: Exception) -> str:
    """Of a file that cannot be read: in one line, without its name, which the caller says."""
    if isinstance(error, OSError):
        return str(error.strerror or error).lower()
    if isinstance(error, UnicodeDecodeError):
        return "is no text"
    mark = getattr(error, "problem_mark", None)
    if mark is None:
        return " ".join(str(error).split())
    return f"line {mark.line + 1}, column {mark.column + 1}: {getattr(error, 'problem', error)}"


def load(cls: type[T], values: Any, prefix: str) -> T:
    """An instance of the dataclass `cls` from a nested mapping; `prefix` names it in messages.

    Raises:
        ParameterError: naming every key that is missing, unknown, of the wrong type or out of range.
    """
    problems: list[str] = []
    result = _load_dataclass(cls, values, prefix, problems)
    if problems:
        raise ParameterError("wrong parameters:\n  " + "\n  ".join(problems))
    return typing.cast(T, result)


def as_mapping(instance: Any) -> dict[str, Any]:
    """The nested mapping that `load` takes, of a parameter dataclass."""
    return dataclasses.asdict(instance)


def _load_dataclass(cls: type, values: Any, prefix: str, problems: list[str]) -> Any:
    if not isinstance(values, Mapping):
        shown = "empty" if values is None else f"{values!r:.60}"
        keys = ", ".join(sorted(f.name for f in dataclasses.fields(cls) if f.init))
        problems.append(f"{prefix}: is {shown}, must be a mapping with the keys {keys}")
        return None
    hints = typing.get_type_hints(cls)
    fields = {f.name: f for f in dataclasses.fields(cls) if f.init}
    for key in values:
        if key not in fields:
            problems.append(f"{prefix}/{key}: unknown key; known are {', '.join(sorted(fields))}")
    found: dict[str, Any] = {}
    before = len(problems)
    for name, field in fields.items():
        key = f"{prefix}/{name}"
        if name not in values:
            unit = f"[{field.metadata['unit']}]" if field.metadata.get("unit") else ""
            meaning = " ".join(part for part in (field.metadata.get("doc"), unit) if part)
            problems.append(f"{key}: is missing" + (f" ({meaning})" if meaning else ""))
            continue
        found[name] = _convert(hints[name], values[name], key, field.metadata, problems)
    if len(problems) > before:
        return None
    try:
        return cls(**found)
    except ValueError as error:  # checks across several fields, in __post_init__
        problems.append(f"{prefix}: {error}")
        return None


def _convert(hint: Any, value: Any, key: str, meta: Mapping[str, Any], problems: list[str]) -> Any:
    origin = typing.get_origin(hint)
    if origin in (typing.Union, types.UnionType):
        options = typing.get_args(hint)
        if value is None and type(None) in options:
            return None
        hint = next(option for option in options if option is not type(None))
        origin = typing.get_origin(hint)
    if dataclasses.is_dataclass(hint):
        return _load_dataclass(typing.cast(type, hint), value, key, problems)
    if origin in (list, tuple):
        if not isinstance(value, list | tuple):
            problems.append(f"{key}: is {value!r}, must be a list")
            return None
        length = meta.get("length")
        if length is not None and len(value) != length:
            problems.append(f"{key}: has {len(value)} entries, must have {length}")
            return None
        entry = typing.get_args(hint)[0]
        return origin(
            _convert(entry, v, f"{key}[{i}]", {**meta, "length": None}, problems) for i, v in enumerate(value)
        )
    return _convert_scalar(hint, value, key, meta, problems)


def _convert_scalar(hint: Any, value: Any, key: str, meta: Mapping[str, Any], problems: list[str]) -> Any:
    wrong_type = f"{key}: is {value!r}, must be of type {getattr(hint, '__name__', hint)}"
    if hint is float:
        if isinstance(value, bool) or not isinstance(value, int | float):
            problems.append(wrong_type)
            return None
        value = float(value)
        if not math.isfinite(value):
            problems.append(f"{key}: is {value!r}, must be finite")
            return None
    elif hint is int:
        if isinstance(value, bool) or not isinstance(value, int):
            problems.append(wrong_type)
            return None
    elif not isinstance(value, hint):
        problems.append(wrong_type)
        return None
    _check_range(value, key, meta, problems)
    return value


def _check_range(value: Any, key: str, meta: Mapping[str, Any], problems: list[str]) -> None:
    unit = f" [{meta['unit']}]" if meta.get("unit") else ""
    low, high, choices = meta.get("low"), meta.get("high"), meta.get("choices")
    if low is not None and value < low:
        problems.append(f"{key}: is {value!r}, must be >= {low}{unit}")
    if high is not None and value > high:
        problems.append(f"{key}: is {value!r}, must be <= {high}{unit}")
    if choices is not None and value not in choices:
        problems.append(f"{key}: is {value!r}, must be one of {', '.join(map(str, choices))}")
