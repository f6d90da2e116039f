"""From a recorded docking to summary.json, trajectory.png and the table."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from seater_common.geometry import Chair, Dock
from seater_eval.docking.dock_figure import draw_docking
from seater_eval.docking.recording import read_recording
from seater_eval.docking.summary import summarize, table


def write_report(
    bag: Path,
    dock: Dock,
    chair: Chair,
    results: Path,
    files: Mapping[str, Path] | None = None,
    plant: str | None = None,
) -> dict[str, Any]:
    """Writes summary.json and trajectory.png into `results` and returns the summary; `files` and `plant` (the kind
    of chair that was simulated): what the run was made with, where that is known.

    Raises RecordingError when the bag cannot serve.
    """
    recording = read_recording(bag)
    summary = summarize(recording, dock, chair)
    if plant is not None:
        summary["plant"] = plant
    if files is not None:
        summary["files"] = {name: str(path) for name, path in files.items()}
    results.mkdir(parents=True, exist_ok=True)
    (results / "summary.json").write_text(json.dumps(summary, indent=2) + "\n")
    draw_docking(recording, summary, dock, chair, results / "trajectory.png")
    return summary


def describe(summary: dict[str, Any], files: list[Path]) -> str:
    """The table and where the files are."""
    return "\n".join(["", table(summary), "", *(f"  {file}" for file in files), ""])
