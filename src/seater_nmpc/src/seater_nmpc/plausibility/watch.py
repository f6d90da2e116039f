"""All checks of one goal, cycle by cycle."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from seater_common.geometry import Chair, Dock
from seater_nmpc.drive.prediction import CommandHistory
from seater_nmpc.observe.images import Jump
from seater_nmpc.observe.innovation import Outcome
from seater_nmpc.observe.measurement import Hypothesis, MarkerSight
from seater_nmpc.observe.observer import DockObserver
from seater_nmpc.parameters import PlausibilityParameters
from seater_nmpc.plausibility.contradiction import Contradiction, Kind
from seater_nmpc.plausibility.image_motion import CLOCKS, Shown, contradiction, speeds_by_images
from seater_nmpc.plausibility.image_turn import turn_contradicts
from seater_nmpc.plausibility.installation_watch import InstallationWatch
from seater_nmpc.plausibility.jump import Shift, sudden
from seater_nmpc.plausibility.markers import Markers
from seater_nmpc.plausibility.obedience import Obedience

Array = NDArray[np.float64]

_CONFIRMED = (2, 3)  # so many of the last images must contradict the odometry: two wrong ones at once may do it once
_RECENT, _LATEST = 0.1, 0.4  # [s] age of an image that decides what a chair that stands is; longest wait for it


class Watch:
    """Begin it with each goal; then tell it what each cycle asks for, and `check`."""

    def __init__(
        self,
        chair: Chair,
        dock: Dock,
        observer: DockObserver,
        history: CommandHistory,
        parameters: PlausibilityParameters,
    ) -> None:
        self._observer, self._parameters = observer, parameters
        self._obedience = Obedience(history, chair.limits, parameters)
        self._middle = dock.front[:2]
        self._markers = Markers(chair.camera, dock, parameters)
        self.installation = InstallationWatch(chair, dock, observer.parameters, parameters)
        self._begun, self._compared = 0.0, -np.inf  # [s] begin of the goal; newest image that was compared
        self._suspected: deque[bool] = deque(maxlen=_CONFIRMED[1])  # whether the last images contradict the odometry
        self._acquired, self._known = 0, False  # how often the dock has been, and whether it was at the last image
        self._blocked: tuple[float, Contradiction] | None = None  # since when [s] it stands though asked to drive
        self._jump: Jump | None = None  # the newest one that was looked at
        self._shift: Shift | None = None  # how far the dock has jumped in this goal

    def begin(self, now: float) -> None:
        """A goal begins at message time `now` [s]."""
        self._jump, self._shift = self._observer.images.jump, None
        self._markers.restart()
        self.installation.seen.restart()
        self._look_anew(now)

    def resume(self, now: float) -> None:
        """A goal goes on after a pause, at message time `now` [s], wherever whoever has driven the chair to: what was
        found of the installation still holds."""
        self.installation.seen.interrupt()
        self._look_anew(now)

    def _look_anew(self, now: float) -> None:
        self._begun = now
        self._suspected.clear()
        self._blocked = None
        self._obedience.restart(now)
        self._acquired = self._observer.images.counts[Outcome.ACQUIRED]
        self._known = self._observer.estimate() is not None

    def see(self, hypotheses: Sequence[Hypothesis], sights: Sequence[MarkerSight]) -> None:
        """What an image shows: poses of the dock, and single markers where they are known."""
        self._markers.add(hypotheses, sights)

    def asked(self, stamp: float, v: float, omega: float) -> None:
        """What the cycle sends."""
        self._obedience.asked(stamp, v, omega)

    def check(self, now: float) -> Contradiction | None:
        """At message time `now` [s]."""
        self._note_jump()
        found = self._motion_in_images() or self._obedience.check(now, self._observer.odometry)
        if found is not None and found.kind is Kind.BLOCKED:
            self._blocked, found = self._blocked or (now, found), None
        return found or self._stands(now) or self._place() or self._markers.check()

    @property
    def waits(self) -> bool:
        """Whether the chair has to stand until images show which it is, blocked or its odometry frozen."""
        return self._blocked is not None

    def jumped(self) -> Contradiction | None:
        """Whether the dock has jumped in the images of this goal, so that where the chair stands is not sure."""
        return None if self._shift is None else Contradiction(Kind.INCONSISTENT, self._shift.text)

    def learn(self, *, turned: bool) -> None:
        """A docking has ended at the dock: remember what it has shown of the installation, unless the dock has jumped.
        `turned`: as of InstallationWatch."""
        if self._shift is None:
            self.installation.learn(turned=turned)

    def _note_jump(self) -> None:
        newest = self._observer.images.jump
        if newest is not None and newest is not self._jump:
            self._shift = self._shift or sudden(newest, self._parameters)
        self._jump = newest

    def _shown(self) -> Shown:
        return [entry for entry in self._observer.images.shown if entry[0].stamp >= self._begun]

    def _motion_in_images(self) -> Contradiction | None:
        shown = self._shown()
        if not shown or shown[-1][0].stamp <= self._compared:
            return None
        known, acquired = self._observer.estimate(), self._observer.images.counts[Outcome.ACQUIRED]
        if acquired > self._acquired and self._known:  # what came before was measured against another pose
            self.installation.seen.restart()
            self._shift = None
        self._acquired, self._known = acquired, known is not None
        for chair, offered in shown if known is not None else []:
            if known is not None and chair.stamp > self._compared:
                self.installation.seen.add(chair, offered, known.pose)
        self._compared = shown[-1][0].stamp
        speeds = speeds_by_images(shown, self._middle)
        found = contradiction(speeds, self._parameters) if speeds is not None else None
        found = found or turn_contradicts(shown, self._middle, self._parameters)
        self._suspected.append(found is not None)
        return self._jumping() or found if sum(self._suspected) >= _CONFIRMED[0] else None

    def _jumping(self) -> Contradiction | None:
        """Whether images that contradict the odometry do so at once: a jump is no speed."""
        doubted = self._observer.images.doubted
        shift = None if doubted is None else sudden(doubted, self._parameters)
        return None if shift is None else Contradiction(Kind.INCONSISTENT, shift.text)

    def _stands(self, now: float) -> Contradiction | None:
        """Whether a chair that stands by its odometry, though asked to drive, moves by the images of this time: late
        ones are waited for."""
        if self._blocked is None:
            return None
        since, found = self._blocked
        stood = since - self._parameters.blocked_time
        shown = self._shown()
        strict = replace(self._parameters, image_share=0.0)  # tyres that stand do not slip
        for begin in (stood, stood + CLOCKS):  # the second: as if it had stood in all of them
            speeds = speeds_by_images([entry for entry in shown if entry[0].stamp >= begin], self._middle, fewest=3)
            moves = None if speeds is None else contradiction(speeds, strict)
            if moves is not None:
                return moves
        recent = bool(shown) and shown[-1][0].stamp >= since - _RECENT
        # Ahead the images so far tell: a chair that pushes is to be named at once.
        return found if recent or not found.on_the_spot or now - since >= _LATEST else None

    def _place(self) -> Contradiction | None:
        elsewhere = self._observer.elsewhere
        if elsewhere is None:
            return None
        way, turn = elsewhere
        text = f"images agree on a dock {1e3 * way:.0f} mm and {np.degrees(abs(turn)):.1f} deg from where it was"
        return Contradiction(Kind.INCONSISTENT, f"{text} (was the dock moved, or do the images show another one?)")
