"""The panel's node: what the web server needs, out of ROS."""

from __future__ import annotations

import threading
import time
from typing import Any

import rospy

from seater_common.geometry import Chair, Dock
from seater_panel.hold.driver import Driver
from seater_panel.hold.hold import Hold
from seater_panel.ros.chair import RosChair
from seater_panel.ros.image import ImageFeed
from seater_panel.ros.listen import Listener
from seater_panel.view.model import view
from seater_panel.web.check import Check
from seater_panel.web.frames import Frames
from seater_panel.web.panel import Panel

# [s] A button counts as held so long after the last proof that it is: the chair has stopped being driven 0.3 s after
# the button was let go or the connection broke, with 0.08 s for the way through ROS. Longer than one answer of a page
# takes over a wireless network (0.02 to 0.1 s).
HOLD_TIMEOUT = 0.22
PERIOD = 0.02  # [s] of hold_to_run
VIEW_PERIOD = 0.08  # [s] several pages share one view


class PanelNode:
    """`act` False: it publishes nothing and gives no goals."""

    def __init__(self, chair: Chair, dock: Dock, *, gate: str, act: bool, check: Check) -> None:
        self._chair, self._dock = chair, dock
        self._listener = Listener(chair.camera)
        self._view: tuple[float, dict[str, Any]] = (float("-inf"), {})
        self._changed = threading.Event()
        hold, frames = Hold(HOLD_TIMEOUT), Frames()
        self._driver = Driver(hold, RosChair(gate)) if act else None
        self.panel = Panel(
            hold=hold,
            driver=self._driver,
            frames=frames,
            view=self.view,
            changed=self._changed.set,
            check=check,
        )
        ImageFeed(frames.wanted, self._offer)
        if self._driver is not None:
            rospy.on_shutdown(self._end)
            threading.Thread(target=self._pump, args=(self._driver,), name="pump", daemon=True).start()

    def view(self) -> dict[str, Any]:
        """What the pages show."""
        now = time.monotonic()
        if now - self._view[0] >= VIEW_PERIOD:
            self._view = now, view(self._listener.heard(), self._chair, self._dock, now)
        return self._view[1]

    def _offer(self, jpeg: bytes) -> None:
        self.panel.frames.offer(jpeg)
        self._listener.note(image=time.monotonic())

    def _pump(self, driver: Driver) -> None:
        """If this thread ends or hangs, `hold_to_run` falls silent: the gate takes that as let go. So nothing in it may
        wait for anybody."""
        while not rospy.is_shutdown():
            self._changed.wait(PERIOD)
            self._changed.clear()
            try:
                driver.step(time.monotonic())
            except rospy.ROSException:  # a publisher was closed by the shutdown
                return
            except Exception as error:  # whatever it is: the button counts as let go, and the panel says so
                rospy.logerr_throttle(1.0, "panel: %s: %s", type(error).__name__, error)
                self.panel.hold.end(f"internal error: {error}")

    def _end(self) -> None:
        assert self._driver is not None
        self._driver.stop(time.monotonic())
        time.sleep(PERIOD)  # for the words to leave
