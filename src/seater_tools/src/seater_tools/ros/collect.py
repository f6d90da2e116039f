"""Views of a board from a camera topic, with live guidance in the terminal."""

from __future__ import annotations

import threading
from pathlib import Path

import cv2
import numpy as np
import rospy
from cv_bridge import CvBridge, CvBridgeError
from numpy.typing import NDArray
from sensor_msgs.msg import Image

from seater_tools.board.board import Board
from seater_tools.lens.coverage import differs, missing_views
from seater_tools.lens.find import View, find_board
from seater_tools.ros.master import require_master

STILL = 0.003  # of the image's width between two images: the board is held still
PAUSE = 0.1  # [s] between two images that are looked at


class Collector:
    """Keeps each image with a view that is new and still. ROS-free but for the message: `look` takes a grey image."""

    def __init__(self, board: Board, folder: Path) -> None:
        self.views: list[View] = []
        self.missing: list[str] = []
        self._board, self._folder, self._last = board, folder, View("", np.zeros(0, dtype=np.intp), np.zeros((0, 2)))
        folder.mkdir(parents=True, exist_ok=True)

    def look(self, image: NDArray[np.uint8]) -> bool:
        """Whether it was kept, as a PNG in the folder; `missing` then says what is still missing."""
        view = find_board(image, self._board, f"view_{len(self.views):03d}.png")
        if view is None:
            return False
        last, self._last, size = self._last, view, (image.shape[1], image.shape[0])
        if not _still(view, last, size[0]) or not differs(view, self.views, self._board, size):
            return False
        cv2.imwrite(str(self._folder / view.name), image)
        self.views.append(view)
        self.missing = missing_views(self.views, self._board, size, None)
        return True


def collect_views(topic: str, board: Board, folder: Path) -> None:
    """Until nothing is missing, or Ctrl-C; prints what is. Raises FileExistsError: the folder holds views already."""
    if folder.is_dir() and any(folder.iterdir()):
        raise FileExistsError(f"{folder} holds images already; move them away, or give the folder as --images")
    require_master("the camera's driver (camera.launch)")
    rospy.init_node("calibrate_camera", anonymous=True)
    collector, bridge, newest, lock = Collector(board, folder), CvBridge(), list[Image](), threading.Lock()

    def take(message: Image) -> None:
        with lock:
            newest[:] = [message]

    rospy.Subscriber(topic, Image, take, queue_size=1, buff_size=2**25)
    print(f"waiting for the board on {rospy.resolve_name(topic)}; Ctrl-C ends it")
    while not rospy.is_shutdown():
        with lock:
            message = newest.pop() if newest else None
        try:
            if message is not None and collector.look(np.asarray(bridge.imgmsg_to_cv2(message, "mono8"))):
                print(f"{len(collector.views)} views. Next: {collector.missing[0] if collector.missing else 'done'}")
                if not collector.missing:
                    return
        except CvBridgeError as error:
            rospy.logerr_throttle(5.0, "%s", error)
        rospy.rostime.wallsleep(PAUSE)


def _still(view: View, last: View, width: int) -> bool:
    _, mine, its = np.intersect1d(view.ids, last.ids, return_indices=True)
    if not len(mine):
        return False
    moved = np.linalg.norm(view.corners[mine] - last.corners[its], axis=1)
    return float(np.median(moved)) < STILL * width
