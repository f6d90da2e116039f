"""Table, bar and contact sheet of perception_negatives."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from seater_eval.negatives.evaluate import Seen
from seater_eval.negatives.images import Negative, read_grey
from seater_eval.photographs.contact_sheet import FALSE, place_of_find, tile, write_sheet
from seater_eval.report.bars import Bar
from seater_eval.report.statistics import largest_share
from seater_eval.report.tables import text_table


def negative_bars(data: dict[str, Any]) -> list[Bar]:
    """No find in any image; images that could not be read show nothing."""
    false = float(len(data["false"])) if data["images"] else None
    return [Bar("false finds", false, 0.0, note=f"in {data['images']} images")]


def describe_negatives(data: dict[str, Any]) -> str:
    """A line for each dictionary with what the number of images proves, and one for each find."""
    lines = []
    for row in data["rows"]:
        share = largest_share(min(row["false"], row["images"]), row["images"])
        lines.append([row["dictionary"], str(row["images"]), str(row["false"]), f"1 in {1.0 / share:.0f}"])
    head = ["dictionary", "images", "false finds", "more is refuted (exact binomial, 95 %)"]
    table = f"{text_table(head, lines)}\n\n  {data['images']} images, {data['megapixels']:.0f} megapixels"
    if data["unread"]:
        table += f"; {len(data['unread'])} could not be read or are too small"
    return "\n".join([table, *(f"  {f['image']}: id {f['id']} of {f['dictionary']}" for f in data["false"])])


def draw_negatives(negatives: Sequence[Negative], seen: Sequence[Seen], longest: int, path: Path) -> Path:
    """A tile for each find; an empty sheet when there is none."""
    tiles = []
    for negative, s in zip(negatives, seen, strict=True):
        image = read_grey(negative.path, longest) if any(s.false.values()) else None
        if image is None:
            continue
        for name, found in s.false.items():
            text = f"{negative.path.stem[:10]} {name.removeprefix('DICT_')[:8]}"
            tiles += [tile(image, place_of_find(f), f"{text} {f.id}", FALSE) for f in found]
    return write_sheet(tiles, path)
