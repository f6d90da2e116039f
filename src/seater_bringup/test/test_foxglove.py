"""The layout for Foxglove names topics and fields that there are."""

from __future__ import annotations

import importlib
import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[3]
LAYOUT = json.loads((ROOT / "src" / "seater_bringup" / "foxglove" / "docking.json").read_text())
REFERENCE = (ROOT / "docs" / "reference" / "interfaces.md").read_text()
# Of ROS itself, and parts of the actions.
OTHERS = {
    "rosout": "rosgraph_msgs/Log",
    "dock/feedback": "seater_msgs/DockActionFeedback",
    "dock/result": "seater_msgs/DockActionResult",
    "detections/image/compressed": "sensor_msgs/CompressedImage",  # docking_bags
}
KEYS = ("value", "topicPath", "imageTopic", "topicToRender")


def documented() -> dict[str, str]:
    """Topic to type, of the first table of the reference; without leading slashes."""
    rows = re.findall(r"^\| (`[^|]+?)(?: \(\d+\))? \| (\w+/\w+|visualization_msgs, geometry_msgs)\W", REFERENCE, re.M)
    return {name.lstrip("/"): kind for names, kind in rows for name in re.findall(r"`([^`]+)`", names)} | OTHERS


def named(value: Any) -> Iterator[str]:
    """Topics, with the fields behind them, wherever they stand in the layout."""
    if isinstance(value, dict):
        for key, entry in value.items():
            if key == "topics":
                yield from entry
            elif key in KEYS and isinstance(entry, str):
                yield entry
            else:
                yield from named(entry)
    elif isinstance(value, list):
        for entry in value:
            yield from named(entry)


def split(path: str) -> tuple[str, list[str]]:
    topic, *fields = path.lstrip("/").split(".")
    return topic, fields


PATHS = sorted(set(named(LAYOUT["configById"])))


def test_there_is_something_to_see() -> None:
    assert len(PATHS) > 25 and "/gate_state.reason" in PATHS


@pytest.mark.parametrize("path", PATHS)
def test_topic_and_field_exist(path: str) -> None:
    topic, fields = split(path)
    kinds = documented()
    if topic.startswith("scene/"):
        assert "scene/..." in kinds and not fields
        return
    assert topic in kinds, f"{topic} is not in docs/reference/interfaces.md"
    package, name = kinds[topic].split("/")
    message = getattr(importlib.import_module(f"{package}.msg"), name)()
    for field in fields:
        message = getattr(message, field)


def test_every_panel_is_in_the_layout_once() -> None:
    def panels(node: Any) -> Iterator[str]:
        if isinstance(node, str):
            yield node
        else:
            yield from panels(node["first"])
            yield from panels(node["second"])

    shown = list(panels(LAYOUT["layout"]))
    assert sorted(shown) == sorted(LAYOUT["configById"])
