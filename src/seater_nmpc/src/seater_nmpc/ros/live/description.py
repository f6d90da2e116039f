"""What dynamic_reconfigure wants to know of parameters, made of those that are offered."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any

from seater_nmpc.live.offered import Offered

ANSWER = "answer"  # a text beside the parameters: why the last change was refused
_KINDS = {float: "double", int: "int", str: "str"}


class Description:
    """In the place of the module that dynamic_reconfigure generates from a .cfg file."""

    def __init__(self, offered: Sequence[Offered]) -> None:
        answer = _parameter(ANSWER, "why the last change was refused; empty: it was made", "", "", "")
        groups = [
            _group(number, name, [_parameter(o.name, o.doc, o.default, o.low, o.high) for o in members])
            for number, (name, members) in enumerate(itertools.groupby(offered, lambda o: o.group), start=1)
        ]
        self.config_description = {**_group(0, "Default", [answer]), "groups": groups}
        every = [answer, *(p for group in groups for p in group["parameters"])]
        self.min, self.max, self.defaults, self.level = (
            {p["name"]: p[key] for p in every} for key in ("min", "max", "default", "level")
        )


def _group(number: int, name: str, parameters: list[dict[str, Any]]) -> dict[str, Any]:
    return {
        "id": number,
        "parent": 0,
        "name": name,
        "type": "",
        "state": True,
        "groups": [],
        "parameters": parameters,
    }


def _parameter(name: str, text: str, default: Any, low: Any, high: Any) -> dict[str, Any]:
    return {
        "name": name,
        "type": _KINDS[type(default)],
        "description": text,
        "default": default,
        "min": low,
        "max": high,
        "level": 1,
        "edit_method": "",
    }
