"""Teaching from a bag that ends while the chair stands docked."""

from __future__ import annotations

from pathlib import Path

from seater_common.bags import open_bag
from seater_common.params import ParameterError
from seater_tools.teach.teacher import Teacher


def hear_bag(path: Path, teacher: Teacher, odometry: str, detections: str) -> None:
    """All of its messages. `odometry`, `detections`: names of the topics.

    Raises ParameterError: it cannot be read, or has no messages on a topic.
    """
    hears = {odometry.lstrip("/"): teacher.odometry, detections.lstrip("/"): teacher.detections}
    with open_bag(path, ParameterError) as bag:
        bag.require(hears)
        for topic, message, _ in bag.messages(hears):
            hears[topic](message)
