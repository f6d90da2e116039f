"""Whether the commands of a recording can show what is asked for, and which drive would."""

from __future__ import annotations

import numpy as np

from seater_identify.response.data import AxisData

SLOW = (0.01, 0.3)  # of the typical speed: commands that look for a deadband
SLOW_TIME = 0.5  # [s] of them, in each direction
CHANGES = 3.0  # typical speeds: sum of all changes of the command, for delay and lag
STEADY_TIME = 2.0  # [s] at a constant command, for the gain

NAMES = ("straight", "turn")


def no_dynamics(data: AxisData, axis: int) -> str:
    """Why delay and lag cannot be seen; empty: they can."""
    changes = float(np.sum(np.abs(np.diff(data.commands.values)))) / data.unit
    if changes < CHANGES:
        return f"not excited: start and stop at least twice ({NAMES[axis]})"
    return ""


def no_steady(data: AxisData, axis: int) -> str:
    """Why the gain cannot be seen; empty: it can."""
    values, lengths = data.commands.values[:-1], np.diff(data.commands.times)
    same = np.abs(np.diff(data.commands.values)) < 0.02 * data.unit
    held = float(np.sum(lengths[same & (np.abs(values) > SLOW[1] * data.unit)]))
    return "" if held >= STEADY_TIME else f"not excited: hold a speed for some seconds ({NAMES[axis]})"


def no_deadband(data: AxisData, axis: int, sign: float) -> str:
    """Why the deadband of one direction cannot be seen; empty: it can."""
    values, lengths = sign * data.commands.values[:-1], np.diff(data.commands.times)
    slow = (values > SLOW[0] * data.unit) & (values < SLOW[1] * data.unit)
    if float(np.sum(lengths[slow])) >= SLOW_TIME:
        return ""
    way = ("forward", "backward") if axis == 0 else ("to the left", "to the right")
    return f"not excited: let the command grow slowly from zero, {way[0 if sign > 0 else 1]}"
