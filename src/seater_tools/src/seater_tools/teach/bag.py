"""Teaching from a bag that ends while the chair stands docked."""

from __future__ import annotations

from pathlib import Path

from seater_common.params import ParameterError
from seater_tools.teach.teacher import Teacher


def hear_bag(path: Path, teacher: Teacher, odometry: str, detections: str) -> None:
    """All of its messages. `odometry`, `detections`: names of the topics.

    Raises ParameterError: it cannot be read, or has no messages on a topic.
    """
    import rosbag

    hears = {odometry.lstrip("/"): teacher.odometry, detections.lstrip("/"): teacher.detections}
    try:
        with rosbag.Bag(str(path)) as bag:
            known = {topic.lstrip("/"): topic for topic in bag.get_type_and_topic_info().topics}
            missing = [name for name in hears if name not in known]
            if missing:
                raise ParameterError(f"{path}: has no messages on {' and '.join(missing)}")
            for topic, message, _ in bag.read_messages(topics=[known[name] for name in hears]):
                hears[topic.lstrip("/")](message)
    except (OSError, rosbag.ROSBagException) as error:
        raise ParameterError(f"cannot read {path}: {error}") from error
