"""All checks of one goal, cycle by cycle."""

from __future__ import annotations

import math
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
from seater_nmpc.plausibility.installation.installation import Installation
from seater_nmpc.plausibility.installation.knowledge import KEYS, NAMES, PLACES, Knowledge, without_turns
from seater_nmpc.plausibility.jump import Shift, sudden
from seater_nmpc.plausibility.markers import Markers
from seater_nmpc.plausibility.response import Response

Array = NDArray[np.float64]

_SUSPECT = 0.5  # of the certainty that ends a docking: none of 50 chairs without a fault, 17 of 49 that stood far off
_CONFIRMED = (2, 3)  # so many of the last images must contradict the odometry: two wrong ones at once may do it once
# [m, m, rad] by which the walls may be elsewhere than the images have them, for a chair that drives in between them: it
# keeps 5 cm, and 2 of them are what it strays by. The heading moves a corner of the mouth, half a bay's width aside.
_WALLS = np.array([0.03, 0.03, 0.06])
# Times the certainty, for the likeliest filter: of three chairs that touched, one did before the mildest was certain
# (the likeliest was by 6.4 standard deviations); of 40 with nothing wrong it was by 3.4 at most.
_LIKELIEST = 1.2
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
        self._response = Response(history, chair.limits, parameters)
        self._middle = dock.front[:2]
        self._markers = Markers(chair.camera, dock, parameters)
        self._at_the_mouth = np.array([chair.length_front - dock.bay.entrance_x, 0.0, 0.0])  # the dock in base_link
        self._installation = Installation(chair.camera, dock, observer.parameters)
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
        self._installation.restart()
        self._look_anew(now)

    def resume(self, now: float) -> None:
        """A goal goes on after a pause, at message time `now` [s], wherever whoever has driven the chair to: what was
        found of the installation still holds."""
        self._installation.interrupt()
        self._look_anew(now)

    def _look_anew(self, now: float) -> None:
        self._begun = now
        self._suspected.clear()
        self._blocked = None
        self._response.restart(now)
        self._acquired = self._observer.images.counts[Outcome.ACQUIRED]
        self._known = self._observer.estimate() is not None

    def see(self, hypotheses: Sequence[Hypothesis], sights: Sequence[MarkerSight]) -> None:
        """What an image shows: poses of the dock, and single markers where they are known."""
        self._markers.add(hypotheses, sights)

    def asked(self, stamp: float, v: float, omega: float) -> None:
        """What the cycle sends."""
        self._response.asked(stamp, v, omega)

    def check(self, now: float) -> Contradiction | None:
        """At message time `now` [s]."""
        self._note_jump()
        found = self._motion_in_images() or self._response.check(now, self._observer.odometry)
        if found is not None and found.kind is Kind.BLOCKED:
            self._blocked, found = self._blocked or (now, found), None
        return found or self._stands(now) or self._place() or self._markers.check()

    @property
    def waits(self) -> bool:
        """Whether the chair has to stand until images show which it is, blocked or its odometry frozen."""
        return self._blocked is not None

    def final(self) -> Contradiction | None:
        """Of a chair that stands docked by its images: whether the installation is surely so wrong that it does not."""
        error, p = self._installation.error(), self._parameters
        if error is None:
            return None
        if not error.is_wrong(self._limits, p.final_certainty):
            return None
        x, y, heading = error.final.tolist()
        off = f"{1e3 * math.hypot(x, y):.0f} mm and {math.degrees(abs(heading)):.1f} deg"
        before = f" (with {error.dockings} dockings before)" if error.dockings else ""
        text = f"images and odometry{before} fit together only if the chair is {off} off: check {NAMES[error.suspect]}"
        return Contradiction(Kind.INCONSISTENT, f"{text} (chair.yaml, camera_info, the dock's file)")

    def walls(self) -> Contradiction | None:
        """Of a chair ahead of the bay: whether its walls surely are so far from where the images have them that the
        chair may touch them on its way in. By a focal length that is 4.5 % too long it did, three of 12 times."""
        found, certainty = self._installation, self._parameters.final_certainty
        error, likeliest = found.error(self._at_the_mouth), found.likeliest(self._at_the_mouth)
        if error is None or likeliest is None or not found.has_seen_enough:
            return None
        if not error.is_wrong(_WALLS, certainty):
            # Places of the camera show in turns, and slip looks like one: by 6.1 and 41 mm once, with nothing wrong.
            if likeliest.suspect in PLACES or not likeliest.is_wrong(_WALLS, _LIKELIEST * certainty):
                return None
            error = likeliest
        text = f"images and odometry fit together only if the bay is {1e3 * math.hypot(*error.final[:2]):.0f} mm from"
        check = f"where the images have it: check {NAMES[error.suspect]} (chair.yaml, camera_info, the dock's file)"
        return Contradiction(Kind.INCONSISTENT, f"{text} {check}")

    def suspected(self) -> str:
        """What a chair that stands docked by its images should have checked all the same; empty: nothing."""
        error, p = self._installation.error(), self._parameters
        if error is None or not error.is_wrong(self._limits, _SUSPECT * p.final_certainty):
            return ""
        off = f"{1e3 * math.hypot(error.final[0], error.final[1]):.0f} mm"
        return f"the way here suggests that it is {off} off: check {NAMES[error.suspect]} (./seater doctor --move)"

    def unsure(self, position_sd: float, *, checked: bool) -> str:
        """Why a chair that stands docked by its images may stand elsewhere all the same; empty: it is sure enough.
        `checked`: the installation is checked where it is not known."""
        p = self._parameters
        if position_sd <= (p.final_unsure_checked if checked else p.final_unsure):
            return ""
        found = f"where it stands is known to {1e3 * position_sd:.0f} mm only (one standard deviation)"
        return f"{found}: calibrate the camera's mount, fit a contact, or dock again, which shows more of the mount"

    def jumped(self) -> Contradiction | None:
        """Whether the dock has jumped in the images of this goal, so that where the chair stands is not sure."""
        return None if self._shift is None else Contradiction(Kind.INCONSISTENT, self._shift.text)

    @property
    def installation(self) -> dict[str, tuple[float, float]]:
        """By how much mount (x, y [m], yaw [rad]) and depths (share) seem to be off by this goal so far, and the
        standard deviation of that where nothing is; empty: it says nothing."""
        error = self._installation.error()
        if error is None:
            return {}
        sds = np.sqrt(np.diag(error.noise))
        return {name: (float(v), float(sd)) for name, v, sd in zip(KEYS, error.values, sds, strict=True)}

    def final_error(self, *, turned: bool) -> tuple[Array, Array]:
        """(3,) by which the docked chair seems to be off because of the installation: x, y [m], heading [rad], and the
        covariance (3, 3) of that. `turned`: in this goal, which shows it; else dockings before may have."""
        error = self._installation.error()
        off, spread = (np.zeros(3), self._installation.unknown) if error is None else (error.final, error.spread)
        return off, spread if turned or self.knowledge.turned else without_turns(spread)

    @property
    def begun(self) -> int:
        """How often what images show of the installation has begun anew: what was seen before does not count then."""
        return self._installation.begun

    def doubt(self, *, turned: bool) -> float:
        """Standard deviation [m] of where the docked chair stands, by what seems wrong and what is unknown of the
        installation. `turned`: in this goal, which shows it; else dockings before may have shown it."""
        off, spread = self.final_error(turned=turned)
        known = self.knowledge
        remembered = self._installation.likeliest() if known.turned and known.dockings and not turned else None
        if remembered is not None:
            off, spread = remembered.final, remembered.spread
        return math.sqrt(float(np.linalg.eigvalsh((np.outer(off, off) + spread)[:2, :2])[-1]))

    def learn(self, *, turned: bool) -> None:
        """A docking has ended at the dock: remember what it has shown, unless the dock has jumped. `turned`: at two
        places, to see where the camera sits."""
        if self._shift is None:
            self._installation.learn(self._limits, self._parameters.final_certainty, turned=turned)

    @property
    def knowledge(self) -> Knowledge:
        """Of the installation, by the dockings so far."""
        return self._installation.known

    @knowledge.setter
    def knowledge(self, known: Knowledge) -> None:
        self._installation.known = known
        self._installation.restart()

    @property
    def _limits(self) -> Array:
        p = self._parameters
        return np.array([p.final_position, p.final_position, p.final_heading])

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
            self._installation.restart()
            self._shift = None
        self._acquired, self._known = acquired, known is not None
        for chair, offered in shown if known is not None else []:
            if known is not None and chair.stamp > self._compared:
                self._installation.add(chair, offered, known.pose)
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
