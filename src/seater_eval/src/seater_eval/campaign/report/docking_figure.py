"""The figure of one replayed docking: path in the bay, speeds and commands, error of the estimate, phases."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Polygon
from numpy.typing import NDArray

from seater_common.geometry import Chair, Dock
from seater_eval.campaign.report.figures import DOCKED, FAILED
from seater_eval.report.evaluation_style import draw_bay

Array = NDArray[np.float64]

TURNING = "#d1852c"
_SPACING = 0.3  # [m] between two footprints


def draw_docking(
    row: Mapping[str, Any], truth: Array, cycles: Array, images: Array, phases: list[str], dock: Dock, chair: Chair
) -> Any:
    """`truth`, `cycles`, `images`: arrays of a Trace; `phases`: names by number; the chair and dock are the true ones.

    Returns the figure.
    """
    fig = plt.figure(figsize=(14.0, 7.6), dpi=90, constrained_layout=True)
    grid = fig.add_gridspec(4, 2, width_ratios=[1.15, 1.0])
    _draw_map(fig.add_subplot(grid[:, 0]), truth, dock, chair)
    first = fig.add_subplot(grid[0, 1])
    _draw_speed(first, truth, cycles, 4, "speed [m/s]", DOCKED)
    _shade_phases(first, cycles, phases, names=True)
    others = [fig.add_subplot(grid[i, 1], sharex=first) for i in (1, 2, 3)]
    _draw_speed(others[0], truth, cycles, 5, "turning rate [rad/s]", TURNING)
    _draw_estimate(others[1], cycles)
    _draw_images(others[2], images)
    for axes in others:
        _shade_phases(axes, cycles, phases, names=False)
    others[2].set_xlabel("time since the goal [s]")
    fig.suptitle("\n".join(textwrap.wrap(title(row), 150)), fontsize=10)
    return fig


def title(row: Mapping[str, Any]) -> str:
    """What was tried and how it ended, in a line or two."""
    variants = ", ".join(f"{axis} {variant}" for axis, variant in row.get("variants", {}).items())
    last = str(row["text"]).splitlines()[-1] if row["text"] else ""
    errors = ""
    if row.get("position_error_m") is not None:
        errors = f"; true error {1e3 * row['position_error_m']:.1f} mm, {row['heading_error_deg']:+.2f} deg"
    return f"case {row['index']} (seed {row['seed']}): {row['result']}, {last}{errors}. {variants}"


def _draw_map(axes: Axes, truth: Array, dock: Dock, chair: Chair) -> None:
    draw_bay(axes, dock)
    poses = truth[:, 1:4]
    way = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(poses[:, :2], axis=0).T))])
    for at in np.searchsorted(way, np.arange(0.0, way[-1], _SPACING)):
        outline = chair.corners_at(poses[min(int(at), len(poses) - 1)])
        axes.add_patch(Polygon(outline, fill=False, edgecolor=DOCKED, alpha=0.25, lw=0.7))
    axes.plot(poses[:, 0], poses[:, 1], color=DOCKED, lw=1.6, label="true path of base_link")
    for pose, colour, name in ((poses[0], TURNING, "start"), (poses[-1], DOCKED, "end")):
        axes.add_patch(Polygon(chair.corners_at(pose), facecolor=colour, alpha=0.2, edgecolor=colour, label=name))
    goal = chair.corners_at(dock.docked_pose)
    axes.add_patch(Polygon(goal, fill=False, edgecolor="#2e9e4f", ls="--", lw=1.4, label="docking pose"))
    for marker in dock.markers:
        across = 0.5 * marker.size * marker.T_dock_marker()[:2, 0]
        ends = np.array(marker.position[:2]) + np.array([-across, across])
        axes.plot(ends[:, 0], ends[:, 1], color="black", lw=4, solid_capstyle="butt")
    axes.set(aspect="equal", xlabel="x in the dock frame [m]", ylabel="y [m]")
    axes.margins(0.05)
    axes.grid(alpha=0.3)
    axes.legend(loc="upper left", fontsize=8)


def _draw_speed(axes: Axes, truth: Array, cycles: Array, column: int, name: str, colour: str) -> None:
    """`column`: of the truth, and of what the gate passed on; what was asked for stands two columns further left."""
    axes.plot(truth[:, 0], truth[:, column], color=colour, lw=1.3, label="true")
    axes.step(cycles[:, 0], cycles[:, column - 2], where="post", color="black", lw=0.7, ls=":", label="asked for")
    axes.step(cycles[:, 0], cycles[:, column], where="post", color=FAILED, lw=0.7, alpha=0.7, label="after the gate")
    axes.set_ylabel(name, fontsize=8)
    axes.grid(alpha=0.3)
    axes.legend(loc="upper right", fontsize=7, ncol=3)


def _draw_estimate(axes: Axes, cycles: Array) -> None:
    axes.plot(cycles[:, 0], 1e3 * cycles[:, 6], color=DOCKED, lw=1.0, label="x [mm]")
    axes.plot(cycles[:, 0], 1e3 * cycles[:, 7], color="#2e9e4f", lw=1.0, label="y [mm]")
    axes.plot(cycles[:, 0], 10.0 * np.degrees(cycles[:, 8]), color=TURNING, lw=1.0, label="heading [0.1 deg]")
    axes.set_ylabel("error of the estimate", fontsize=8)
    axes.grid(alpha=0.3)
    axes.legend(loc="upper right", fontsize=7, ncol=3)


def _draw_images(axes: Axes, images: Array) -> None:
    """Markers found in each image; red where the observer did not use it (outcomes above 3 of seater_nmpc)."""
    for used, colour, name in ((True, DOCKED, "image used"), (False, FAILED, "not used")):
        some = images[(images[:, 2] <= 3.0) == used]
        axes.plot(some[:, 0], some[:, 1], ".", color=colour, ms=3, label=name)
    axes.set_ylabel("markers found", fontsize=8)
    axes.grid(alpha=0.3)
    axes.legend(loc="upper right", fontsize=7, ncol=2)


def _shade_phases(axes: Axes, cycles: Array, phases: list[str], *, names: bool) -> None:
    """`phases`: names by number; -1: after the result."""
    if not len(cycles):
        return
    begins = np.flatnonzero(np.diff(cycles[:, 1], prepend=-2.0))
    for i, (begin, end) in enumerate(zip(begins, [*begins[1:], len(cycles) - 1], strict=True)):
        t0, t1, phase = cycles[begin, 0], cycles[end, 0], int(cycles[begin, 1])
        if i % 2:
            axes.axvspan(t0, t1, color="black", alpha=0.05, lw=0)
        if names and phase >= 0 and t1 - t0 > 0.4:
            label = phases[phase].lower().replace("_", " ")
            place = axes.get_xaxis_transform()
            axes.text(0.5 * (t0 + t1), 1.02, label, fontsize=7, ha="center", va="bottom", transform=place)
