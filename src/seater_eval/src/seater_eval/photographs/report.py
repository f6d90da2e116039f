"""Table and bars of perception_photographs."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from seater_eval.peers.catalogue import PEERS
from seater_eval.photographs.detectors import OPENCV, PLAIN, SEATER
from seater_eval.report.bars import AT_LEAST, Bar
from seater_eval.report.tables import text_table

RECALL, RECALL_OF_A_FOLDER = 0.97, 0.95
CORNER_MEDIAN, CORNER_P99 = 0.20, 0.80  # [px]
NEES = 1.5  # of the degrees of freedom, mean
TIMES_PLAIN = 0.8  # of plain OpenCV's time
FEWEST_SHARED = 20  # markers of a board that two detectors are compared on


def rows_of(data: dict[str, Any], detector: str) -> list[dict[str, Any]]:
    return [row for row in data["rows"] if row["detector"] == detector]


def recall(rows: Iterable[dict[str, Any]]) -> float | None:
    """Of all rows together."""
    rows = list(rows)
    markers = sum(row["markers"] for row in rows)
    return sum(row["found"] for row in rows) / markers if markers else None


def photograph_bars(data: dict[str, Any]) -> list[Bar]:
    """What issue 12 asks for of the photographs."""
    ours, peers = rows_of(data, SEATER), rows_of(data, OPENCV)
    behind = [(recall([peer]) or 0.0) - (recall([own]) or 0.0) for own, peer in zip(ours, peers, strict=True)]
    boards = [row for row in ours if row["on_board"]]
    bars = [
        Bar("recall, all folders", recall(ours), RECALL, "", AT_LEAST),
        Bar(
            "recall, worst folder",
            min((recall([r]) or 0.0 for r in ours), default=None),
            RECALL_OF_A_FOLDER,
            "",
            AT_LEAST,
        ),
        Bar("recall behind OpenCV's, worst folder", max(behind, default=None), 0.0),
        Bar("false finds", float(sum(row["false"] for row in ours)), 0.0),
    ]
    for row in boards:
        bars += [*board_bars(row), *peer_bars(data, row["folder"])]
    bars += [time_bar(data, row) for row in ours]
    certain = sum(row["certain"] for row in boards)
    wrong = float(sum(row["wrong_and_certain"] for row in boards)) if boards else None
    bars.append(Bar("wrong branch called certain", wrong, certain / 5000.0, note=f"of {certain} certain ones"))
    return [*bars, broken_bar([row["branches"] for row in boards if "branches" in row])]


def broken_bar(counts: list[dict[str, int]]) -> Bar:
    """Of `counts` by count_broken; nothing that corners have decided shows nothing."""
    decided, broken, open_ = (sum(c[key] for c in counts) for key in ("corners_decided", "broken", "open"))
    note = f"of {decided} that corners had right with certainty; {open_} more are open, the other pose first"
    return Bar("branches that the photometric stage breaks", float(broken) if decided else None, 0.0, note=note)


def board_bars(row: dict[str, Any]) -> list[Bar]:
    """Corners and certainty of one folder with a board."""
    name = row["folder"]
    nees = row["nees"]["mean"]
    return [
        Bar(f"{name}: corner error, median", row["corner_px"]["median"], CORNER_MEDIAN, "px"),
        Bar(f"{name}: corner error, p99", row["corner_px"]["p99"], CORNER_P99, "px"),
        Bar(f"{name}: normalised error squared, mean / 6", None if nees is None else nees / 6.0, NEES),
    ]


def peer_bars(data: dict[str, Any], folder: str) -> list[Bar]:
    """Corners beside the best peer's, each on the markers that both have a truth for; none without peers."""
    rows = [r for r in data["rows"] if r["folder"] == folder and r["detector"] in PEERS]
    rows = [r for r in rows if r["shared"]["markers"] >= FEWEST_SHARED]
    if not rows:
        return []
    bars = []
    for measure in ("median", "p99"):
        ratios = {r["detector"]: r["shared"]["ours"][measure] / r["shared"]["theirs"][measure] for r in rows}
        best = max(ratios, key=lambda name: ratios[name])
        bars.append(Bar(f"{folder}: corner error, {measure} / best peer's", ratios[best], 1.0, note=best))
    return bars


def time_bar(data: dict[str, Any], ours: dict[str, Any]) -> Bar:
    """The whole search, poses included, over OpenCV's detection alone."""
    plain = next((r for r in rows_of(data, PLAIN) if r["folder"] == ours["folder"]), None)
    ratio = None if plain is None else ours["milliseconds"]["median"] / plain["milliseconds"]["median"]
    return Bar(f"{ours['folder']}: time / plain OpenCV's", ratio, TIMES_PLAIN)


def describe_photographs(data: dict[str, Any]) -> str:
    """One line for each folder and detector, and one for each detector over all."""
    head = [
        "folder",
        "detector",
        "found",
        "false",
        "unlisted",
        "corner px",
        "p99",
        "inwards",
        "wrong+certain",
        "NEES",
        "median",
        "ms",
        "stages",
    ]
    rows = [[row["folder"], row["detector"], *_line(row)] for row in data["rows"]]
    for detector in dict.fromkeys(row["detector"] for row in data["rows"]):
        own = rows_of(data, detector)
        found, markers = (sum(r[key] for r in own) for key in ("found", "markers"))
        counts = [str(sum(r[key] for r in own)) for key in ("false", "unlisted")]
        rows.append(["all", detector, f"{found}/{markers} {_share(found, markers)}", *counts])
    table = text_table(head, [row + [""] * (len(head) - len(row)) for row in rows], "ll" + "r" * 10 + "l")
    return f"{table}\n\n{describe_branches([row['branches'] for row in data['rows'] if 'branches' in row])}"


def describe_branches(counts: list[dict[str, int]]) -> str:
    """One line, of `counts` by count_broken."""
    keys = ("corners_decided", "broken", "open", "corners_wrong", "mended")
    decided, broken, open_, wrong, mended = (sum(c[key] for c in counts) for key in keys)
    return (
        f"  corners alone call {decided} branches certain rightly: poses as shipped break {broken}, leave {open_} open"
        f" with the other pose first\n  and {wrong} wrongly: poses as shipped mend {mended}"
    )


def _line(row: dict[str, Any]) -> list[str]:
    numbers = [row["corner_px"]["median"], row["corner_px"]["p99"], row["inwards_px"]]
    wrong = f"{row['wrong_and_certain']}/{row['certain']}" if row["on_board"] else "-"
    rest = [row["nees"]["mean"], row["nees"]["median"], row["milliseconds"]["median"]]
    return [
        f"{row['found']}/{row['markers']} {_share(row['found'], row['markers'])}",
        str(row["false"]),
        str(row["unlisted"]),
        *(_number(n) for n in numbers),
        wrong,
        *(_number(n) for n in rest),
        " ".join(f"{stage} {_share(count, row['found'])}" for stage, count in row["stages"].items()),
    ]


def _share(part: int, whole: int) -> str:
    return f"{100.0 * part / whole:.1f} %" if whole else "-"


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.3g}"
