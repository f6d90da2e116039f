"""The printer's scale, from the printed bar."""

from __future__ import annotations

import math
from collections.abc import Sequence

from seater_common.params import ParameterError
from seater_tools.sheets.layout.paper import Paper

SMALLEST, LARGEST = 0.80, 1.25  # what is outside was no error of a printer but of reading
# A square that is stretched by 0.5 % looks from afar like one that is turned by arccos(1 / 1.005) = 5.7 deg.
MOST_STRETCHED = 0.005
READING = 0.25  # [mm] error of reading a steel ruler at both ends of the bar


def printed_scale(measured: Sequence[float], paper: Paper) -> float:
    """Printed over wanted length. `measured`: the bar across the page [mm], and if wanted the upright one.

    Raises:
        ParameterError: naming the option: too short or long to be true, or the print is stretched one way.
    """
    scales = [_one_scale(length, paper) for length in measured]
    stretched = max(scales) / min(scales) - 1.0
    if stretched > MOST_STRETCHED:
        lengths = " and ".join(f"{length:g}" for length in measured)
        raise ParameterError(
            f"--measured-bar: is {lengths} mm: stretched by {100 * stretched:.1f} % one way, must be <= "
            f"{100 * MOST_STRETCHED:g} %: a marker's size is one number. Read both again from end to end; if it "
            "stays, print at 100 %, or on another printer"
        )
    return math.prod(scales) ** (1.0 / len(scales))


def reading_error(paper: Paper) -> float:
    """Of the scale, standard deviation, from reading one bar."""
    return READING / paper.bar


def _one_scale(length: float, paper: Paper) -> float:
    low, high = SMALLEST * paper.bar, LARGEST * paper.bar
    if not low <= length <= high:  # also not a number
        raise ParameterError(
            f"--measured-bar: is {length:g} mm, must be {low:g} to {high:g} mm ({100 * SMALLEST:g} to "
            f"{100 * LARGEST:g} % of {paper.bar:g} mm, the bar on {paper.name} from end to end); is --paper right?"
        )
    return length / paper.bar
