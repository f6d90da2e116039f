"""Bags, read in one way."""

from __future__ import annotations

from pathlib import Path
from random import Random

import pytest

from seater_common.bags import open_bag

rosbag = pytest.importorskip("rosbag")
import rospy  # noqa: E402
from std_msgs.msg import Bool, Float64  # noqa: E402


def bag(folder: Path, messages: int = 1) -> Path:
    path = folder / "run.bag"
    with rosbag.Bag(str(path), "w") as out:
        for i in range(messages):
            out.write("/contact", Bool(True), rospy.Time(1, i))
            out.write("speed", Float64(0.5), rospy.Time(2, i))
    return path


def test_topics_are_found_with_and_without_a_slash(tmp_path: Path) -> None:
    with open_bag(bag(tmp_path), ValueError) as file:
        file.require(["contact", "/speed"])
        assert [(topic, message.data) for topic, message, _ in file.messages(["/speed", "contact", "lost"])] == [
            ("contact", True),
            ("speed", 0.5),
        ]
        assert list(file.messages(["lost"])) == list(file.raw(["lost"])) == []  # not all of them
        with pytest.raises(ValueError, match=r"run\.bag: has no messages on lost and /gone"):
            file.require(["lost", "speed", "/gone"])


def test_raw_messages_have_their_definition(tmp_path: Path) -> None:
    with open_bag(bag(tmp_path), ValueError) as file:
        (raw,) = file.raw(["contact"])
    assert (raw.topic, raw.kind, raw.data) == ("/contact", "std_msgs/Bool", b"\x01")
    assert raw.connection["message_definition"] == Bool._full_text


def test_other_files_are_no_bags(tmp_path: Path) -> None:
    path = tmp_path / "panel.png"
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + bytes(100))
    with pytest.raises(ValueError, match=r"cannot read the bag .*panel\.png: is no bag"), open_bag(path, ValueError):
        pass


def test_a_damaged_bag_is_named(tmp_path: Path) -> None:
    """Bytes that were turned round make rosbag stumble over numbers, names and sizes of its own."""

    class NamedError(Exception):
        pass

    path, named = bag(tmp_path, 30), 0
    content, random = path.read_bytes(), Random(1)
    for _ in range(30):
        damaged = bytearray(content)
        for _ in range(3):
            damaged[random.randrange(13, len(damaged))] = random.randrange(256)
        path.write_bytes(damaged)
        try:
            with open_bag(path, NamedError) as file:
                list(file.messages(["speed", "contact"]))
        except NamedError:
            named += 1
    assert named > 10


@pytest.mark.parametrize("kept", [0, 100, 0.6])
def test_what_cannot_be_read_is_named(tmp_path: Path, kept: float) -> None:
    path = bag(tmp_path, 300)
    content = path.read_bytes()
    path.write_bytes(content[: int(kept * len(content)) if isinstance(kept, float) else kept])
    with pytest.raises(ValueError, match=r"cannot read the bag .*run\.bag: "), open_bag(path, ValueError) as file:
        list(file.messages(["speed"]))
    with pytest.raises(KeyError), open_bag(tmp_path / "nowhere.bag", KeyError):
        pass


def test_an_error_of_the_caller_stays_what_it_is(tmp_path: Path) -> None:
    with pytest.raises(OSError, match="disk full"), open_bag(bag(tmp_path), ValueError):
        raise OSError("disk full")
