"""Shadow mode, for recorded data: what the controller would have done towards the dock that is seen, without a goal."""

from __future__ import annotations

from seater_nmpc.control.command import Command
from seater_nmpc.control.controller import DockingController
from seater_nmpc.observe.observer import DockObserver


class Shadow:
    """Runs the controller in every cycle in which the dock is known. The observer is to acquire while moving, too."""

    def __init__(self, controller: DockingController, observer: DockObserver, max_age: float) -> None:
        """`max_age`: age of the dock's estimate beyond which nothing is computed [s]."""
        self._controller, self._observer, self._max_age = controller, observer, max_age

    def update(self, now: float) -> Command | None:
        """The command that would have been sent at message time `now` [s]; None while the dock is not known."""
        chair, estimate = self._observer.odometry.at(now), self._observer.estimate(now)
        if chair is None or estimate is None or estimate.age > self._max_age:
            self._controller.reset()
            return None
        self._controller.reset_commands()  # the recorded chair does not obey: every plan begins with its measured speed
        return self._controller.command(chair.pose, (chair.v, chair.omega), estimate.pose, "dock", now)
