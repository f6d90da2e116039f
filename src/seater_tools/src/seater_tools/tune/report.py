"""What a search has found: table, JSON, figure, and the copy of controller.yaml."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from seater_common.files.scalars import Path as YamlPath
from seater_common.files.scalars import significant, with_note, with_values
from seater_common.files.whole import write_whole
from seater_eval.report.evaluation_style import figure, save
from seater_eval.report.tables import text_table
from seater_tools.tune.compare import LEVEL, Comparison
from seater_tools.tune.objective import Measures, Verdict, costs
from seater_tools.tune.search import Trial, best
from seater_tools.tune.space import FACTOR, Tunable

TUNED = "# Tuned: "  # first line of a copy
_BLUE, _RED, _GREY = "#1f6fb4", "#c03030", "#8a8f98"


def describe(found: Comparison, space: Sequence[Tunable], values: Mapping[str, float]) -> str:
    """Before and after, on the dockings of the comparison; and the values."""
    rows = [[name, *(show(m) for m in (found.before, found.after))] for name, show in _SHOWN]
    rows.append(["score (lower is better)", f"{found.was.score:.3f}", f"{found.now.score:.3f}"])
    keys = [[t.key, f"{t.value:.4g}", f"{values[t.key]:.4g}", f"{t.low:.3g} .. {t.high:.3g}"] for t in space]
    lines = [
        text_table([f"{len(found.before.time)} dockings not searched with", "before", "after"], rows),
        f"  change of the score, {100 * LEVEL:.0f} % interval: {found.low:+.3f} .. {found.high:+.3f}",
    ]
    broken = [name for name, value in found.now.violations.items() if value > 0.0]
    lines += [f"  after, this is worse than allowed: {', '.join(broken)}"] if broken else []
    return "\n".join([*lines, "", text_table(["", "before", "after", "searched"], keys)])


def _median(name: str, digits: int) -> Any:
    return lambda m: f"{np.nanmedian(getattr(m, name)):.{digits}f}" if np.isfinite(getattr(m, name)).any() else "-"


_SHOWN: tuple[tuple[str, Any], ...] = (
    ("docked", lambda m: f"{m.docked}"),
    ("touched something", lambda m: f"{m.touched}"),
    ("docking time, median [s]", _median("time", 2)),
    ("docking time, 90th percentile [s]", lambda m: f"{np.nanquantile(m.time, 0.9):.2f}"),
    ("jerk, rms, median [m/s^3]", _median("jerk", 3)),
    ("angular jerk, rms, median [rad/s^3]", _median("angular_jerk", 3)),
    ("reversals, mean", lambda m: f"{m.reversals:.2f}"),
    ("final position error, p95 [mm]", lambda m: f"{1e3 * m.position_p95:.2f}"),
    ("final heading error, p95 [deg]", lambda m: f"{m.heading_p95:.3f}"),
)


def as_json(
    trials: Sequence[Trial], space: Sequence[Tunable], found: Comparison | None, conditions: Mapping[str, Any]
) -> bytes:
    """Everything, for programs."""
    chosen = best(trials)
    data = {
        "conditions": dict(conditions),
        "space": [asdict(t) for t in space],
        "trials": [asdict(t) for t in trials],
        "best": None if found is None or chosen is None else asdict(chosen),
        "comparison": None if found is None else asdict(found) | {"better": found.better},
    }
    return json.dumps(data, indent=1, default=_plain).encode()


def _plain(value: Any) -> Any:
    return [None if not np.isfinite(v) else float(v) for v in value]  # arrays


def tuned_text(text: str, name: str, values: Mapping[str, float], note: str) -> str:
    """controller.yaml with the values; comments stay. Raises ParameterError."""
    paths: dict[YamlPath, float] = {tuple(key.split("/")): value for key, value in values.items()}
    return with_note(with_values(text, paths, name, significant), TUNED, note)


def draw(path: Path, trials: Sequence[Trial], space: Sequence[Tunable], found: Comparison | None) -> Path:
    """The search, and what it has brought on other dockings."""
    fig, axes = figure(1 if found is None else 3, width=5.2, height=4.2)
    axes = np.atleast_1d(axes)
    _draw_search(axes[0], trials)
    if found is not None:
        _draw_pairs(axes[1], found.before, found.after)
        _draw_values(axes[2], space, best(trials))
    return save(fig, path)


def _draw_search(axes: Any, trials: Sequence[Trial]) -> None:
    """What is far off lies at the upper edge."""
    top = 1.3 * trials[0].verdict.score if trials else 1.0
    for allowed, marker, colour, label in ((True, "o", _BLUE, "allowed"), (False, "x", _RED, "breaks something")):
        chosen = [(t.number, min(t.verdict.score, top)) for t in trials if t.verdict.allowed == allowed]
        axes.plot(*zip(*chosen, strict=True) if chosen else ([], []), marker, color=colour, ms=4, label=label)
    lowest = [best(trials[: n + 1]) for n in range(len(trials))]
    scores = [np.nan if t is None else t.verdict.score for t in lowest]
    axes.step(range(len(trials)), scores, where="post", color=_BLUE, lw=1)
    axes.set(xlabel="trial (0: as the file has it)", ylabel="score (lower is better)", title="search")
    axes.xaxis.get_major_locator().set_params(integer=True)
    axes.legend(loc="best", fontsize=8)


def _draw_pairs(axes: Any, before: Measures, after: Measures) -> None:
    time = after.time / before.time
    jerk = 0.5 * (after.jerk / before.jerk + after.angular_jerk / before.angular_jerk)
    axes.axhline(1.0, color=_GREY, lw=0.8)
    axes.axvline(1.0, color=_GREY, lw=0.8)
    axes.plot(time, jerk, "o", color=_BLUE, ms=4, alpha=0.6)
    axes.plot(np.nanmedian(time), np.nanmedian(jerk), "D", color=_RED, ms=8, label="median")
    gain = np.mean(costs(after, before) < costs(before, before))
    axes.set(xlabel="docking time, after / before", ylabel="jerk, after / before")
    axes.set_title(f"dockings not searched with: {100 * gain:.0f} % better")
    axes.legend(loc="upper right", fontsize=8)


def _draw_values(axes: Any, space: Sequence[Tunable], found: Trial | None) -> None:
    if found is None:
        return
    for row, t in enumerate(space):
        axes.plot([t.low / t.begin, t.high / t.begin], [row, row], color="#d5d8dc", lw=6, solid_capstyle="butt")
        axes.plot(found.values[t.key] / t.begin, row, "o", color=_BLUE)
    axes.set_xscale("log")
    axes.set_xticks([1.0 / FACTOR, 1.0, FACTOR], [f"1/{FACTOR:g}", "1", f"{FACTOR:g}"])
    axes.set_xticks([], minor=True)
    axes.axvline(1.0, color=_GREY, lw=0.8)
    axes.set_yticks(range(len(space)), [t.key.rpartition("/")[2] for t in space])
    axes.invert_yaxis()
    axes.set(xlabel="value, after / before", title="what was changed (grey: searched)")


def write(path: Path, content: bytes) -> Path:
    """Over an earlier one."""
    write_whole(path, content, overwrite=True)
    return path


def line(trial: Trial, wanted: int, lowest: Trial | None) -> str:
    """One trial, for the screen."""
    verdict: Verdict = trial.verdict
    broken = [name for name, value in verdict.violations.items() if value > 0.0]
    text = f"trial {trial.number + 1} of {wanted}: score {verdict.score:.3f}"
    text += f", breaks: {', '.join(broken)}" if broken else ""
    return text + (f"; best {lowest.verdict.score:.3f} (trial {lowest.number + 1})" if lowest is not None else "")
