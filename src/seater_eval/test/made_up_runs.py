"""Rows as the campaign makes them, without a run."""


def synthetic_run(**changes: object) -> dict:
    run = {
        "index": 0,
        "start": [-2.0, 0.0, 0.0],
        "docked": True,
        "result": "SUCCESS",
        "text": "",
        "retries": 0,
        "docking_time_s": 12.0,
        "minimum_time_s": 10.0,
        "position_error_m": 0.001,
        "heading_error_deg": 0.1,
        "collisions": 0,
        "min_clearance_m": 0.15,
        "limits_violated": False,
        "excess_speed": 0.0,
        "excess_bay_speed": 0.0,
        "excess_request": 0.0,
        "started_in_view": True,
        "out_of_view_s": 0.0,
        "solver_failures": 0,
        "solve_ms": 1.0,
        "path": [[-2.0, 0.0, 0.0], [0.0, 0.0, 0.0]],
    }
    for law in ("park_kuipers", "pbvs"):
        run[law] = {"docking_time_s": 14.0, "min_clearance_m": 0.1, "docked": True}
    return run | changes
