"""From the speed that is wanted to a command that moves the chair: slow speeds by short moves.

A speed inside the deadband cannot be had. What is wanted meanwhile is added up, and driven in moves of the smallest
sure command that last at least `_SHORTEST` (error diffusion, as in a first-order sigma-delta modulator). The way that
results is the wanted one to within half a move.
"""

from __future__ import annotations

import math

from seater_nmpc.drive.axis import AxisDrive

_SHORTEST = 0.1  # [s] length of the shortest move
_MEMORY = 2.0  # [s] over which what is wanted is forgotten: noise about zero shall not move the chair
_GOING = 0.15  # fraction of the smallest speed: a moving chair goes on while at least so much is wanted


class Modulator:
    """Of one axis."""

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Nothing is owed, the chair stands."""
        self._owed, self._moving, self._most = 0.0, 0.0, 0.0

    def command(self, wanted: float, drive: AxisDrive, period: float, *, steady: bool) -> float:
        """The command for a `wanted` speed over the next `period` [s]; say with `sent` what became of it.

        `steady`: keep going rather than stop and go.
        """
        smallest = drive.smallest_speed
        self._most = smallest * _SHORTEST
        if abs(wanted) >= smallest:
            self._owed, self._moving = 0.0, math.copysign(1.0, wanted) if smallest > 0.0 else 0.0
            self._most = 0.0
            return drive.command(wanted)
        self._owed = self._owed * math.exp(-period / _MEMORY) + wanted * period
        if not self._goes_on(wanted, smallest, steady):
            self._moving = math.copysign(1.0, self._owed) if abs(self._owed) >= self._most else 0.0
        return drive.command(self._moving * smallest)

    def sent(self, command: float, drive: AxisDrive, period: float) -> None:
        """What was sent, after all limits, for the `period` [s]."""
        owed = self._owed - drive.effective(command) * period
        self._owed = min(max(owed, -self._most), self._most)

    def _goes_on(self, wanted: float, smallest: float, steady: bool) -> bool:
        if self._moving == 0.0:
            return False
        if steady and wanted * self._moving >= _GOING * smallest:
            return True
        return self._owed * self._moving > 0.0
