"""The estimates as a table for a person and as JSON."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

from tabulate import tabulate

from seater_identify.result.identify import Identification


def describe(result: Identification) -> str:
    """The table."""
    rows = []
    for e in result.estimates.values():
        value = "" if math.isnan(e.value) else f"{e.value:.4f}"
        sd = "" if math.isnan(e.sd) else f"{e.sd:.4f}"
        rows.append([e.name, value, sd, e.unit, e.quality.value, e.text])
    head = ["what", "value", "sd", "unit", "quality", ""]
    return str(tabulate(rows, head, tablefmt="simple", disable_numparse=True, colalign=("left", "right", "right")))


def as_mapping(result: Identification) -> dict[str, Any]:
    """For JSON: null where there is no number."""
    return {
        e.name: {"value": _number(e.value), "sd": _number(e.sd), "unit": e.unit, "quality": e.quality.value,
                 "text": e.text}
        for e in result.estimates.values()
    }  # fmt: skip


def write_json(result: Identification, path: Path) -> Path:
    """The estimates by name."""
    path.write_text(json.dumps(as_mapping(result), indent=2, allow_nan=False) + "\n")
    return path


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None
