"""Other sizes in the text of a dock file; its comments and everything else stay."""

from __future__ import annotations

import copy
from typing import Any

import yaml

from seater_common.files.scalars import replaced, written
from seater_common.params import ParameterError

CORRECTED = "# Sizes of the markers as printed: "  # how the first line of a copy begins


def with_printed_sizes(text: str, scale: float, name: str, note: str) -> str:
    """The text with each markers[i]/size times `scale`, and a first line that says so (`note`).

    Raises:
        ParameterError: it was corrected before, or a size is not written where it can be replaced.
    """
    refuse_corrected(text, name)
    edited = text
    for node in sorted(_size_nodes(text, name), key=lambda node: -int(node.end_mark.index)):
        edited = replaced(edited, node, written(yaml.safe_load(node.value) * scale))
    _check(text, edited, scale, name)
    return f"{CORRECTED}{note}\n{edited}"


def refuse_corrected(text: str, name: str) -> None:
    """A correction of the correction, or a print at the corrected size, would be wrong without anybody noticing.

    Raises:
        ParameterError: this is a copy with corrected sizes.
    """
    if text.startswith(CORRECTED):
        raise ParameterError(
            f"{name}: its sizes are corrected for a print (first line); give the file it was made from"
        )


def _size_nodes(text: str, name: str) -> list[yaml.ScalarNode]:
    """Each once, also where aliases share one."""
    nodes: dict[int, yaml.ScalarNode] = {}
    try:
        root = yaml.compose(text)
    except yaml.YAMLError as error:
        raise ParameterError(f"cannot edit {name}: {error}") from error
    for i, marker in enumerate(_value(root, "markers", name).value):
        node = _value(marker, "size", f"{name}/markers[{i}]")
        nodes[node.end_mark.index] = node
    return list(nodes.values())


def _value(mapping: yaml.Node | None, key: str, name: str) -> Any:
    pairs = mapping.value if isinstance(mapping, yaml.MappingNode) else []
    for known, value in pairs:
        if known.value == key:
            return value
    raise ParameterError(f"{name}/{key}: is not written there, so it cannot be corrected")


def _check(text: str, edited: str, scale: float, name: str) -> None:
    """The sizes are new and nothing else, whatever YAML's syntax made of the text. Raises ParameterError."""
    wanted = copy.deepcopy(yaml.safe_load(text))
    for marker in wanted["markers"]:
        marker["size"] = float(written(marker["size"] * scale))
    if yaml.safe_load(edited) != wanted:
        raise ParameterError(f"{name}/markers: sizes cannot be replaced one by one; write `size: 0.1` at each marker")
