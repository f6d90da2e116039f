"""Images without markers through perception as shipped, dictionary by dictionary."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from seater_eval.negatives.images import Image, Negative, read_grey
from seater_eval.perception import subject
from seater_eval.photographs.detectors import SEATER, Found, make_detector
from seater_eval.photographs.truth import Photograph, PhotographFolder
from seater_eval.run.long_run import run_long


@dataclass(frozen=True)
class NegativeJob:
    """One image. `longest`: px that it is averaged down to."""

    negative: Negative
    longest: int
    parameters: dict[str, Any]


@dataclass(frozen=True)
class Seen:
    """What came of one image: `false` by dictionary; `size` (width, height) [px], None: it could not be read."""

    size: tuple[int, int] | None
    false: dict[str, list[Found]]


def look(job: NegativeJob) -> Seen:
    """All dictionaries that the image does not show."""
    image = read_grey(job.negative.path, job.longest)
    if image is None:
        return Seen(size=None, false={})
    height, width = image.shape
    false = {name: finds(image, name, job.parameters) for name in job.negative.dictionaries}
    return Seen(size=(width, height), false=false)


def finds(image: Image, dictionary: str, parameters: dict[str, Any]) -> list[Found]:
    """By the whole detector, all ids of the dictionary; its camera is one of 53 deg across, as no other is known."""
    height, width = image.shape
    K = np.array([[width, 0.0, 0.5 * (width - 1)], [0.0, width, 0.5 * (height - 1)], [0.0, 0.0, 1.0]])
    photograph = Photograph(path=Path(dictionary), width=width, height=height, K=K, D=np.zeros(5), markers=())
    folder = PhotographFolder(name=dictionary, dictionary=dictionary, photographs=(photograph,))
    return make_detector(SEATER, folder, photograph, parameters)(image).found


def run_negatives(
    negatives: Sequence[Negative],
    parameters: dict[str, Any],
    longest: int,
    workers: int | None = None,
    partial: Path | None = None,
) -> tuple[list[Seen], dict[str, Any]]:
    """What was seen in each image, and the results: a row for each dictionary, every find, and what could not be read.
    Raises ParameterError."""
    finds(np.zeros((64, 64), np.uint8), "DICT_4X4_50", parameters)  # wrong parameters: now
    jobs = [NegativeJob(negative, longest, parameters) for negative in negatives]
    files = [*subject.library_files(), *(n.path for n in negatives)]
    seen = run_long(look, jobs, label="perception_negatives", files=files, partial=partial, workers=workers)
    names = list(dict.fromkeys(name for n in negatives for name in n.dictionaries))
    false = [
        {"image": str(n.path), "dictionary": name, "id": f.id, "corners": f.corners, "ambiguity": f.ambiguity}
        for n, s in zip(negatives, seen, strict=True)
        for name, found in s.false.items()
        for f in found
    ]
    sizes = [s.size for s in seen if s.size is not None]
    return seen, {
        "longest_px": longest,
        "images": len(sizes),
        "megapixels": sum(w * h for w, h in sizes) / 1e6,
        "unread": [str(n.path) for n, s in zip(negatives, seen, strict=True) if s.size is None],
        "rows": [_row(name, seen) for name in names],
        "false": false,
    }


def _row(dictionary: str, seen: Sequence[Seen]) -> dict[str, Any]:
    mine = [s.false[dictionary] for s in seen if dictionary in s.false]
    return {"dictionary": dictionary, "images": len(mine), "false": sum(len(found) for found in mine)}
