"""The camera's calibration, from ~camera or from the first camera_info beside the image."""

from __future__ import annotations

import rospy
from sensor_msgs.msg import CameraInfo

from seater_common.camera_model import CameraModel
from seater_common.params import ParameterError
from seater_nmpc.ocp.constraints.view import UNKNOWN_CAMERA

WAIT = 5.0  # [s] wall time for the first camera_info


def load_camera(*, rectified: bool) -> CameraModel | None:
    """The camera whose images perception takes; None, with a warning, when nobody says.

    ~camera: the mapping of a camera_info file. Without it the node waits for a message on `camera_info` beside `image`.

    Args:
        rectified: perception takes rectified images, so P counts.

    Raises:
        ParameterError: ~camera is no camera_info file.
    """
    values = rospy.get_param("~camera", None)
    if values is not None:
        camera = CameraModel.from_mapping(values, rospy.resolve_name("~camera"))
        return camera.rectified() if rectified else camera
    topic = info_topic(rospy.resolve_name("image"))
    rospy.loginfo("~camera is not set: waiting up to %.0f s for the calibration on %s", WAIT, topic)
    try:
        camera = from_message(rospy.wait_for_message(topic, CameraInfo, timeout=WAIT))
        return camera.rectified() if rectified else camera
    except (rospy.ROSException, ParameterError) as error:
        text = "no calibration of the camera (%s): %.2f rad to both sides are reckoned with. Set camera_file"
        rospy.logwarn(text, error, UNKNOWN_CAMERA)
        return None


def info_topic(image: str) -> str:
    """The topic that image_transport takes the calibration from."""
    return image.rpartition("/")[0] + "/camera_info"


def usable(message: CameraInfo) -> bool:
    """Whether it is the calibration of a camera."""
    try:
        from_message(message)
    except ParameterError:
        return False
    return True


def from_message(message: CameraInfo) -> CameraModel:
    """Raises ParameterError: not calibrated, or a distortion model that is not known."""
    return CameraModel.from_mapping(
        {
            "image_width": message.width,
            "image_height": message.height,
            "distortion_model": message.distortion_model,
            "camera_matrix": {"data": list(message.K)},
            "distortion_coefficients": {"data": list(message.D)},
            "rectification_matrix": {"data": list(message.R)},
            "projection_matrix": {"data": list(message.P)},
        },
        "camera_info",
    )
