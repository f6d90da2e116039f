"""What a replay found: one line per image, one line per control cycle, and a summary of both.

Times [s] are stamps of the recording; poses (x [m], y [m], heading [rad]) are the dock in odom: the image's dock pose
taken through the camera mount and the odometry at the image's own time; without odometry, in base_link. Where nothing
was measured a field is empty.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from seater_eval.docking.summary import timing, timing_text
from seater_eval.report.tables import text_list

Array = NDArray[np.float64]


@dataclass
class ImageRow:
    """One image of the recording."""

    stamp: float
    markers: int  # markers found
    dock_seen: int  # 1 when a pose of the dock was found
    dock_x: float | None  # [m] in odom, or base_link
    dock_y: float | None
    dock_heading: float | None  # [rad]
    position_sd: float | None  # [m] sqrt of the sum of the position variances, as perception states it
    processing_ms: float  # wall time


@dataclass
class CycleRow:
    """One control cycle in shadow mode."""

    stamp: float
    phase: str
    status: int
    solve_ms: float
    iterations: int
    v: float  # what the controller would have asked for [m/s]
    omega: float  # [rad/s]
    recorded_v: float | None  # commanded in the recording
    recorded_omega: float | None


def write_csv(path: Path, rows: Sequence[Any], row_type: type) -> None:
    """Full precision, empty field for None."""
    names = [f.name for f in fields(row_type)]
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(names)
        for row in rows:
            writer.writerow(["" if getattr(row, n) is None else getattr(row, n) for n in names])


def summarize_replay(
    images: Sequence[ImageRow], cycles: Sequence[CycleRow], images_in_bag: int, frame: str = "odom"
) -> dict[str, Any]:
    """The contents of summary.json. `frame`: of the dock's poses.

    Pose jitter is the standard deviation of the noise from image to image: rms of second differences / sqrt(6),
    which leaves out steady drift and motion.
    """
    seen = [p for p in images if p.dock_seen]
    poses = np.array([[p.dock_x, p.dock_y, p.dock_heading] for p in seen if p.dock_x is not None], dtype=float)
    processing = np.array([p.processing_ms for p in images], dtype=float)
    return {
        "images_in_bag": images_in_bag,
        "images_worked_through": len(images),
        "dock_detected": len(seen),
        "detection_rate": len(seen) / len(images) if images else 0.0,
        "longest_gap_s": _longest_gap([p.stamp for p in images], [p.stamp for p in seen]),
        "frame": frame,
        "pose_jitter": _jitter(poses),
        "perception_ms": timing(processing),
        "shadow_controller": _shadow(cycles),
    }


def replay_table(summary: dict[str, Any]) -> str:
    """The summary for a person."""
    jitter, shadow = summary["pose_jitter"], summary["shadow_controller"]
    rows = [
        ("images", f"{summary['images_worked_through']} of {summary['images_in_bag']} in the bag"),
        (
            "dock detected",
            f"{summary['dock_detected']} ({100 * summary['detection_rate']:.1f} %),"
            f" longest gap {summary['longest_gap_s']:.2f} s",
        ),
    ]
    if jitter is not None:
        text = f"{1e3 * jitter['position_m']:.2f} mm, {jitter['heading_deg']:.3f} deg"
        rows.append(("pose jitter (1 sd)", f"{text} (dock in {summary['frame']}, image to image)"))
    rows.append(("perception per image", f"{timing_text(summary['perception_ms'])} (wall time)"))
    if not shadow["cycles"]:
        return text_list(rows)
    rows += [
        ("shadow controller", f"{shadow['cycles']} cycles, solve {timing_text(shadow['solve_ms'])}"),
        ("would have asked for", f"at most {shadow['v_max']:.2f} m/s and {shadow['omega_max']:.2f} rad/s"),
    ]
    if shadow["v_rms_difference"] is not None:
        text = f"rms {shadow['v_rms_difference']:.3f} m/s, {shadow['omega_rms_difference']:.3f} rad/s"
        rows.append(("against the recording", text))
    return text_list(rows)


def _longest_gap(stamps: Sequence[float], seen: Sequence[float]) -> float:
    if not stamps:
        return 0.0
    marks = [min(stamps), *seen, max(stamps)]
    return float(np.max(np.diff(marks))) if len(marks) > 1 else 0.0


def _jitter(poses: Array) -> dict[str, float] | None:
    if len(poses) < 3:
        return None
    unwrapped = np.column_stack([poses[:, :2], np.unwrap(poses[:, 2])])
    second = np.diff(unwrapped, n=2, axis=0)
    position = math.sqrt(float(np.mean(np.sum(second[:, :2] ** 2, axis=1))) / 6.0)
    heading = math.sqrt(float(np.mean(second[:, 2] ** 2)) / 6.0)
    return {"position_m": position, "heading_deg": math.degrees(heading)}


def _shadow(cycles: Sequence[CycleRow]) -> dict[str, Any]:
    asked = np.array([[c.v, c.omega] for c in cycles], dtype=float).reshape(-1, 2)
    compared = np.array(
        [
            [c.v - c.recorded_v, c.omega - c.recorded_omega]
            for c in cycles
            if c.recorded_v is not None and c.recorded_omega is not None
        ],
        dtype=float,
    ).reshape(-1, 2)
    rms = np.sqrt(np.mean(compared**2, axis=0)) if len(compared) else None
    return {
        "cycles": len(cycles),
        "solve_ms": timing(np.array([c.solve_ms for c in cycles], dtype=float)),
        "v_max": float(np.max(np.abs(asked[:, 0]), initial=0.0)),
        "omega_max": float(np.max(np.abs(asked[:, 1]), initial=0.0)),
        "v_rms_difference": None if rms is None else float(rms[0]),
        "omega_rms_difference": None if rms is None else float(rms[1]),
    }
