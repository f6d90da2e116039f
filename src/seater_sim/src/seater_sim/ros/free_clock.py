"""The clock on the wall, for nodes that run freely."""

from __future__ import annotations

import time


class WallClock:
    """ROS time that goes on evenly, whatever happens to the system's clock."""

    def __init__(self) -> None:
        self._offset_ns = time.time_ns() - time.monotonic_ns()

    @property
    def now_ns(self) -> int:
        """Nanoseconds since 1970."""
        return time.monotonic_ns() + self._offset_ns

    def sleep_until(self, time_ns: int) -> None:
        """Returns at once when it is past."""
        left = time_ns - self.now_ns
        if left > 0:
            time.sleep(1e-9 * left)
