"""The results of one docking: summary.json and the table on the screen."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from seater_common.geometry import Chair, Dock, clearance
from seater_common.se2 import compose, inverse
from seater_eval.docking.recording import Recording, pose_at
from seater_eval.report.tables import text_list, text_table

SUCCESS_CODES = (0, 1)  # DockResult.SUCCESS, DockResult.ALREADY_DOCKED
# [m/s], [rad/s] below which the chair stands: by the truth; by wheels, whose encoders and gyro are noisy.
STANDING, STANDING_BY_WHEELS = 1e-3, 0.01
_WITHOUT_TRUTH = {
    "estimate": "path and error are the chair's own estimate, by markers and wheels: it does not see what is "
    "wrong with the camera's mount or the dock file",
    "nothing": "and no estimate: odom and dock_pose_filtered are both needed for a path",
}


def summarize(recording: Recording, dock: Dock, chair: Chair) -> dict[str, Any]:
    """The contents of summary.json.

    true_error is the docking error in the true dock frame when the run ended; estimate_error is the estimated dock in
    the true dock frame, at the time of the last estimate. Docked means: the action says success and the truth agrees.
    A bag of a real chair has no truth: then both are None, estimated_final_error takes the place of the first, and
    docked means that the action and the chair's own estimate agree. What was not recorded at all is None or 0.
    """
    path, motion, by_truth = recording.path, recording.motion, recording.judged_by == "truth"
    error = error_of(dock.docking_error(path[-1, 1:4])) if len(path) else None
    result = recording.result
    code = int(result.result_code) if result is not None else 999
    within = error is not None and (
        error["position_m"] <= dock.tolerance.position
        and abs(error["heading_deg"]) <= math.degrees(dock.tolerance.heading)
    )
    still = STANDING if by_truth else STANDING_BY_WHEELS
    standing = bool(len(motion) and np.all(np.abs(motion[-1, 4:6]) < still))
    return {
        "judged_by": recording.judged_by,
        "missing": list(recording.missing),
        "docked": bool(code in SUCCESS_CODES and within and standing),
        "result_code": code,
        "result_text": result.result_text if result is not None else "no result was received",
        "num_retries": int(result.num_retries) if result is not None else 0,
        "contact": bool(result.contact) if result is not None else False,
        "standing": standing,
        "true_error": error if by_truth else None,
        "estimated_final_error": None if by_truth else error,
        "estimate_error": _estimate_error(recording) if by_truth else None,
        "tolerance": {
            "position_m": dock.tolerance.position,
            "heading_deg": math.degrees(dock.tolerance.heading),
        },
        "duration_s": _duration(recording),
        "solve_ms": {**timing(1e3 * recording.control[:, 1]), "cycles": len(recording.control)},
        "perception": _perception(recording),
        "min_clearance_m": min((clearance(chair, dock.bay, pose) for pose in path[:, 1:4]), default=None),
        "max_speed": {
            "v_mps": float(np.max(np.abs(motion[:, 4]), initial=0.0)),
            "omega_radps": float(np.max(np.abs(motion[:, 5]), initial=0.0)),
        },
        "start_pose": _pose(path[0, 1:4]) if len(path) else None,
        "final_pose": _pose(path[-1, 1:4]) if len(path) else None,
    }


def error_of(pose: ArrayLike) -> dict[str, float]:
    """A pose (x, y, heading) in the frame where it should be zero, in metres and degrees."""
    x, y, heading = (float(v) for v in np.asarray(pose, dtype=float))
    return {
        "longitudinal_m": x,
        "lateral_m": y,
        "position_m": math.hypot(x, y),
        "heading_deg": math.degrees(heading),
    }


def table(summary: dict[str, Any]) -> str:
    """The summary for a person, about a screen."""
    by_truth, tolerance = summary["judged_by"] == "truth", summary["tolerance"]
    if by_truth:
        errors = [["true final error", *_error_cells(summary["true_error"])]]
        errors.append(["error of the estimate", *_error_cells(summary["estimate_error"])])
    else:
        errors = [["final error AS ESTIMATED", *_error_cells(summary["estimated_final_error"])]]
    distance, heading = f"{1e3 * tolerance['position_m']:.2f} mm", f"{tolerance['heading_deg']:.3f} deg"
    errors.append(["tolerance", "", "", distance, heading])
    facts = [] if by_truth else [("no ground truth", _WITHOUT_TRUTH[summary["judged_by"]])]
    facts += [("not recorded", ", ".join(summary["missing"]))] if summary["missing"] else []
    facts += _facts(summary, " (simulated)" if by_truth else "")
    facts += [("simulated chair", summary["plant"])] if "plant" in summary else []
    facts += [(f"{name} file", path) for name, path in summary.get("files", {}).items()]
    word = "DOCKED" if summary["docked"] else "NOT DOCKED"
    word += "" if by_truth else " by its own estimate"
    title = f"{word}   result {summary['result_code']}: {summary['result_text']}"
    head = ["", "longitudinal", "lateral", "distance", "heading"]
    return "\n\n".join([title, text_table(head, errors), text_list(facts)])


def _facts(summary: dict[str, Any], simulated: str) -> list[tuple[str, str]]:
    """Of what was recorded."""
    start, solve, perception = summary["start_pose"], summary["solve_ms"], summary["perception"]
    latency, found = perception["latency_ms"], []
    if start is not None:
        pose = f"({start['x_m']:.2f} m, {start['y_m']:.2f} m, {start['heading_deg']:.1f} deg)"
        found.append(("start", pose))
    found.append(("docking time", f"{summary['duration_s']:.1f} s{simulated}, retries {summary['num_retries']}"))
    if summary["min_clearance_m"] is not None:
        found.append(("smallest clearance", f"{1e3 * summary['min_clearance_m']:.0f} mm"))
    if solve["cycles"]:
        found.append(("solve time", f"{timing_text(solve)}, max {solve['max']:.1f} ms ({solve['cycles']} cycles)"))
    if perception["frames"]:
        images = f"{perception['frames']} at {perception['rate_hz']:.1f} Hz{simulated}"
        found.append(("images", f"{images}, dock seen in {perception['detected']}"))
        found.append(("perception per image", f"{timing_text(latency)} (wall time, receive to publish)"))
    return found


def _error_cells(error: dict[str, float] | None) -> list[str]:
    if error is None:
        return ["the dock was never estimated", "", "", ""]
    return [
        f"{1e3 * error['longitudinal_m']:+.2f} mm",
        f"{1e3 * error['lateral_m']:+.2f} mm",
        f"{1e3 * error['position_m']:.2f} mm",
        f"{error['heading_deg']:+.3f} deg",
    ]


def timing_text(values: dict[str, float]) -> str:
    """What `timing` gave, in words."""
    return f"median {values['median']:.1f} ms, p99 {values['p99']:.1f} ms"


def _pose(pose: ArrayLike) -> dict[str, float]:
    x, y, heading = (float(v) for v in np.asarray(pose, dtype=float))
    return {"x_m": x, "y_m": y, "heading_deg": math.degrees(heading)}


def _duration(recording: Recording) -> float:
    if recording.result_time is not None and recording.goal_time is not None:
        return recording.result_time - recording.goal_time
    begin, end = recording.span
    return end - begin


def _estimate_error(recording: Recording) -> dict[str, float] | None:
    if len(recording.dock_in_odom) == 0 or len(recording.odom) == 0:
        return None
    time = recording.dock_in_odom[-1, 0]
    T_odom_dock = recording.dock_in_odom[-1, 1:4]
    T_estimate_base = compose(inverse(T_odom_dock), pose_at(recording.odom, time))
    T_true_base = pose_at(recording.truth, time)
    return error_of(compose(T_true_base, inverse(T_estimate_base)))


def _perception(recording: Recording) -> dict[str, Any]:
    images = recording.images
    span = float(images[-1, 0] - images[0, 0]) if len(images) > 1 else 0.0
    return {
        "frames": len(images),
        "detected": int(np.sum(images[:, 2])),
        "rate_hz": (len(images) - 1) / span if span > 0.0 else 0.0,
        "latency_ms": timing(1e3 * images[:, 3]),
    }


def timing(values: ArrayLike) -> dict[str, float]:
    """Median, 99th percentile and maximum; zeros when there is nothing to measure."""
    values = np.asarray(values, dtype=float)
    if values.size == 0:
        return {"median": 0.0, "p99": 0.0, "max": 0.0}
    return {"median": float(np.median(values)), "p99": float(np.percentile(values, 99)), "max": float(np.max(values))}
