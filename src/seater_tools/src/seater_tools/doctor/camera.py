"""The camera: its calibration against its images, its place by TF, its exposure."""

from __future__ import annotations

import math

import numpy as np

from seater_common.camera_model import CameraModel
from seater_tools.doctor.observations import NOT_RUNNING, Observations
from seater_tools.doctor.verdict import Verdict, good, unknown, wrong

SAME_PLACE, SAME_ANGLE = 0.002, math.radians(0.2)  # [m], [rad] what rounding in a robot description explains
SAME_FOCUS = 0.01  # of the focal length: calibrations of one lens agree to 0.3 %
# As perception's own warning: from so much on, edges move inwards and photometric fits are dropped.
MOST_CUT_OFF = 0.3
LEAST_CONTRAST = 40.0  # [grey levels] white less black; noise of 2 levels then costs a tenth of a pixel at corners


def camera_info(observations: Observations) -> Verdict:
    """It is a calibration, of images of the size that comes, and the file's."""
    name, live = "camera_info", observations.live
    if live is None:
        return unknown(name, NOT_RUNNING)
    seen, file = live.pictures, observations.setup.camera
    if seen.info_error:
        remedy = "./seater calibrate camera, and give the file to the camera driver (camera_info_url)"
        return wrong(name, f"no calibration: {' '.join(seen.info_error.split())}", remedy)
    if seen.info is None:
        return unknown(name, "nothing arrives")
    if seen.size is not None and not seen.sizes_agree:
        text = f"says {seen.info.width} x {seen.info.height}, images are {seen.size[0]} x {seen.size[1]}"
        return wrong(name, text, "calibrate at the size that is used, or set the camera driver to the calibrated size")
    if file is not None and not _one_lens(seen.info, file):
        text = f"{seen.info.K[0, 0]:.0f} px of {seen.info.width}; the file: {file.K[0, 0]:.0f} px of {file.width}"
        return wrong(
            name, f"is not the calibration of the file: focal length {text}", "use one calibration in both places"
        )
    return good(name, f"{seen.info.width} x {seen.info.height}, {seen.info.K[0, 0]:.0f} px")


def _one_lens(a: CameraModel, b: CameraModel) -> bool:
    same_size = (a.width, a.height) == (b.width, b.height)
    return same_size and bool(np.all(np.abs(a.K[:2] - b.K[:2]) <= SAME_FOCUS * b.K[0, 0]))


def transform(observations: Observations) -> Verdict:
    """TF says of the camera's place what chair.yaml says."""
    name, live, chair = "camera in TF", observations.live, observations.setup.chair
    if live is None:
        return unknown(name, NOT_RUNNING)
    if chair is None:
        return unknown(name, "the chair's file is not in order")
    if not live.pictures.frame:
        return unknown(name, "no image arrives")
    if live.T_base_optical is None:
        text = f"no transform from base_link to {live.pictures.frame}, the frame of the images"
        return wrong(name, text, "optical_frame of wheelchair.launch must be the frame_id of the images")
    off = np.linalg.inv(chair.camera.T_base_optical()) @ live.T_base_optical
    way = float(np.linalg.norm(off[:3, 3]))
    turn = math.acos(max(-1.0, min(1.0, 0.5 * (float(np.trace(off[:3, :3])) - 1.0))))
    text = f"{1000 * way:.0f} mm and {math.degrees(turn):.1f} deg from chair.yaml"
    if way > SAME_PLACE or turn > SAME_ANGLE:
        return wrong(
            name, text, "let one place say it: publish_camera_tf:=false with a robot description, or correct it"
        )
    return good(name, "as chair.yaml says")


def exposure(observations: Observations) -> Verdict:
    """White paper is neither cut off nor dark."""
    name, live = "exposure", observations.live
    if live is None:
        return unknown(name, NOT_RUNNING)
    cut_off, contrast = live.pictures.cut_off, live.pictures.contrast
    if cut_off is None or contrast is None:
        return unknown(name, "no marker of the dock is in view")
    text = f"{100 * cut_off:.0f} % of the markers' white is cut off, contrast {contrast:.0f} grey levels"
    if cut_off > MOST_CUT_OFF:
        return wrong(name, text, "shorten the exposure or lower the gain, until white paper is grey (200 of 255)")
    if contrast < LEAST_CONTRAST:
        return wrong(name, text, "lengthen the exposure, add light, or clean lens and prints")
    return good(name, text)
