"""Other values in the text of a YAML file; its comments and everything else stay."""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import yaml

from seater_common.params import ParameterError

Path = tuple[str | int, ...]  # keys of mappings and places in lists, from the outside


def with_values(text: str, values: Mapping[Path, float], name: str, write: Callable[[float], str] | None = None) -> str:
    """The text with these numbers at these paths; `write`: a number's text (`written`).

    Raises:
        ParameterError: naming every key that is not written where it can be replaced; no YAML; aliases forbid it.
    """
    write = write or written
    try:
        root = yaml.compose(text)
    except yaml.YAMLError as error:
        raise ParameterError(f"cannot edit {name}: {error}") from error
    nodes = _nodes(root, values, name)
    edited = text
    places = {nodes[path].end_mark.index: path for path in values}  # aliases share one
    for _, path in sorted(places.items(), reverse=True):
        edited = replaced(edited, nodes[path], write(values[path]))
    if yaml.safe_load(edited) != _with(yaml.safe_load(text), {path: float(write(v)) for path, v in values.items()}):
        raise ParameterError(f"{name}: values cannot be replaced one by one; write each at its place, without aliases")
    return edited


def with_note(text: str, kind: str, note: str) -> str:
    """The text with `kind` and `note` as a comment at its beginning, in the place of an earlier one of this kind."""
    kept = "".join(line for line in text.splitlines(keepends=True) if not line.startswith(kind))
    return f"{kind}{note}\n{kept}"


def written(value: float) -> str:
    """With a decimal point, to a hundredth of a millimetre or milliradian, without idle zeros."""
    digits = f"{round(value, 5) + 0.0:.5f}".rstrip("0")  # no -0.0
    return f"{digits}0" if digits.endswith(".") else digits


def significant(value: float) -> str:
    """With four significant digits and a decimal point: YAML 1.1 takes 1e-05 for a text."""
    digits, e, power = f"{value:.4g}".partition("e")
    return f"{digits}{'' if '.' in digits else '.0'}{e}{power}"


def _nodes(root: yaml.Node | None, paths: Iterable[Path], name: str) -> dict[Path, yaml.ScalarNode]:
    found: dict[Path, yaml.ScalarNode] = {}
    problems = []
    for path in paths:
        node = root
        for part in path:
            node = _entry(node, part)
        if isinstance(node, yaml.ScalarNode):
            found[path] = node
        else:
            problems.append(f"{name}/{'/'.join(map(str, path))}: is not written there, so it cannot be changed")
    if problems:
        raise ParameterError("\n  ".join(problems))
    return found


def _entry(node: yaml.Node | None, part: str | int) -> yaml.Node | None:
    if isinstance(part, int):
        entries = node.value if isinstance(node, yaml.SequenceNode) else []
        return entries[part] if part < len(entries) else None
    pairs = node.value if isinstance(node, yaml.MappingNode) else []
    return next((value for key, value in pairs if key.value == part), None)


def replaced(text: str, node: yaml.ScalarNode, new: str) -> str:
    """The text with a plain scalar of it replaced. A comment behind it stays in its column where there is room."""
    end = node.end_mark.index
    before, after = text[: end - len(node.value)], text[end:]  # an anchor before it stays
    spaces = len(after) - len(after.lstrip(" "))
    if after.lstrip(" ").startswith("#"):
        after = " " * max(1, spaces + len(node.value) - len(new)) + after.lstrip(" ")
    return before + new + after


def _with(values: Any, changes: Mapping[Path, float]) -> Any:
    changed = copy.deepcopy(values)
    for path, value in changes.items():
        place = changed
        for part in path[:-1]:
            place = place[part]
        place[path[-1]] = value
    return changed
