"""The state of the stream on /diagnostics."""

from __future__ import annotations

import time

from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper

from seater_camera.clock.stamps import Stamper
from seater_camera.frames import Clock
from seater_camera.stream import Stream
from seater_common.command.typed import as_typed

_NOT_CALIBRATED = "not calibrated: ./seater calibrate camera, then camera_file:=FILE"
_MANY = 0.02  # share of images that the camera leaves out, from which on it is said


def write_status(status: DiagnosticStatusWrapper, stream: Stream, stamper: Stamper) -> DiagnosticStatusWrapper:
    """One line in words, then the numbers."""
    health = stream.health
    report = health.report(time.monotonic())
    failed, complaint = health.complaint(report)
    if complaint:
        status.summary(DiagnosticStatus.ERROR if failed else DiagnosticStatus.WARN, complaint)
    elif report.dropped > _MANY * (report.rate + report.dropped):
        status.summary(DiagnosticStatus.WARN, "the camera leaves images out: USB 3, its own port, a smaller format?")
    elif stream.lens_origin == "none":
        status.summary(DiagnosticStatus.WARN, as_typed(_NOT_CALIBRATED))
    elif not stream.exposure_works:
        status.summary(DiagnosticStatus.WARN, "the camera does not take its exposure: set exposure/mode to device")
    elif stream.exposure is not None and stream.exposure.too_dark:
        status.summary(DiagnosticStatus.WARN, "too dark: more light, more gain, or a longer exposure/longest")
    else:
        status.summary(DiagnosticStatus.OK, "working")
    status.add("rate [Hz]", f"{report.rate:.1f}")
    status.add("delay, exposure to publication, median [ms]", f"{1e3 * report.delay:.1f}")
    status.add("images left out by the camera", str(report.dropped))
    status.add("images left out since start", str(health.total_dropped))
    status.add("images since start", str(health.total_images))
    status.add("opened", f"{health.connections} times")
    status.add("calibration", stream.lens_origin)
    status.add("clock", stamper.clock.value if stamper.clock is not None else "not known yet")
    if stamper.clock is Clock.DEVICE:
        status.add("drift against the camera's clock [ppm]", f"{1e6 * stamper.device.drift:.1f}")
        status.add("leaps of the camera's clock", str(stamper.device.restarts))
    for refusal, count in sorted(health.total_refused.items(), key=lambda item: item[0].name):
        status.add(f"not published since start, {refusal.value}", str(count))
    if stream.exposure is not None:
        status.add("exposure [ms]", f"{1e3 * stream.exposure.time:.2f}")
        status.add("white that is cut off [%]", f"{100.0 * stream.exposure.clipped:.1f}")
    return status
