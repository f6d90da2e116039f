"""One picture of a calibration: what is left over, the markers before and after, the drive from above."""

from __future__ import annotations

import io

import matplotlib
import numpy as np
from numpy.typing import NDArray

from seater_tools.mount.result import Calibration
from seater_tools.mount.solve import Solution

matplotlib.use("Agg")
from matplotlib import pyplot as plt
from matplotlib.axes import Axes

Array = NDArray[np.float64]

WORST = 99.0  # percentile of the residuals that is still drawn
MAGNIFIED = 10.0  # shifts of the markers in the view from the front


def draw(solution: Solution, calibration: Calibration) -> bytes:
    """A PNG."""
    figure, axes = plt.subplots(1, 3, figsize=(16.0, 5.0), constrained_layout=True)
    _residuals(axes[0], solution, calibration)
    _front(axes[1], calibration)
    _above(axes[2], solution, calibration)
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=110)
    plt.close(figure)
    return buffer.getvalue()


def _residuals(axes: Axes, solution: Solution, calibration: Calibration) -> None:
    drive, layout = solution.problem.drive, solution.problem.layout
    off = drive.corners - solution.problem.corners(solution.state)
    for id in layout.ids:
        mine = off[drive.ids == id].reshape(-1, 2)
        axes.plot(*mine.T, ".", markersize=2.0, alpha=0.5, label=f"marker {id}")
    reach = 1.1 * max(float(np.percentile(np.abs(off), WORST)), 1e-3)
    axes.set(xlim=(-reach, reach), ylim=(reach, -reach), xlabel="x [px]", ylabel="y [px]", aspect="equal")
    axes.set_title(f"corners less model: {calibration.corner_rms:.3f} px")
    axes.legend(markerscale=4.0)


def _front(axes: Axes, calibration: Calibration) -> None:
    for id, values in calibration.markers.items():
        named = {value.name: value for value in values}
        for drawn, colour in (("file", "0.6"), ("used", "C0")):
            side = getattr(named["size"], drawn)
            y, z = (
                named[n].file + (MAGNIFIED if drawn == "used" else 0.0) * (named[n].used - named[n].file) for n in "yz"
            )
            x0, x1, z0, z1 = y - 0.5 * side, y + 0.5 * side, z - 0.5 * side, z + 0.5 * side
            axes.plot([x0, x1, x1, x0, x0], [z0, z0, z1, z1, z0], color=colour)
        axes.annotate(f"{id}", (named["y"].file, named["z"].file), ha="center", va="center")
    axes.invert_xaxis()
    axes.set(xlabel="y in the dock frame [m]", ylabel="height [m]", aspect="equal")
    axes.set_title(f"markers: file (grey), new (blue; shifts x {MAGNIFIED:g})")


def _above(axes: Axes, solution: Solution, calibration: Calibration) -> None:
    poses = solution.problem.layout.poses(solution.state)
    axes.plot(poses[:, 0], poses[:, 1], ".-", linewidth=0.5, markersize=3.0, label="base_link")
    axes.quiver(*poses[::5, :2].T, np.cos(poses[::5, 2]), np.sin(poses[::5, 2]), color="C0", width=0.003, scale=25.0)
    for id, values in calibration.markers.items():
        x, y, yaw, side = (next(v.used for v in values if v.name == n) for n in ("x", "y", "yaw", "size"))
        across = 0.5 * side * np.array([-np.sin(yaw), np.cos(yaw)])
        axes.plot([x - across[0], x + across[0]], [y - across[1], y + across[1]], color="k", linewidth=3.0)
        axes.annotate(f" {id}", (x, y))
    axes.plot(0.0, 0.0, "r+", markersize=12.0, label="docked")
    axes.set(xlabel="x [m]", ylabel="y [m]", aspect="equal", title="the drive in the dock frame")
    axes.legend()
