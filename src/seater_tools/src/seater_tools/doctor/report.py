"""Verdicts for the terminal, as JSON, and with what a support needs in one zip file."""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Sequence

import numpy as np

from seater_common.command.typed import as_typed
from seater_tools.doctor.observations import Observations
from seater_tools.doctor.verdict import Verdict

MARKS = {True: "\u2714", False: "\u2718", None: "-"}  # tick, cross
KINDS = {True: "ok", False: "wrong", None: "not judged"}


def describe(verdicts: Sequence[Verdict]) -> str:
    """One line for each, the remedy behind an arrow; a sum at the end."""
    width = max(len(verdict.name) for verdict in verdicts)
    lines = [
        f"{MARKS[v.ok]} {v.name:<{width}}  {v.what}" + (f"  -> {as_typed(v.remedy)}" if v.remedy else "")
        for v in verdicts
    ]
    return "\n".join([*lines, "", summary(verdicts)])


def summary(verdicts: Sequence[Verdict]) -> str:
    """How many of each kind."""
    counts = [sum(v.ok is kind for v in verdicts) for kind in (True, False, None)]
    return f"{counts[0]} in order, {counts[1]} wrong, {counts[2]} not judged"


def as_json(verdicts: Sequence[Verdict], observations: Observations) -> str:
    """docs/how-to/check_the_installation.md describes it."""
    content = {
        "ok": all(verdict.ok is not False for verdict in verdicts),
        "running": observations.live is not None,
        "versions": dict(observations.machine.versions),
        "checks": [
            {"name": v.name, "result": KINDS[v.ok], "what": v.what, "remedy": as_typed(v.remedy)} for v in verdicts
        ],
    }
    return json.dumps(content, indent=1)


def support_zip(verdicts: Sequence[Verdict], observations: Observations) -> bytes:
    """Files of configuration as they are, results, versions, and a short record of the topics."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("doctor.txt", describe(verdicts) + "\n")
        archive.writestr("doctor.json", as_json(verdicts, observations) + "\n")
        for role, file in observations.files.items():
            archive.writestr(f"config/{role}.yaml", f"# {file.path} {file.error}".rstrip() + f"\n{file.text}")
        archive.writestr("topics.json", json.dumps(_topics(observations), indent=1) + "\n")
        for name, rows in _records(observations).items():
            table = io.StringIO()
            np.savetxt(table, rows, delimiter=",", fmt="%.6f")
            archive.writestr(f"record/{name}.csv", table.getvalue())
    return stream.getvalue()


def _topics(observations: Observations) -> dict[str, object]:
    live = observations.live
    if live is None:
        return {}
    return {
        role: {
            "topic": t.name,
            "senders": t.publishers,
            "listeners": t.listeners,
            "messages": len(t.arrivals),
            "seconds": live.duration,
        }
        for role, t in live.topics.items()
    }


def _records(observations: Observations) -> dict[str, np.ndarray]:
    """Stamp and arrival of each message; odometry; corners of the markers: stamp, id, eight coordinates."""
    live = observations.live
    if live is None:
        return {}
    times = {
        f"{role}_times": np.column_stack([t.stamps, t.arrivals]) for role, t in live.topics.items() if len(t.arrivals)
    }
    corners = [[s.stamp, m.id, *m.corners.ravel()] for s in live.sights for m in s.markers]
    tables = {"odometry": live.odometry, "corners": np.array(corners).reshape(-1, 10)}
    return times | {name: rows for name, rows in tables.items() if len(rows)}
