"""Table, bars and picture of perception_kinds."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from seater_eval.kinds.cameras import KINDS, photograph
from seater_eval.kinds.evaluate import DICTIONARIES, KindJob, scene
from seater_eval.photographs.detectors import SEATER
from seater_eval.photographs.report import broken_bar, describe_branches
from seater_eval.report.bars import AT_LEAST, Bar
from seater_eval.report.evaluation_style import figure, save
from seater_eval.report.statistics import largest_share
from seater_eval.report.tables import text_table

FREEDOM = 6.0  # degrees of a pose
HONEST = (1.0 / 1.5, 1.5)  # times these, the mean normalised squared error of a cell
OVEREXPOSED = 0.05  # of ideal images' share that is found, fewer
WRONG = 5000.0  # branches called certain, of which one may be wrong
PART = (160, 120)  # [px] of each image that is shown


def _share(rows: list[dict[str, Any]], name: str, of: str = "found") -> float:
    counts = [row["detectors"][name] for row in rows if name in row["detectors"]]
    return sum(c[of] for c in counts) / max(1, sum(c["markers"] for c in counts))


def kind_bars(data: dict[str, Any]) -> list[Bar]:
    """What issue 12 asks for of kinds of cameras: of images without shifts for what is found, of all for the rest."""
    rows = data["rows"]
    sharp = {row["kind"]: [row] for row in rows if row["shift_px"] == 0.0}
    behind: dict[str, float] = {}  # by kind and best other detector, on the dictionaries that it knows
    for kind, mine in sharp.items():
        for name in mine[0]["detectors"]:
            if name != SEATER:
                behind[f"{kind}, {name}"] = _share(mine, name) - _share(mine, name, "found_by_seater")
    fewer = _share(sharp["ideal"], SEATER) - _share(sharp["over-exposed"], SEATER)
    nees = [r["normalised_error_squared"] / FREEDOM for r in rows if r["normalised_error_squared"] is not None]
    certain = sum(row["certain"] for row in rows)
    bars = []
    if not data["ours_only"]:
        worst = max(behind, key=lambda key: behind[key])
        bars.append(Bar("found, fewer than by another detector, worst kind", behind[worst], 0.0, note=worst))
    return [
        *bars,
        Bar("found, over-exposed fewer than ideal", fewer, OVEREXPOSED),
        Bar("false finds", float(sum(row["detectors"][SEATER]["false"] for row in rows)), 0.0),
        Bar("mean normalised error squared / 6, largest cell", max(nees, default=None), HONEST[1]),
        Bar("mean normalised error squared / 6, smallest cell", min(nees, default=None), HONEST[0], "", AT_LEAST),
        Bar(
            "wrong branch called certain",
            float(sum(row["wrong_and_certain"] for row in rows)),
            certain / WRONG,
            note=f"of {certain} certain ones",
        ),
        broken_bar([row["branches"] for row in rows]),
    ]


def describe_kinds(data: dict[str, Any]) -> str:
    """Found and normalised errors of each kind, and branches of all."""
    shifts = sorted({row["shift_px"] for row in data["rows"]})
    names = list(dict.fromkeys(name for row in data["rows"] for name in row["detectors"]))
    lines = []
    for kind in KINDS:
        rows = {row["shift_px"]: row for row in data["rows"] if row["kind"] == kind}
        found = [f"{100.0 * _share([rows[0.0]], name):.1f}" for name in names]
        errors = [rows[shift]["normalised_error_squared"] for shift in shifts]
        lines.append([kind, *found, *("-" if e is None else f"{e / FREEDOM:.2f}" for e in errors)])
    head = ["kind", *(f"{name}, %" for name in names), *(f"NEES / 6, {shift:g} px" for shift in shifts)]
    counted = data["rows"][0]["detectors"][SEATER]["markers"]
    table = f"{text_table(head, lines)}\n\n  {counted} markers of 18 to 60 px a cell; found: without shifts"
    certain, wrong = (sum(row[key] for row in data["rows"]) for key in ("certain", "wrong_and_certain"))
    share = f"more than 1 in {1.0 / largest_share(wrong, certain):.0f} is refuted (exact binomial, 95 %)"
    branches = describe_branches([row["branches"] for row in data["rows"]])
    return f"{table}\n  {wrong} of {certain} branches called certain are wrong: {share}\n{branches}"


def draw_kinds(data: dict[str, Any], path: Path) -> Path:
    """The same scene as each kind of camera delivers it."""
    fig, axes = figure(len(KINDS), width=1.9, height=2.1)
    for axis, kind in zip(axes, KINDS, strict=True):
        prints, random = scene(KindJob(kind, 0.0, DICTIONARIES[0], 40.0, data["seed"], {}))
        axis.imshow(photograph(prints, kind, 0.0, random), cmap="gray", vmin=0, vmax=255, interpolation="nearest")
        axis.set(xlim=(0, PART[0]), ylim=(PART[1], 0), xticks=[], yticks=[])
        row = next(r for r in data["rows"] if r["kind"] == kind and r["shift_px"] == 0.0)
        axis.set_title(f"{kind}\n{100.0 * _share([row], SEATER):.1f} % found", fontsize=8)
    return save(fig, path)
