"""Everything that an identification leaves behind, in one folder."""

from __future__ import annotations

import dataclasses
import datetime
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from seater_common.geometry import Chair
from seater_identify.record.recording import Recording
from seater_identify.report.figures import draw_all
from seater_identify.report.files import CONTROLLER, chair_values, controller_values, write_copy
from seater_identify.report.table import write_json
from seater_identify.result.identify import Identification


@dataclass(frozen=True)
class Sources:
    """The files that copies are made of."""

    controller: Path
    chair: Path


def copies(folder: Path) -> dict[str, Path]:
    """Role to the copy that `write_folder` writes."""
    return {"chair": folder / "chair.yaml", "controller": folder / "controller.yaml"}


def write_folder(
    result: Identification, recording: Recording, chair: Chair, sources: Sources, folder: Path, note: str
) -> Sequence[Path]:
    """The files written. `note`: what was recorded, for the first line of the new controller.yaml.

    Raises ParameterError, after all else is written, when controller.yaml lacks a key.
    """
    folder.mkdir(parents=True, exist_ok=True)
    files = [write_json(result, folder / "identification.json"), *draw_all(result, recording, folder)]
    limits = dataclasses.asdict(chair.limits)
    new = copies(folder)
    files.append(write_copy(sources.chair, new["chair"], chair_values(result, limits)))
    values = controller_values(result)
    refused = [name for name in CONTROLLER if not result[name].usable]
    kept = f"; not shown, as before: {', '.join(refused)}" if refused else ""
    files.append(write_copy(sources.controller, new["controller"], values, f"{datetime.date.today()}, {note}{kept}"))
    return files
