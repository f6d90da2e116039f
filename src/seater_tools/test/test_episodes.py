"""A small bag for each docking: what is kept, when it is written, and how much disk it takes."""

from __future__ import annotations

import datetime
import io
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from seater_nmpc.sequence.goal.results import ResultCode
from seater_tools.episodes import disk
from seater_tools.episodes.episode import Episode, Episodes
from seater_tools.episodes.ring import Entry, Ring

NOON = datetime.datetime(2026, 11, 28, 12, 0, tzinfo=datetime.UTC)


def fill(ring: Ring, begin: float, end: float, size: int = 10) -> None:
    for time in np.arange(begin, end, 0.1):
        ring.add(Entry(float(time), "odom", size, None))


def span(episode: Episode | None) -> tuple[float, float]:
    assert episode is not None
    times = [entry.time for entry in episode.entries]
    assert times == sorted(times)
    return pytest.approx(times[0], abs=0.11), pytest.approx(times[-1], abs=0.11)  # type: ignore[return-value]


def test_an_episode_is_what_was_shortly_before_the_goal_until_shortly_after_its_result() -> None:
    ring = Ring(before=5.0, most=10**6)
    episodes = Episodes(ring, after=2.0)
    fill(ring, 0.0, 100.0)
    assert ring.size == pytest.approx(500, abs=20)  # nothing older is kept
    episodes.goes_on("a")
    fill(ring, 100.0, 130.0)
    episodes.result("a", "dock", int(ResultCode.MARKER_LOST), 130.0)
    fill(ring, 130.0, 131.0)
    assert episodes.due(131.0, NOON) is None
    fill(ring, 131.0, 132.2)
    episode = episodes.due(132.1, NOON)
    assert span(episode) == (95.0, 132.1)
    assert episode is not None and episode.name == "20261128T120000Z_dock_MARKER_LOST" and episode.dropped == 0
    episodes.goes_on("a")  # late feedback
    assert episodes.due(140.0, NOON) is None
    fill(ring, 132.2, 150.0)
    assert ring.size == pytest.approx(500, abs=20)


def test_a_goal_that_replaces_another_one_is_in_the_same_episode() -> None:
    ring = Ring(before=5.0, most=10**6)
    episodes = Episodes(ring, after=2.0)
    fill(ring, 0.0, 10.0)
    episodes.goes_on("a")
    episodes.goes_on("b")  # replaces it
    fill(ring, 10.0, 20.0)
    episodes.result("a", "dock", int(ResultCode.CANCELED), 20.0)
    assert episodes.due(30.0, NOON) is None  # b goes on
    fill(ring, 20.0, 32.5)
    episodes.result("b", "dock", 0, 30.0)
    episode = episodes.due(32.5, NOON)
    assert span(episode) == (5.0, 32.5) and episode is not None and episode.name.endswith("_dock_SUCCESS")


def test_a_goal_that_follows_a_result_ends_its_episode_and_begins_another_one() -> None:
    ring = Ring(before=5.0, most=10**6)
    episodes = Episodes(ring, after=2.0)
    fill(ring, 0.0, 10.0)
    episodes.goes_on("a")
    fill(ring, 10.0, 30.0)
    episodes.result("a", "dock", 0, 30.0)
    fill(ring, 30.0, 31.0)
    episodes.goes_on("b")
    assert span(episodes.due(31.0, NOON)) == (5.0, 31.0)
    fill(ring, 31.0, 60.0)
    episodes.result("b", "undock", 0, 60.0)
    fill(ring, 60.0, 62.2)
    episode = episodes.due(62.1, NOON)
    assert span(episode) == (26.0, 62.1) and episode is not None and episode.name.endswith("_undock_SUCCESS")


def test_memory_is_bounded_and_it_is_said_what_was_lost() -> None:
    ring = Ring(before=5.0, most=1000)
    episodes = Episodes(ring, after=1.0)
    episodes.goes_on("a")
    fill(ring, 0.0, 30.0)
    assert ring.size <= 1000
    episodes.result("a", "undock", 31337, 30.0)
    episode = episodes.due(31.0, NOON)
    assert episode is not None and episode.dropped == 200 and episode.name.endswith("_undock_31337")


def test_latched_messages_come_first_however_old_they_are() -> None:
    ring = Ring(before=5.0, most=10**6)
    for time, sender in ((0.0, "a"), (1.0, "a"), (1.0, "b")):
        ring.add(Entry(time, "/tf_static", 10, f"{sender}{time}"), sender)
    fill(ring, 20.0, 30.0)
    taken = list(ring.taken())
    assert [entry.item for entry in taken if entry.topic == "/tf_static"] == ["a1.0", "b1.0"]
    assert {entry.time for entry in taken[:2]} == {taken[2].time}


def test_a_clock_that_is_set_back_forgets_what_was() -> None:
    ring = Ring(before=5.0, most=10**6)
    fill(ring, 100.0, 110.0)
    fill(ring, 0.0, 1.0)
    assert max(entry.time for entry in ring.taken()) < 1.0


def test_the_folder_stays_small_and_files_of_others_stay(tmp_path: Path) -> None:
    names = [f"2026112{day}T120000Z_dock_SUCCESS.bag" for day in range(1, 6)]
    for name in [*names, "mine.bag", "20261101T120000Z_dock_x.bag.part"]:
        (tmp_path / name).write_bytes(bytes(100))
    removed = disk.make_room(tmp_path, 250)
    assert [path.name for path in removed] == names[:3] and (tmp_path / "mine.bag").exists()
    disk.remove_parts(tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == [*names[3:], "mine.bag"]
    assert disk.make_room(tmp_path, 1) == [tmp_path / names[3]]  # the newest stays
    assert disk.has_room(tmp_path, 1) and not disk.has_room(tmp_path, 10**18)


def test_the_bag_reads_as_what_was_sent(tmp_path: Path) -> None:
    rospy = pytest.importorskip("rospy")
    rosbag = pytest.importorskip("rosbag")
    from nav_msgs.msg import Odometry
    from sensor_msgs.msg import Image

    from seater_tools.ros.episodes import WIDTH, small_jpeg, write

    def sent(message: Any) -> Any:
        buffer, raw = io.BytesIO(), rospy.AnyMsg()
        message.serialize(buffer)
        raw._buff = buffer.getvalue()
        raw._connection_header = {
            "type": message._type, "md5sum": message._md5sum, "message_definition": message._full_text,
            "latching": "0", "callerid": "/wheels",
        }  # fmt: skip
        return raw

    odometry = Odometry()
    odometry.pose.pose.position.x = 1.5
    picture = Image(height=720, width=1280, encoding="bgr8", step=3840, data=bytes(720 * 3840))
    items = [("/odom", sent(odometry)), ("/detections/image/compressed", small_jpeg(picture))]
    entries = [Entry(10.0 + i, topic, len(item._buff), item) for i, (topic, item) in enumerate(items)]
    path = write(Episode(name="20261128T120000Z_dock_SUCCESS", entries=entries, dropped=0), tmp_path)
    assert list(tmp_path.iterdir()) == [path] and path.stat().st_size < 50_000
    with rosbag.Bag(str(path)) as bag:
        (_, first, at), (_, second, _) = list(bag.read_messages())
        assert at.to_sec() == 10.0 and first.pose.pose.position.x == 1.5 and first._type == "nav_msgs/Odometry"
        import cv2

        image = cv2.imdecode(np.frombuffer(second.data, np.uint8), cv2.IMREAD_COLOR)
        assert image.shape == (360, WIDTH, 3)
