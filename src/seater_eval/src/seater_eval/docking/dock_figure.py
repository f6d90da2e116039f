"""The figure of one docking: the bay, the path, the footprint along it, speeds and errors over time."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")  # no screen needed

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Polygon

from seater_common.geometry import Chair, Dock
from seater_eval.docking.recording import Recording

WALL = "#8a8f98"
OBSTACLE = "#b0563f"
PATH = "#1f6fb4"
CHAIR = "#1f6fb4"
GOAL = "#2e9e4f"
START = "#d1852c"
_KIND = {"truth": "true", "estimate": "estimated", "nothing": "estimated"}
_LETTER = 0.009  # width of a letter in a phase's name over that of the time axis


def draw_docking(recording: Recording, summary: dict[str, Any], dock: Dock, chair: Chair, path: str | Path) -> None:
    """Writes a PNG."""
    figure = plt.figure(figsize=(15.0, 8.4), dpi=100, constrained_layout=True)
    grid = figure.add_gridspec(3, 2, width_ratios=[1.35, 1.0])
    _draw_map(figure.add_subplot(grid[:, 0]), recording, dock, chair)
    first = figure.add_subplot(grid[0, 1])
    _draw_speeds(first, recording)
    t0 = _begin(recording)
    begin, end = recording.span
    first.set_xlim(min(0.0, begin - t0), end - t0)  # shared by all three; early commands carry no stamp
    _draw_errors(figure.add_subplot(grid[1, 1], sharex=first), recording, dock)
    _draw_computation(figure.add_subplot(grid[2, 1], sharex=first), recording)
    figure.suptitle(_title(summary), fontsize=13)
    figure.savefig(path)
    plt.close(figure)


def _title(summary: dict[str, Any]) -> str:
    by_truth = summary["judged_by"] == "truth"
    error = summary["true_error"] if by_truth else summary["estimated_final_error"]
    word = "Docked" if summary["docked"] else f"NOT docked (result {summary['result_code']}: {summary['result_text']})"
    title = f"{word} in {summary['duration_s']:.1f} s. "
    if error is not None:
        title += (
            f"{'True final error' if by_truth else 'Final error AS ESTIMATED'}: "
            f"longitudinal {1e3 * error['longitudinal_m']:+.1f} mm, "
            f"lateral {1e3 * error['lateral_m']:+.1f} mm, heading {error['heading_deg']:+.2f}°"
        )
    title += "" if by_truth else "\nno ground truth in the bag"
    return title + (f"; not recorded: {', '.join(summary['missing'])}" if summary["missing"] and not by_truth else "")


def _draw_map(axes: Axes, recording: Recording, dock: Dock, chair: Chair) -> None:
    _draw_bay(axes, dock)
    for index, outline in enumerate(recording.obstacles):
        label = None if index else "obstacles"
        axes.add_patch(Polygon(outline, closed=True, facecolor=OBSTACLE, edgecolor="none", label=label))
    poses = recording.path[:, 1:4]
    for pose in _spaced(poses, 0.35):
        axes.add_patch(Polygon(chair.corners_at(pose), closed=True, fill=False, edgecolor=CHAIR, alpha=0.25, lw=0.8))
    if len(poses):
        label = f"path of the driven axle ({_KIND[recording.judged_by]})"
        axes.plot(poses[:, 0], poses[:, 1], color=PATH, lw=2.0, label=label)
        _draw_chair(axes, chair, poses[0], START, "start")
        _draw_chair(axes, chair, poses[-1], PATH, "end")
    axes.add_patch(
        Polygon(chair.corners_at(dock.docked_pose), fill=False, edgecolor=GOAL, lw=1.6, ls="--", label="docking pose")
    )
    axes.plot(dock.predock_x, 0.0, marker="x", color=GOAL, ms=8, ls="none", label="predock point")
    axes.set_aspect("equal")
    axes.set_xlabel("x in the dock frame [m]")
    axes.set_ylabel("y [m]")
    axes.set_title("Seen from above" if len(poses) else "No path: odom or dock_pose_filtered was not recorded")
    axes.grid(alpha=0.3)
    axes.margins(0.06)
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2), fontsize=9, ncol=4, frameon=False)


def _draw_bay(axes: Axes, dock: Dock) -> None:
    bay = dock.bay
    half = 0.5 * bay.width + bay.wall_thickness
    x = bay.back_wall_x
    back = np.array([[x, -half], [x + bay.wall_thickness, -half], [x + bay.wall_thickness, half], [x, half]])
    for index, wall in enumerate([*bay.side_walls(), back]):
        axes.add_patch(
            Polygon(wall, closed=True, facecolor=WALL, edgecolor="none", label="walls" if index == 0 else None)
        )
    for index, marker in enumerate(dock.markers):
        T = marker.T_dock_marker()
        ends = np.array([T[:3, 3] + s * 0.5 * marker.size * T[:3, 0] for s in (-1.0, 1.0)])
        axes.plot(
            ends[:, 0], ends[:, 1], color="black", lw=5, solid_capstyle="butt", label=None if index else "markers"
        )
        axes.annotate(
            f"id {marker.id}",
            (x + bay.wall_thickness, T[1, 3]),
            xytext=(4, 0),
            textcoords="offset points",
            fontsize=8,
            va="center",
        )


def _draw_chair(axes: Axes, chair: Chair, pose: np.ndarray, colour: str, name: str) -> None:
    corners = chair.corners_at(pose)
    axes.add_patch(Polygon(corners, closed=True, facecolor=colour, alpha=0.22, edgecolor=colour, lw=1.5))
    tip = pose[:2] + chair.length_front * np.array([math.cos(pose[2]), math.sin(pose[2])])
    axes.annotate("", xy=tip, xytext=pose[:2], arrowprops={"arrowstyle": "->", "color": colour, "lw": 1.8})
    axes.plot(pose[0], pose[1], "o", color=colour, ms=6, label=name)


def _draw_speeds(axes: Axes, recording: Recording) -> None:
    t0, motion = _begin(recording), recording.motion
    axes.plot(motion[:, 0] - t0, motion[:, 4], color=PATH, label="speed [m/s]")
    axes.plot(motion[:, 0] - t0, motion[:, 5], color=START, label="turning rate [rad/s]")
    if len(recording.commands):
        axes.step(
            recording.commands[:, 0] - t0,
            recording.commands[:, 1],
            where="post",
            color=PATH,
            lw=0.7,
            alpha=0.6,
            ls=":",
            label="as asked for",
        )
        axes.step(
            recording.commands[:, 0] - t0,
            recording.commands[:, 2],
            where="post",
            color=START,
            lw=0.7,
            alpha=0.6,
            ls=":",
        )
    axes.axhline(0.0, color="black", lw=0.6)
    axes.set_title("Speeds (true)" if len(recording.truth) else "Speeds (by the wheels)")
    axes.legend(loc="upper right", fontsize=8)
    axes.grid(alpha=0.3)
    _shade_phases(axes, recording, t0)


def _draw_errors(axes: Axes, recording: Recording, dock: Dock) -> None:
    t0, path, kind = _begin(recording), recording.path, _KIND[recording.judged_by]
    time = path[:, 0] - t0
    x, y, heading = np.array([dock.docking_error(pose) for pose in path[:, 1:4]]).reshape(-1, 3).T
    axes.semilogy(time, 1e3 * np.hypot(x, y), color=PATH, label="distance [mm]")
    axes.semilogy(time, 1e3 * np.abs(y), color=GOAL, lw=1.0, label="lateral [mm]")
    axes.semilogy(time, np.degrees(np.abs(heading)), color=START, lw=1.0, label="heading [deg]")
    axes.axhline(1e3 * dock.tolerance.position, color=PATH, lw=0.8, ls="--", label="tolerance, distance")
    axes.axhline(math.degrees(dock.tolerance.heading), color=START, lw=0.8, ls="--", label="tolerance, heading")
    axes.set_ylim(bottom=1e-2)
    axes.set_title(f"{kind.capitalize()} error to the docking pose (logarithmic)")
    axes.legend(loc="lower left", fontsize=8, ncol=2)
    axes.grid(alpha=0.3, which="both")
    _shade_phases(axes, recording, t0, names=False)


def _draw_computation(axes: Axes, recording: Recording) -> None:
    t0 = _begin(recording)
    if len(recording.control):
        axes.plot(recording.control[:, 0] - t0, 1e3 * recording.control[:, 1], ".", color=PATH, ms=4, label="solver")
    if len(recording.images):
        seen = recording.images[:, 2] > 0
        images = recording.images
        axes.plot(images[seen, 0] - t0, 1e3 * images[seen, 3], ".", color=GOAL, ms=3, label="image, dock seen")
        axes.plot(images[~seen, 0] - t0, 1e3 * images[~seen, 3], "x", color="#c03030", ms=5, label="image, not seen")
    axes.set_ylim(0.0, 1.25 * axes.get_ylim()[1])
    axes.set_title("Computing time [ms]")
    axes.set_xlabel("time since the goal [s]")
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="upper right", fontsize=8)
    axes.grid(alpha=0.3)


def _begin(recording: Recording) -> float:
    """[s] from which times count."""
    return recording.goal_time if recording.goal_time is not None else recording.span[0]


def _shade_phases(axes: Axes, recording: Recording, t0: float, names: bool = True) -> None:
    ends = [*(t for t, _ in recording.phases[1:]), recording.span[1]][: len(recording.phases)]
    free = -np.inf  # where the last name ends: of names that would overlap, the later ones are left out
    for index, ((start, name), end) in enumerate(zip(recording.phases, ends, strict=True)):
        if index % 2:
            axes.axvspan(start - t0, end - t0, color="black", alpha=0.05, lw=0)
        text = name.lower().replace("_", " ")
        middle, half = 0.5 * (start + end) - t0, 0.5 * len(text) * _LETTER * (ends[-1] - t0)
        if names and end - start > 0.4 and middle - half > free:
            free = middle + half
            axes.text(
                middle,
                1.0,
                text,
                fontsize=7,
                ha="center",
                va="bottom",
                transform=axes.get_xaxis_transform(),
            )
    if names:
        axes.set_title(axes.get_title(), pad=14)


def _spaced(poses: np.ndarray, spacing: float) -> list[np.ndarray]:
    """Poses that lie at least `spacing` [m] of driven way apart."""
    if len(poses) == 0:
        return []
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(poses[:, :2], axis=0), axis=1))])
    wanted = np.arange(0.0, way[-1] + 1e-9, spacing)
    return [poses[int(np.searchsorted(way, w))] for w in wanted]
