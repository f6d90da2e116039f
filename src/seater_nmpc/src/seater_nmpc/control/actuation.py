"""From the speeds that a plan wants to commands that these motors obey, and what is learned from their response."""

from __future__ import annotations

import functools
import math
from dataclasses import replace

from seater_common.geometry import Chair
from seater_nmpc.control.limits import clamp, largest_speeds
from seater_nmpc.drive.axis import AxisDrive
from seater_nmpc.drive.axis_response import AxisResponseEstimator, Expected, better
from seater_nmpc.drive.counteraction import Counteraction
from seater_nmpc.drive.curvature import CurvatureEstimator
from seater_nmpc.drive.modulator import Modulator
from seater_nmpc.drive.prediction import CommandHistory

_SPEED = Expected(widths=(0.005, 0.01, 0.015, 0.02, 0.03, 0.04, 0.055), typical=0.02, noise=0.006)  # [m/s]
_TURNING = Expected(widths=(0.01, 0.015, 0.02, 0.03, 0.04, 0.05, 0.065, 0.085, 0.11), typical=0.04, noise=0.012)
_MARGIN = 6.0  # in log likelihood, by which another delay or lag has to be ahead
_RESPONSE = 0.4  # [s] beyond the delay, in which a command can be seen to act
_DRIVING = 0.04  # [m/s] from which on the chair drives rather than turns on the spot
_ON_THE_SPOT = 0.3  # weight of what is learned while turning on the spot: castors hold against it
_SLOWLY = 0.1  # [s/s and 1/s] by which delay and lags, and gains, are changed


class Actuation:
    """Speeds in, commands out. Feed it with measured mean speeds."""

    def __init__(self, chair: Chair, history: CommandHistory, *, adapt: bool) -> None:
        """`adapt`: learn deadbands, delay, lags and curvature (and write them to `history`)."""
        self._chair, self._history, self._adapt = chair, history, adapt
        self._sent, drive = history.view(), history.drive
        self._v, self._omega = Modulator(), Modulator()
        self._estimate_v = AxisResponseEstimator(drive.v, history.delay, drive.lag_v, _SPEED)
        self._estimate_omega = AxisResponseEstimator(drive.omega, history.delay, drive.lag_omega, _TURNING)
        self._delay = self._estimate_v.delays.index(history.delay)  # these are believed in
        self._lag_v = self._estimate_v.lags.index(drive.lag_v)
        self._lag_omega = self._estimate_omega.lags.index(drive.lag_omega)
        self._curvature, self._counteraction = CurvatureEstimator(), Counteraction()
        self._stamp: float | None = None
        self._planned = -math.inf  # when a command of a plan was sent last

    def restart(self) -> None:
        """As at a goal's beginning: nothing is owed, whatever was sent. What was learned stays."""
        self._sent.restart()
        self._v.reset()
        self._omega.reset()
        self._estimate_v.restart()
        self._estimate_omega.restart()
        self._counteraction.end()
        self._stamp = None

    def measured(self, stamp: float, v: float, omega: float, *, rolling: bool = True) -> None:
        """Mean speeds [m/s, rad/s] since the last call, at `stamp` [s]; ignored unless that is newer. Unless
        `rolling`, the curvature alone is learned from them."""
        if self._stamp is not None and stamp <= self._stamp:
            return
        before, self._stamp = self._stamp, stamp
        if before is None or not self._adapt:
            return
        duration, planned = stamp - before, stamp - self._planned <= self._history.delay + _RESPONSE
        says = float(planned and rolling)  # of the motors
        mean, curvature = functools.cache(self._sent.mean), self._history.drive.curvature  # both axes ask for the same
        self._estimate_v.add(before, stamp, lambda start, end: mean(start, end)[0], v, weight=says)
        self._estimate_omega.add(
            before,
            stamp,
            lambda start, end: mean(start, end)[1],
            omega - curvature * v,
            weight=says * (1.0 if abs(v) >= _DRIVING else _ON_THE_SPOT),
        )
        self._learn(duration)
        if planned and abs(v) >= _DRIVING:
            self._curvature.add(self._estimate_omega.difference(), v, duration)
            self._history.drive.curvature = self._curvature.value
            self._counteraction.add(self._estimate_omega.difference(), duration)
        else:
            self._counteraction.end()

    def _learn(self, duration: float) -> None:
        """Deadbands at once, times and gains slowly: the plan rests on them."""
        v, omega, drive, most = self._estimate_v, self._estimate_omega, self._history.drive, _SLOWLY * duration
        drive.v, drive.omega = _gradually(drive.v, v.drive, most), _gradually(drive.omega, omega.drive, most)
        self._delay = better(v.delay_costs() + omega.delay_costs(), self._delay, _MARGIN)
        self._lag_v = better(v.lag_costs(self._delay), self._lag_v, _MARGIN)
        self._lag_omega = better(omega.lag_costs(self._delay), self._lag_omega, _MARGIN)
        self._history.delay = _nearer(self._history.delay, v.delays[self._delay], most)
        drive.lag_v = _nearer(drive.lag_v, v.lags[self._lag_v], most)
        drive.lag_omega = _nearer(drive.lag_omega, omega.lags[self._lag_omega], most)

    def send(
        self,
        stamp: float,
        wanted: tuple[float, float],
        before: tuple[float, float],
        period: float,
        slow: bool,
        *,
        planned: bool = True,
    ) -> tuple[float, float]:
        """The command that brings about the `wanted` speeds from `stamp` on; noted as sent.

        `before`: the speeds that count as the last command where none was sent. `slow`: the bay's limit holds.
        `planned`: part of a plan; what the chair makes of other commands is not learned from.
        """
        drive, wanted = self._history.drive, self._possible(*wanted, slow)
        turning = wanted[1] - drive.curvature * wanted[0] if wanted[1] != 0.0 or planned else 0.0
        turning += self._counteraction.value if planned and slow else 0.0  # on the way there a delay looks like it
        v = self._v.command(wanted[0], drive.v, period, steady=True)
        omega = self._omega.command(turning, drive.omega, period, steady=False)
        v, omega = clamp(self._chair, v, omega, self._sent.last or before, period, slow)
        self._v.sent(v, drive.v, period)
        self._omega.sent(omega, drive.omega, period)
        self._history.sent(stamp, v, omega, wanted)
        if planned:
            self._planned = stamp
        return v, omega

    def _possible(self, v: float, omega: float, slow: bool) -> tuple[float, float]:
        """The same path, no faster than the largest commands make both axes."""
        drive, (forward, backward) = self._history.drive, largest_speeds(self._chair, slow)
        most_v = abs(drive.v.effective(forward if v > 0.0 else backward))
        most_omega = abs(drive.omega.effective(self._chair.limits.omega_max))
        share = min(1.0, most_v / max(abs(v), most_v, 1e-9), most_omega / max(abs(omega), most_omega, 1e-9))
        return share * v, share * omega


def _gradually(before: AxisDrive, now: AxisDrive, most: float) -> AxisDrive:
    """`now`, with a gain that changes by `most` at most."""
    return replace(now, gain=_nearer(before.gain, now.gain, most))


def _nearer(value: float, to: float, most: float) -> float:
    """`value`, changed by `most` at most towards `to`."""
    return value + min(max(to - value, -most), most)
