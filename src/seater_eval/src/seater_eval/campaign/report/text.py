"""The campaign for the screen."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from seater_eval.report.tables import text_table

_SHOWN = 12  # results and influences


def describe(data: Mapping[str, Any]) -> str:
    """Results, distributions, the clearest influences."""
    s = data["summary"]
    low, high = s["docked_interval"]
    clearance = s["smallest_clearance_mm"]
    lines = [
        f"  {s['docked']} of {s['runs']} docked ({100 * low:.1f} .. {100 * high:.1f} %), {s['touched']} touched, "
        f"{s['moving_at_the_end']} moving at the end, {s['retried']} retried, smallest clearance "
        + ("-" if clearance is None else f"{clearance:.0f} mm"),
        "",
        text_table(
            ["runs", "result", "text"],
            [[str(r["runs"]), r["result"], r["text"][:80]] for r in s["results"][:_SHOWN]],
            "rll",
        ),
        "",
        text_table(["docked runs", *_LEVELS], [_spread_row(name, values) for name, values in s["of_docked"].items()]),
        "",
        text_table(["clearest influences", "value", "docked"], _influence_rows(s), "llr"),
    ]
    if s["realtime_factor"] is not None:
        shares = ", ".join(f"{part} {100 * share:.0f} %" for part, share in s["share_of_time"].items())
        lines += ["", f"  {s['realtime_factor']:.2f} times real time on one core: {shares}"]
    return "\n".join(lines)


_LEVELS = ("median", "p95", "p99", "max")


def _spread_row(name: str, values: Mapping[str, float | None]) -> list[str]:
    numbers = [values[level] for level in _LEVELS]
    return [name, *("-" if number is None else f"{number:.3f}" for number in numbers)]


def _influence_rows(summary: Mapping[str, Any]) -> list[list[str]]:
    rows = []
    for influence in summary["influences"]:
        for i, group in enumerate(influence["groups"]):
            rows.append(["" if i else influence["parameter"], group["value"], f"{group['docked']} of {group['runs']}"])
    return rows[:_SHOWN]
