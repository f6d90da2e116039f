"""Table, bars and figure of a campaign of installations."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from seater_eval.report.bars import AT_LEAST, Bar
from seater_eval.report.evaluation_style import figure, save
from seater_eval.report.tables import text_table
from seater_tools.commissioning.dockings import BAR
from seater_tools.commissioning.steps import LIMIT, STEPS

Row = Mapping[str, Any]
SHARE = 29.0 / 30.0


def bars(rows: Sequence[Row]) -> list[Bar]:
    """Those of the campaign. Silent: a docking that calls itself one, and is not."""
    docked = sum(row["docked"] for row in rows) / len(rows)
    silent = sum(d["result"] == "SUCCESS" and not d["docked"] for row in rows for d in row["dockings"])
    longest = max(row["minutes"] for row in rows)
    return [
        Bar("installations whose dockings all end at the taught pose", docked, SHARE, sense=AT_LEAST),
        Bar("dockings that end elsewhere and do not say so", float(silent), 0.0),
        Bar("longest installation, people and driving", longest, LIMIT, "min"),
    ]


def table(rows: Sequence[Row]) -> str:
    """An installation a line; lengths in mm, angles of the mount in mrad, headings in deg, times in minutes."""
    head = ["seed", "chair", "f %", "mount mm", "mrad", "marker mm", "size %", "docked mm", "deg", "min", "end"]
    return text_table(head, [_line(row) for row in rows], "ll" + "r" * 8 + "l")


def _line(row: Row) -> list[str]:
    errors, dockings = row["errors"], row["dockings"]
    found = ["-"] * 5
    if errors:
        mount = errors["mount"]
        found = [
            f"{100 * errors['lens']['focal']:.3f}",
            f"{1000 * math.hypot(mount['x'], mount['y']):.1f}",
            f"{1000 * max(abs(mount[angle]) for angle in ('roll', 'pitch', 'yaw')):.2f}",
            f"{1000 * errors['dock']['marker']:.1f}",
            f"{100 * errors['dock']['size']:.2f}",
        ]
    off = " ".join(f"{1000 * math.hypot(*d['off'][:2]):.1f}" for d in dockings)
    heading = " ".join(f"{math.degrees(d['off'][2]):.2f}" for d in dockings)
    return [str(row["seed"]), row["plant"], *found, off, heading, f"{row['minutes']:.0f}", end_of(row)]


def end_of(row: Row) -> str:
    """How it ended, and what the commands had to say on the way."""
    if row["failed"] is not None:
        return f"{row['failed']}: {row['why'].strip().rpartition(chr(10))[2]}"
    bad = [f"{d['result']}: {d['text']}" for d in row["dockings"] if not d["docked"]]
    notes = [f"({step}: {note})" for step, note in row["notes"].items()]
    return " ".join([*(bad or ["docked"]), *notes])


def draw(rows: Sequence[Row], path: Path) -> Path:
    """Where the docked chairs stand, and how long each step takes."""
    fig, (where, times) = figure(2, width=6.0)
    off = np.array([d["off"] for row in rows for d in row["dockings"]]).reshape(-1, 3)
    angle = np.linspace(0.0, 2.0 * math.pi, 100)
    where.plot(1000 * BAR[0] * np.cos(angle), 1000 * BAR[0] * np.sin(angle), "k--", linewidth=1.0)
    seen = where.scatter(1000 * off[:, 0], 1000 * off[:, 1], c=np.degrees(off[:, 2]), cmap="coolwarm", vmin=-1, vmax=1)
    fig.colorbar(seen, ax=where, label="heading [deg]")
    where.set(xlabel="ahead of the taught pose [mm]", ylabel="left of it [mm]", aspect="equal")
    where.set_title(f"{len(off)} dockings of {len(rows)} installations")
    driven = [np.array([row["driving_s"].get(step.name, 0.0) / 60.0 for row in rows]) for step in STEPS]
    names = [step.name for step in STEPS]
    times.barh(names, [step.minutes for step in STEPS], color="#8a8f98", label="people, estimated")
    times.barh(
        names,
        [float(values.mean()) for values in driven],
        left=[step.minutes for step in STEPS],
        color="#2e9e4f",
        label="driving, simulated (mean)",
    )
    times.invert_yaxis()
    times.set(xlabel="minutes", title=f"{np.mean([row['minutes'] for row in rows]):.0f} min of {LIMIT:g}")
    times.legend()
    return save(fig, path)
