"""Why images were not used, in words that name a remedy."""

from __future__ import annotations

import math
from collections import Counter

from seater_nmpc.observe.innovation import Innovation, Outcome

_TEXTS = {
    Outcome.EMPTY: "show no marker of the dock (out of view, covered, too dark or too far)",
    Outcome.FLIP: "show a dock that does not stand on the floor (check the camera's mount in chair.yaml)",
    Outcome.INVALID: "have a pose that is not finite or without covariance",
    Outcome.STALE: "came too late (check the camera's latency and time stamps)",
    Outcome.NO_ODOMETRY: "have a time for which there is no odometry (check the clocks of camera and odometry)",
    Outcome.ACQUIRING: "do not agree yet, or came while the chair was moving",
    Outcome.WAITING: "wait for the odometry of their time",
    Outcome.FROZEN: "show exactly the same though the wheels have turned (do camera or driver repeat old images?)",
    Outcome.UNCERTAIN: "are too uncertain by their own covariance (markers too small in the image, or too far)",
}


def why_unused(outcomes: Counter[Outcome], rejected: Innovation | None) -> str:
    """`outcomes` of the images since the last used one; `rejected`: the newest one outside the gate."""
    total = sum(outcomes.values())
    if total == 0:
        return "no image came"
    parts = [f"{count} {_TEXTS[outcome]}" for outcome, count in outcomes.most_common() if outcome in _TEXTS and count]
    outside = outcomes[Outcome.GATE] + outcomes[Outcome.ELSEWHERE]
    if outside:
        parts.insert(0, f"{outside} show the dock but were rejected{_how_far(rejected)}")
    return f"of {total} images " + ", ".join(parts)


def _how_far(innovation: Innovation | None) -> str:
    if innovation is None:
        return ""
    x, y, heading = (float(value) for value in innovation.value)
    off = f"{1e3 * math.hypot(x, y):.0f} mm and {math.degrees(abs(heading)):.1f} deg"
    return f" as they show it {off} from where it was (did it move? does the odometry tell the truth?)"
