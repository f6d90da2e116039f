"""Everything that an identification leaves behind, in one folder."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from seater_common.geometry import Chair
from seater_identify.record.recording import Recording
from seater_identify.report.figures import draw_all
from seater_identify.report.files import KeyPathError, chair_values, controller_values, write_copy
from seater_identify.report.table import write_json
from seater_identify.result.identify import Identification


@dataclass(frozen=True)
class Sources:
    """The files that copies are made of."""

    controller: Path
    chair: Path


def write_folder(
    result: Identification, recording: Recording, chair: Chair, sources: Sources, folder: Path
) -> Sequence[Path]:
    """The files written. Raises KeyPathError, after all else is written, when controller.yaml lacks a key."""
    folder.mkdir(parents=True, exist_ok=True)
    files = [write_json(result, folder / "identification.json"), *draw_all(result, recording, folder)]
    limits = dataclasses.asdict(chair.limits)
    files.append(write_copy(sources.chair, folder / "chair.yaml", chair_values(result, limits)))
    files.append(write_copy(sources.controller, folder / "controller.yaml", controller_values(result)))
    return files


__all__ = ["KeyPathError", "Sources", "write_folder"]
