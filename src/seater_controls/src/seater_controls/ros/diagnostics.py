"""An entry on /diagnostics, once per second of wall time."""

from __future__ import annotations

from collections.abc import Callable

import diagnostic_updater
import rospy
from diagnostic_msgs.msg import DiagnosticStatus


class Entry:
    """`state`: level (of DiagnosticStatus), and what holds in words."""

    def __init__(self, name: str, hardware: str, state: Callable[[], tuple[int, str]]) -> None:
        self._state = state
        self._updater = diagnostic_updater.Updater()
        self._updater.setHardwareID(hardware)
        self._updater.add(name, self._write)

    def update(self) -> None:
        """Call it often; it goes out in its own period."""
        if not rospy.is_shutdown():
            self._updater.update()

    def _write(self, status: diagnostic_updater.DiagnosticStatusWrapper) -> diagnostic_updater.DiagnosticStatusWrapper:
        status.summary(*self._state())
        return status


OK, WARN, ERROR = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR
