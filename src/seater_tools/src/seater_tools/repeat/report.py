"""A session for the screen, as CSV and JSON, and as a picture."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Sequence
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any

import numpy as np
from tabulate import tabulate

from seater_nmpc.sequence.goal.results import ResultCode
from seater_tools.repeat.session import Docked
from seater_tools.repeat.statistics import Repeatability, Spread

_MM, _DEG = 1e3, 180.0 / math.pi


def line(number: int, wanted: int, d: Docked) -> str:
    """One docking, when it has ended."""
    if not d.success:
        return f"{number} of {wanted}: {_name(d.code)} after {d.duration:.1f} s: {d.text}"
    found = f"{_MM * d.x:+.1f} mm along, {_MM * d.y:+.1f} mm across, {_DEG * d.heading:+.2f} deg"
    return f"{number} of {wanted}: docked in {d.duration:.1f} s" + (f", {found}" if d.measured else ", not verified")


def describe(r: Repeatability) -> str:
    """Means, spreads, worst."""
    head = f"{r.docked} of {r.dockings} docked, {r.retried} of them after another try"
    if r.measured == 0:
        return f"{head}; none was measured"
    parts = (
        ("along the dock [mm]", r.x, _MM),
        ("across [mm]", r.y, _MM),
        ("distance from the dock [mm]", r.distance, _MM),
        ("heading [deg]", r.heading, _DEG),
        ("docking time [s]", r.duration, 1.0),
    )
    rows = [[name, *_numbers(s, factor)] for name, s, factor in parts if s is not None]
    table = tabulate(rows, [f"{r.measured} measured", "mean", "sd", "worst"], floatfmt=".2f", missingval="-")
    shown = "needs two dockings" if math.isnan(r.repeatability) else f"{_MM * r.repeatability:.2f} mm"
    return (
        f"{head}\n\n{table}\n\n"
        f"accuracy (AP, distance of the mean from the dock): {_MM * r.accuracy:.2f} mm\n"
        f"repeatability (RP, mean + 3 sd of the distances from the mean): {shown}\n"
        f"how sure the chair itself was, errors of the installation included: {_MM * r.stated_sd:.2f} mm (sd)"
    )


def _numbers(s: Spread, factor: float) -> list[float | None]:
    return [None if math.isnan(v) else factor * v for v in (s.mean, s.sd, s.worst)]


def as_csv(dockings: Sequence[Docked]) -> bytes:
    """SI units and radians, a line per docking."""
    stream = io.StringIO()
    writer = csv.DictWriter(stream, [field.name for field in fields(Docked)], lineterminator="\n")
    writer.writeheader()
    writer.writerows(asdict(d) for d in dockings)
    return stream.getvalue().encode()


def as_json(dockings: Sequence[Docked], r: Repeatability, ended: str) -> bytes:
    """SI units and radians."""
    data = {"ended": ended, "repeatability": asdict(r), "dockings": [asdict(d) for d in dockings]}
    return json.dumps(_finite(data), indent=1, allow_nan=False).encode()


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _finite(entry) for key, entry in value.items()}
    if isinstance(value, list):
        return [_finite(entry) for entry in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def draw(dockings: Sequence[Docked], r: Repeatability, path: Path) -> None:
    """Where the chair stood, its heading, how long it took. Raises OSError."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    fig, (plane, heading, time) = plt.subplots(1, 3, figsize=(13.0, 4.4), layout="constrained")
    numbers = np.arange(1, len(dockings) + 1)
    good = np.array([d.measured for d in dockings], dtype=bool)
    x, y = (_MM * np.array([getattr(d, name) for d in dockings]) for name in ("x", "y"))
    _target(plane, x[good], y[good], r)
    degrees = _DEG * np.array([d.heading for d in dockings])
    heading.axhline(0.0, color="#8a8f98", lw=0.8)
    heading.plot(numbers[good], degrees[good], ".", color="#2060a0")
    heading.set(xlabel="docking", ylabel="heading [deg]", title="heading")
    lost = np.array([not d.success for d in dockings], dtype=bool)
    seconds = np.array([d.duration for d in dockings])
    time.plot(numbers[~lost], seconds[~lost], ".", color="#2060a0", label="docked")
    time.plot(numbers[lost], seconds[lost], "x", color="#c03030", label="not docked")
    time.set(xlabel="docking", ylabel="time [s]", title="time", ylim=(0.0, 1.1 * seconds.max()))
    time.legend(fontsize=8)
    for axes in (heading, time):
        axes.xaxis.get_major_locator().set_params(integer=True)
    path.parent.mkdir(parents=True, exist_ok=True)
    fig.savefig(path, dpi=100)
    plt.close(fig)


def _target(axes: Any, x: Any, y: Any, r: Repeatability) -> None:
    """In the dock's frame: y to the left, x into the bay."""
    import matplotlib.pyplot as plt

    axes.axhline(0.0, color="#8a8f98", lw=0.8)
    axes.axvline(0.0, color="#8a8f98", lw=0.8)
    axes.plot(y, x, ".", color="#2060a0", label="dockings")
    if r.x is not None and r.y is not None:
        middle = (_MM * r.y.mean, _MM * r.x.mean)
        axes.plot(*middle, "D", color="#c03030", ms=6, label="mean")
        if math.isfinite(r.repeatability):
            circle = plt.Circle(middle, _MM * r.repeatability, fill=False, color="#c03030", label="repeatability RP")
            axes.add_patch(circle)
        axes.legend(fontsize=8)
    axes.set_aspect("equal", adjustable="datalim")
    axes.invert_xaxis()
    axes.set(xlabel="across, left [mm]", ylabel="along, into the dock [mm]", title="where it stands (0: the dock)")


def _name(code: int) -> str:
    return ResultCode(code).name if code in set(map(int, ResultCode)) else str(code)
