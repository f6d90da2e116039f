"""What became of the camera's images, for /diagnostics."""

from __future__ import annotations

import statistics
import threading
from collections import Counter, deque
from dataclasses import dataclass

from seater_camera.clock.stamps import Refusal

_SLOW = 0.8  # of the rate asked for, below which it is said
_LATEST = 120  # images of which delays and gaps are kept
_ENOUGH = 10  # gaps whose median is the camera's period; before, that of the rate asked for


@dataclass(frozen=True, kw_only=True)
class Report:
    """Of the time since the last one."""

    rate: float  # [Hz] of published images
    delay: float  # [s] from the exposure to the publication, median; 0: no images
    dropped: int  # images that the camera left out
    refused: dict[Refusal, int]
    trouble: str  # why there are no images; empty: there are
    silent: float  # [s] since the last image


class Health:
    """Written by the thread of the stream, read by another."""

    def __init__(self, rate: float, now: float) -> None:
        """`rate` [Hz] asked for; all times by one steady clock [s]."""
        self._asked, self._lock = rate, threading.Lock()
        self._since, self._last_image = now, now
        self._last_stamp: float | None = None  # of this connection
        self._images, self._dropped = 0, 0
        self._delays: deque[float] = deque(maxlen=_LATEST)
        self._gaps: deque[float] = deque(maxlen=_LATEST)
        self._refused: Counter[Refusal] = Counter()
        self._trouble = "the camera has not been opened yet"
        self.connections, self.total_images, self.total_dropped = 0, 0, 0
        self.total_refused: Counter[Refusal] = Counter()

    def connected(self) -> None:
        """The camera was opened."""
        with self._lock:
            self.connections += 1
            self._last_stamp, self._trouble = None, "the camera is open, no image has come yet"
            self._gaps.clear()

    def failed(self, reason: str) -> None:
        """No images, and why."""
        with self._lock:
            self._trouble = reason

    def published(self, stamp: float, delay: float, now: float) -> None:
        """An image went out, `delay` [s] after its exposure."""
        with self._lock:
            if self._last_stamp is not None:
                left_out = self._left_out(stamp - self._last_stamp)
                self._dropped += left_out
                self.total_dropped += left_out
            self._last_stamp, self._last_image, self._trouble = stamp, now, ""
            self._images += 1
            self.total_images += 1
            self._delays.append(delay)

    def _left_out(self, gap: float) -> int:
        """Images between two whose stamps differ by `gap` [s]: a camera may be slower than it is asked to be."""
        self._gaps.append(gap)
        period = statistics.median(self._gaps) if len(self._gaps) >= _ENOUGH else 1.0 / self._asked
        return max(0, round(gap / period) - 1)

    def refused(self, refusal: Refusal) -> None:
        """An image did not go out."""
        with self._lock:
            self._refused[refusal] += 1
            self.total_refused[refusal] += 1

    def report(self, now: float) -> Report:
        """Since the last report."""
        with self._lock:
            passed = max(now - self._since, 1e-3)
            report = Report(
                rate=self._images / passed,
                delay=statistics.median(self._delays) if self._delays else 0.0,
                dropped=self._dropped,
                refused=dict(self._refused),
                trouble=self._trouble,
                silent=now - self._last_image,
            )
            self._since, self._images, self._dropped = now, 0, 0
            self._delays.clear()
            self._refused.clear()
            return report

    def complaint(self, report: Report) -> tuple[bool, str]:
        """Whether it is an error, and in words what is wrong; empty: nothing."""
        if report.trouble:
            return True, report.trouble
        if report.rate == 0.0:
            why = max(report.refused, key=lambda refusal: report.refused[refusal], default=None)
            return True, f"no image for {report.silent:.1f} s" + ("" if why is None else f": each {why.value}")
        if report.rate < _SLOW * self._asked:
            return False, f"{report.rate:.1f} images per second, {self._asked:g} are asked for"
        return False, ""
