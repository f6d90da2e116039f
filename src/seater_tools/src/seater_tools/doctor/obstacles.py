"""The sensor of obstacles, where the launch file has one."""

from __future__ import annotations

from seater_tools.doctor.observations import NOT_RUNNING, Observations
from seater_tools.doctor.verdict import Verdict, good, unknown, wrong

NAME = "obstacle sensor"
TIMEOUT = 0.5  # [s] obstacle_timeout where safety.yaml does not say it
OFTEN = 2.0  # messages within that time: one may be lost
FEWEST = 3  # messages from which a rate can be told


def sensor(observations: Observations) -> Verdict:
    """It is seen by: somebody sends, the measurements can be placed, and they come as often as the gate wants."""
    live = observations.live
    if live is None:
        return unknown(NAME, NOT_RUNNING)
    seen = live.obstacles
    if seen is None:
        return unknown(NAME, "none (obstacle_sensor:=none): nothing looks for people and obstacles")
    silent = [topic.name for topic in seen.topics if not topic.publishers]
    if silent:
        remedy = "start the sensor's driver, or remap obstacle_finder's topic (docs/how-to/see_obstacles.md)"
        return wrong(NAME, f"nobody sends {' and '.join(silent)}", remedy)
    names = " and ".join(topic.name for topic in seen.topics) or "any sensor"
    if not seen.topics or len(seen.arrivals) == 0:
        remedy = "look at its driver, and at the log of the node obstacle_finder"
        return wrong(NAME, f"{seen.kind}: obstacle_finder hears nothing of {names}", remedy)
    if seen.blocked:
        remedy = "TF has to connect its frame with base_link and odom at its stamps (docs/how-to/see_obstacles.md)"
        return wrong(NAME, f"{seen.kind}: sees nothing: {seen.blocked}", remedy)
    safety = observations.files["safety"].values if "safety" in observations.files else None
    timeout = float(safety.get("obstacle_timeout", TIMEOUT)) if isinstance(safety, dict) else TIMEOUT
    if len(seen.arrivals) < FEWEST or not seen.arrivals[-1] > seen.arrivals[0]:
        rate = len(seen.arrivals) / live.duration
    else:
        rate = (len(seen.arrivals) - 1) / float(seen.arrivals[-1] - seen.arrivals[0])
    text = f"{seen.kind}, {rate:.0f} Hz of {names}"
    if rate < OFTEN / timeout:
        remedy = "a faster sensor or computer, or a larger stride in obstacles.yaml; else the gate stops the chair"
        return wrong(NAME, f"{text}, {OFTEN / timeout:.0f} are needed", remedy)
    return good(NAME, text)
