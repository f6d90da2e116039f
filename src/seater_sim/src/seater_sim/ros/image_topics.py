"""What the camera sends."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from sensor_msgs.msg import CameraInfo, CompressedImage, Image

from seater_common.camera_model import CameraModel
from seater_sim.loop.simulator import SimulatedImage
from seater_sim.ros import messages
from seater_sim.ros.chair_topics import publisher

Pixels = NDArray[np.generic]


class ImageTopics:
    """Images are drawn only when someone listens."""

    def __init__(self) -> None:
        self.image = publisher("camera/color/image_raw", Image)
        self.compressed = publisher("camera/color/image_raw/compressed", CompressedImage)
        self.camera_info = publisher("camera/color/camera_info", CameraInfo)

    @property
    def wanted(self) -> bool:
        """Whether anybody listens to the images."""
        return any(topic.get_num_connections() > 0 for topic in (self.image, self.compressed))

    def publish(self, image: SimulatedImage) -> bool:
        """Image and camera_info; True when someone listens to the images."""
        assert image.camera is not None
        return self.send(image, image.render() if self.wanted else None, image.camera.model)

    def send(self, image: SimulatedImage, pixels: Pixels | None, told: CameraModel) -> bool:
        """The same with `pixels` drawn before (None: nobody listened), and with what camera_info says."""
        self.camera_info.publish(messages.camera_info_message(told, image))
        if pixels is None:
            return False
        assert image.camera is not None
        if self.image.get_num_connections() > 0:
            self.image.publish(messages.image_message(image, pixels))
        if self.compressed.get_num_connections() > 0:
            self.compressed.publish(messages.compressed_message(image, pixels, image.camera.settings))
        return True
