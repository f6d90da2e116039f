"""Figures: all rows of an evaluation, and one run in detail."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from seater_common.geometry import Chair, Dock
from seater_eval.judge.run import Log
from seater_eval.report.evaluation_style import draw_bay, figure, save

_DOCKED, _FAILED, _ASKED = "#2e9e4f", "#c03030", "#1f6fb4"


def draw_rows(data: dict[str, Any], dock: Dock, path: Path) -> Path:
    """Share docked of each row, final errors and starts of all runs."""
    rows = data["rows"]
    fig, (shares, errors, starts) = figure(3, width=6.0, height=max(4.5, 0.28 * len(rows)))
    docked = [row["summary"]["docked"] / row["summary"]["runs"] for row in rows]
    shares.barh(range(len(rows)), docked, color=_DOCKED)
    shares.set_yticks(range(len(rows)), [row["name"] for row in rows])
    shares.invert_yaxis()
    shares.set(xlim=(0.0, 1.0), xlabel="share docked", title=f"driver {data['driver']}, told {data['told']}")
    runs = [run for row in rows for run in row["runs"]]
    for kind, colour in ((True, _DOCKED), (False, _FAILED)):
        some = [run for run in runs if run["docked"] is kind]
        x = [1e3 * run["position_error_m"] + 0.01 for run in some]
        errors.loglog(x, [abs(run["heading_error_deg"]) + 1e-3 for run in some], ".", color=colour)
        starts.plot([run["start"][0] for run in some], [run["start"][1] for run in some], ".", color=colour)
    errors.axvline(10.0, color="black", lw=0.8)
    errors.axhline(1.0, color="black", lw=0.8)
    errors.set(xlabel="final distance [mm]", ylabel="final heading error [deg]", title="Where the runs end")
    draw_bay(starts, dock)
    starts.set(xlabel="x [m]", ylabel="y [m]", title="Starts (green: docked)", aspect="equal")
    return save(fig, path)


def draw_run(values: dict[str, Any], log: Log, chair: Chair, dock: Dock, path: Path) -> Path:
    """Path, commands against true speeds, error of the estimate."""
    fig, ((way, speed), (estimate, turning)) = figure(2, 2)
    _draw_way(way, log, chair, dock)
    way.set_title(f"{values['row']}, seed {values['seed']}: {values['code']} {values['text']}")
    for axes, column, name in ((speed, 0, "speed [m/s]"), (turning, 1, "turning [rad/s]")):
        if len(log.commands):
            axes.step(
                log.commands[:, 0], log.commands[:, 1 + column], where="post", color=_ASKED, lw=0.8, label="asked"
            )
        axes.plot(log.motion.times, log.motion.speeds[:, column], color=_FAILED, lw=1.0, label="true")
        axes.set(xlabel="time [s]", ylabel=name)
        axes.legend(fontsize=8)
        axes.grid(alpha=0.3)
    errors = log.estimates
    if len(errors):
        estimate.plot(errors[:, 0], 1e3 * errors[:, 1], label="x [mm]")
        estimate.plot(errors[:, 0], 1e3 * errors[:, 2], label="y [mm]")
        estimate.plot(errors[:, 0], 10.0 * np.degrees(errors[:, 3]), label="heading [0.1 deg]")
        estimate.plot(errors[:, 0], 10.0 * errors[:, 5], color="black", lw=0.6, label="age of the image [0.1 s]")
        estimate.legend(fontsize=8)
    estimate.set(xlabel="time [s]", title="Error of the dock's estimate (in odom)")
    estimate.grid(alpha=0.3)
    return save(fig, path)


def _draw_way(axes: Axes, log: Log, chair: Chair, dock: Dock) -> None:
    draw_bay(axes, dock)
    poses = log.motion.poses
    axes.plot(poses[:, 0], poses[:, 1], color=_DOCKED)
    for pose in (poses[0], poses[-1]):
        corners = chair.corners_at(pose)
        axes.fill(corners[:, 0], corners[:, 1], fill=False, color="black", lw=0.8)
        ahead = [pose[0] + 0.3 * math.cos(pose[2]), pose[1] + 0.3 * math.sin(pose[2])]
        axes.plot([pose[0], ahead[0]], [pose[1], ahead[1]], color="black", lw=0.8)
    axes.set(xlabel="x [m]", ylabel="y [m]", aspect="equal")
