"""What became of the images: what they show, whether they contradict what is known, and in words why none was used."""

from __future__ import annotations

import math
import statistics
from collections import Counter, deque
from dataclasses import dataclass, replace
from itertools import pairwise

from seater_nmpc.observe.innovation import Fusion, Innovation, Outcome
from seater_nmpc.observe.measurement import Measurement, difference, distance
from seater_nmpc.observe.odometry.instant import Instant

_FIRST_DOUBTED = 3  # images by which a jump is told from one wrong image
_RATE_IMAGES = 9  # images from which their usual distance in time is taken
_LEFT_OPEN = 0.05  # weight of a pose, from which on its image leaves it open
_CONTRADICTING = (4, 0.25)  # images in a row, and time [s], after which images that are not believed contradict
_TEXTS = {
    Outcome.EMPTY: "show no marker of the dock (out of view, covered, too dark or too far)",
    Outcome.FLIP: "show a dock that does not stand on the floor (check the camera's mount in chair.yaml)",
    Outcome.INVALID: "have a pose that is not finite or without covariance",
    Outcome.STALE: "came too late (check the camera's latency and time stamps)",
    Outcome.NO_ODOMETRY: "have a time for which there is no odometry (check the clocks of camera and odometry)",
    Outcome.ACQUIRING: "do not agree yet, or came while the chair was moving",
    Outcome.WAITING: "wait for the odometry of their time",
    Outcome.FROZEN: "show exactly the same though the wheels have turned (do camera or driver repeat old images?)",
    Outcome.UNCERTAIN: "are too uncertain by their own covariance (markers too small in the image, or too far)",
}


@dataclass(frozen=True)
class Doubted:
    """An image that was not believed at first."""

    chair: Instant
    expected: Measurement  # the dock in odom as it was known, with what calibration leaves
    shown: list[Measurement]  # the poses of the dock in odom that it leaves open, the likeliest first
    gate: float  # squared Mahalanobis distance

    def agreeing(self, taken_up: Measurement) -> Doubted:
        """With those poses alone that agree with what was believed at last: the others were wrong."""
        known = taken_up.covariance + self.expected.covariance
        agree = [m for m in self.shown if distance(m.pose, taken_up.pose, m.covariance + known) <= self.gate]
        return replace(self, shown=agree)


@dataclass(frozen=True)
class Jump:
    """The dock was acquired anew, or may be, where images that were not believed at first show it; or they were taken
    for slip."""

    before: Instant  # the chair at the last image but one that was used
    left_open: list[Measurement]  # the other poses of the dock in odom that this one left open
    doubted: list[Doubted]  # the first of those that were not believed


