"""The common style of the evaluation's figures."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")  # no screen needed

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Polygon

from seater_common.geometry import Dock

COLOURS = {
    "rti": "#2e9e4f",
    "fatrop": "#1f6fb4",
    "ipopt": "#d1852c",
    "ipopt_default": "#c03030",
    "do_mpc": "#7a4fb0",
    "paper_formulation": "#8a8f98",
    "park_kuipers": "#00868b",
    "pbvs": "#a0527a",
    "seater": "#2e9e4f",
    "seater_calm": "#9ccb5a",
}


def figure(columns: int, rows: int = 1, width: float = 6.5, height: float = 5.0) -> Any:
    """A figure and its axes."""
    return plt.subplots(rows, columns, figsize=(width * columns, height * rows), dpi=100, constrained_layout=True)


def save(fig: Any, path: Path) -> Path:
    """Writes the PNG and closes the figure."""
    path.parent.mkdir(parents=True, exist_ok=True)
    fig.savefig(path)
    plt.close(fig)
    return path


def draw_bay(axes: Axes, dock: Dock) -> None:
    """The walls, in the dock's frame."""
    bay = dock.bay
    half, x = 0.5 * bay.width + bay.wall_thickness, bay.back_wall_x
    back = np.array([[x, -half], [x + bay.wall_thickness, -half], [x + bay.wall_thickness, half], [x, half]])
    for wall in [*bay.side_walls(), back]:
        axes.add_patch(Polygon(wall, closed=True, facecolor="#8a8f98", edgecolor="none"))
