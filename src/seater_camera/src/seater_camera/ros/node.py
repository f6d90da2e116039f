"""The node round the stream: image_raw and camera_info out, diagnostics once per second."""

from __future__ import annotations

import threading
import time

import diagnostic_updater
import numpy as np
import rospy
from diagnostic_msgs.msg import DiagnosticArray
from numpy.typing import NDArray
from sensor_msgs.msg import CameraInfo, Image
from std_msgs.msg import Header

from seater_camera.clock.stamps import Stamper
from seater_camera.ros.diagnostics import write_status
from seater_camera.ros.messages import clipped_white, image_message, info_message
from seater_camera.settings import CameraSettings
from seater_camera.sources.kinds import make_source
from seater_camera.stream import Stream
from seater_common.camera_model import CameraModel
from seater_common.params import ParameterError, load


class CameraNode:
    """Private parameters: ~source (v4l2, realsense, recorded), ~settings (config/camera.yaml), ~calibration (a
    camera_info file's content; without it the device's own), ~frame (optical frame). Topics: image_raw, camera_info.
    """

    def __init__(self) -> None:
        """Raises ParameterError, naming the key."""
        if rospy.get_param("/use_sim_time", False):
            raise ParameterError(
                "/use_sim_time is true: a camera's time is no simulated one (rosparam set use_sim_time false)"
            )
        settings = load(CameraSettings, rospy.get_param("~settings", None), rospy.resolve_name("~settings"))
        self._frame = rospy.get_param("~frame", "camera_color_optical_frame")
        source = make_source(rospy.get_param("~source", ""), settings)
        self._stamper = Stamper(settings.clock, wall=lambda: rospy.Time.now().to_sec())
        self._stream = Stream(source, settings, self._stamper, self._publish, lens=_calibration(settings))
        self._images = rospy.Publisher("image_raw", Image, queue_size=1, tcp_nodelay=True)
        # An image without its camera_info is lost: while an image may be left out for a newer one, those wait.
        self._infos = rospy.Publisher("camera_info", CameraInfo, queue_size=10, tcp_nodelay=True)
        self._updater = diagnostic_updater.Updater()
        self._updater.setHardwareID(source.name)
        self._updater.add("camera", lambda status: write_status(status, self._stream, self._stamper))
        self._timer = rospy.Timer(rospy.Duration(1.0), lambda _: self._updater.update())
        self._told = rospy.Subscriber("/diagnostics", DiagnosticArray, self._on_diagnostics, queue_size=10)
        self._thread = threading.Thread(target=self._run, daemon=True)
        rospy.on_shutdown(self._end)
        rospy.loginfo("camera node: %s", source.name)
        self._thread.start()

    def _run(self) -> None:
        """What nobody has thought of ends the node, which is started anew: better than silence."""
        try:
            self._stream.run()
        except Exception as error:
            if not rospy.is_shutdown():
                rospy.logfatal("camera node: %s: %s", type(error).__name__, error)
                rospy.signal_shutdown("the camera's thread has failed")

    def _publish(self, image: NDArray[np.uint8], stamp: float, lens: CameraModel | None) -> None:
        header = Header(stamp=rospy.Time.from_sec(stamp), frame_id=self._frame)
        height, width = image.shape[:2]
        self._infos.publish(info_message(header, lens, width, height))
        self._images.publish(image_message(header, image))

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        clipped = clipped_white(message)
        if clipped is not None and self._stream.exposure is not None:
            self._stream.exposure.told(clipped, time.monotonic())

    def _end(self) -> None:
        self._stream.stop()
        self._thread.join(timeout=3.0)


def _calibration(settings: CameraSettings) -> CameraModel | None:
    """Raises ParameterError: it is none, or not of the size that is asked for; the message names both."""
    values = rospy.get_param("~calibration", None)
    if values is None:
        return None
    lens = CameraModel.from_mapping(values, rospy.resolve_name("~calibration"))
    wanted = settings.format
    if (lens.width, lens.height) != (wanted.width, wanted.height):
        raise ParameterError(
            f"{rospy.resolve_name('~calibration')}: is of {lens.width} x {lens.height} pixels, "
            f"{rospy.resolve_name('~settings')}/format asks for {wanted.width} x {wanted.height}"
        )
    return lens