class Images:
    """`show` it what an image shows of the dock, where it shows one; `note` what became of every image."""

    def __init__(self, duration: float) -> None:
        """`duration` [s]: for which it is kept what images show."""
        self._duration = duration
        self.shown: deque[tuple[Instant, list[Measurement]]] = deque()  # without those that were wrong, see `note`
        self.counts: Counter[Outcome] = Counter()  # since the begin
        self.restart()

    def restart(self) -> None:
        """The dock was forgotten."""
        self._stamps: deque[float] = deque(maxlen=_RATE_IMAGES)
        self._last_rejected: Innovation | None = None  # of the newest image, when it was outside the gate
        self._since_used: Counter[Outcome] = Counter()  # what became of the images since the last used one
        self._doubted = (0.0, 0.0)  # times of the first and the last image outside the gate since then [s]
        self._off: list[Doubted] = []  # the first of these images
        self._used: deque[tuple[Instant, list[Measurement]]] = deque(maxlen=2)  # used last, and their other poses
        self.jump: Jump | None = None  # the newest one

    def show(self, chair: Instant, offered: list[Measurement]) -> None:
        """An image shows the dock at one of these places."""
        self.shown.append((chair, offered))
        while self.shown[0][0].stamp < chair.stamp - self._duration:
            self.shown.popleft()

    def note(self, stamp: float, fusion: Fusion, *, as_expected: bool) -> None:
        """What became of the image taken at `stamp`. `as_expected`: it was believed by those who did not believe the
        ones before it. These were wrong then, not what is known of the chair, and no longer count as shown."""
        chair, offered = self.shown[-1] if self.shown else (None, [])
        self.counts[fusion.outcome] += 1
        self._since_used[fusion.outcome] += 1
        if not self._stamps or stamp > self._stamps[-1]:
            self._stamps.append(stamp)
        doubted = self._since_used[Outcome.GATE]
        if fusion.outcome is Outcome.GATE:
            self._last_rejected = fusion.innovation
            self._doubted = (stamp if doubted == 1 else self._doubted[0], stamp)
            if chair is not None and len(self._off) < _FIRST_DOUBTED:
                self._off += _doubted(chair, offered, fusion)
        elif fusion.outcome.accepted:
            if fusion.outcome is Outcome.ACQUIRED:
                self.jump = None
            elif doubted and fusion.outcome is Outcome.FUSED and as_expected:
                self._drop(*self._doubted)
            elif doubted:
                self.jump = self._taken_up(fusion.measurement)
            self._last_rejected, self._off = None, []
            if chair is not None:
                self._used.append((chair, _others(offered, fusion.measurement)))
            self._since_used.clear()

    def no_longer_waiting(self) -> None:
        """One that waited for the odometry of its time will be noted as what becomes of it."""
        self._since_used[Outcome.WAITING] -= 1

    @property
    def period(self) -> float:
        """Usual time between two images [s], whatever they show; 0 before there are three."""
        return statistics.median(b - a for a, b in pairwise(self._stamps)) if len(self._stamps) > 2 else 0.0

    @property
    def doubted(self) -> Jump | None:
        """What the first images show that were not believed since the last used ones; None: all were. Of these one
        alone may be wrong: after a way without images anything is believed."""
        return Jump(*self._used[0], list(self._off)) if self._used and self._off else None

    @property
    def contradict(self) -> bool:
        """Whether several images in a row show the dock where it cannot be: no chair should drive by what they say, nor
        by what is known without them."""
        count, duration = _CONTRADICTING
        return self._since_used[Outcome.GATE] >= count and self._doubted[1] - self._doubted[0] >= duration

    @property
    def unused(self) -> Counter[Outcome]:
        """What became of the images since the last one that was used."""
        return Counter(self._since_used)

    @property
    def why_unseen(self) -> str:
        """In words, why no image has been used of late."""
        total = sum(self._since_used.values())
        if total == 0:
            return "no image came, or none that perception could use (its diagnostics say why)"
        common = self._since_used.most_common()
        parts = [f"{count} {_TEXTS[outcome]}" for outcome, count in common if outcome in _TEXTS and count]
        outside = self._since_used[Outcome.GATE] + self._since_used[Outcome.ELSEWHERE]
        if outside:
            parts.insert(0, f"{outside} show the dock but were rejected{_how_far(self._last_rejected)}")
        return f"of {total} images " + ", ".join(parts)

    def _taken_up(self, measurement: Measurement | None) -> Jump | None:
        """By an image that was believed for this: those that agree with it; the others were wrong."""
        jump = self.doubted
        if jump is None or measurement is None:
            return None
        agreeing = [image.agreeing(measurement) for image in jump.doubted]
        return replace(jump, doubted=[image for image in agreeing if image.shown])

    def _drop(self, first: float, last: float) -> None:
        kept = [entry for entry in self.shown if not first <= entry[0].stamp <= last]
        self.shown.clear()
        self.shown.extend(kept)


def _doubted(chair: Instant, offered: list[Measurement], fusion: Fusion) -> list[Doubted]:
    off, likeliest = fusion.innovation, fusion.measurement
    if off is None or likeliest is None:
        return []
    expected = Measurement(difference(likeliest.pose, off.value), off.covariance - likeliest.covariance)
    return [Doubted(chair, expected, [likeliest, *_others(offered, likeliest)], off.gate)]


def _others(offered: list[Measurement], used: Measurement | None) -> list[Measurement]:
    """The poses that an image leaves open beside the one that was used."""
    return [m for m in offered if m is not used and m.weight >= _LEFT_OPEN]


def _how_far(innovation: Innovation | None) -> str:
    if innovation is None:
        return ""
    x, y, heading = (float(value) for value in innovation.value)
    off = f"{1e3 * math.hypot(x, y):.0f} mm and {math.degrees(abs(heading)):.1f} deg"
    return f" as they show it {off} from where it was (did it move? does the odometry tell the truth?)"
