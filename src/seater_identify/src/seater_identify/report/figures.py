"""A figure for each axis (command, measured, model, residual), and one of the way with the estimates."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")  # no screen needed

import matplotlib.pyplot as plt
import numpy as np

from seater_identify.record.recording import Recording
from seater_identify.report.table import describe
from seater_identify.result.identify import Identification

TITLES = ("speed [m/s]", "turning rate [rad/s]")
FILES = ("speed.png", "turning.png")
MEASURED, MODEL, COMMAND = "#8a8f98", "#2e9e4f", "#1f6fb4"


def draw_all(result: Identification, recording: Recording, folder: Path) -> list[Path]:
    """The figures' files."""
    axes = [_draw_axis(result, axis, folder / FILES[axis]) for axis in result.axes]
    return [*axes, _draw_overview(result, recording, folder / "overview.png")]


def _draw_axis(result: Identification, axis: int, path: Path) -> Path:
    data, fit = result.axes[axis]
    begin = data.begin[0]
    fig, (top, bottom) = plt.subplots(
        2, 1, figsize=(13, 7), sharex=True, height_ratios=(3, 1), constrained_layout=True
    )  # fmt: skip
    time = 0.5 * (data.begin + data.end) - begin
    top.plot(time, data.measured, color=MEASURED, linewidth=0.8, label="measured")
    top.plot(time, fit.predicted, color=MODEL, linewidth=1.2, label="model")
    top.step(data.commands.times - begin, data.commands.values, where="post", color=COMMAND, linewidth=0.8,
             label="command")  # fmt: skip
    top.set_ylabel(TITLES[axis])
    top.legend(loc="upper right")
    bottom.plot(time, data.measured - fit.predicted, color=MEASURED, linewidth=0.8)
    bottom.set(xlabel="time [s]", ylabel=f"residual {TITLES[axis].split()[-1]}")
    return _save(fig, path)


def _draw_overview(result: Identification, recording: Recording, path: Path) -> Path:
    fig, (way, table) = plt.subplots(1, 2, figsize=(14, 6), width_ratios=(1, 1), constrained_layout=True)
    x, y = recording.odometry[:, 1], recording.odometry[:, 2]
    way.plot(x - x[0], y - y[0], color=MODEL, label="by odometry")
    seen = np.interp(recording.dock[:, 0], recording.odometry[:, 0], np.arange(len(x))).astype(int)
    way.plot((x - x[0])[seen], (y - y[0])[seen], ".", markersize=2, color=COMMAND, label="there, the dock seen")
    way.set(xlabel="x in odom [m]", ylabel="y in odom [m]", title="The drive")
    way.axis("equal")
    way.legend(loc="best")
    table.axis("off")
    table.text(0.0, 0.5, describe(result), family="monospace", fontsize=7.5, va="center")
    return _save(fig, path)


def _save(fig: Any, path: Path) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    fig.savefig(path, dpi=90)
    plt.close(fig)
    return path
