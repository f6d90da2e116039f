"""GPIO lines by libgpiod (version 1, as Debian 12 has it)."""

from __future__ import annotations

from typing import Any

import gpiod

from seater_controls.settings import ContactSettings


class LineError(Exception):
    """The lines cannot be had or read; in words, with the remedy."""


class Lines:
    """Inputs with the bias that makes an open contact read otherwise than a closed one."""

    def __init__(self, settings: ContactSettings, library: Any = gpiod) -> None:
        """`library`: gpiod, or what stands in for it. Raises LineError."""
        self._chip: Any = None
        self._lines: Any = None
        bias = library.LINE_REQ_FLAG_BIAS_PULL_DOWN if settings.closed else library.LINE_REQ_FLAG_BIAS_PULL_UP
        try:
            self._chip = library.Chip(settings.chip)
            self._lines = self._chip.get_lines(list(settings.lines))
            self._lines.request(consumer="seater_controls", type=library.LINE_REQ_DIR_IN, flags=bias)
        except PermissionError as error:
            self.close()
            raise LineError(f"{settings.chip}: no permission: sudo usermod -aG gpio $USER, then log in anew") from error
        except (OSError, ValueError, TypeError) as error:
            self.close()
            numbers = ", ".join(map(str, settings.lines))
            raise LineError(f"{settings.chip}, line {numbers}: {error}; gpioinfo lists what there is") from error

    def levels(self) -> list[int]:
        """0 or 1 of each. Raises LineError."""
        try:
            return [int(value) for value in self._lines.get_values()]
        except (OSError, ValueError, AttributeError) as error:
            raise LineError(f"the lines cannot be read: {error}") from error

    def close(self) -> None:
        """Whatever was had."""
        for owner, method in ((self._lines, "release"), (self._chip, "close")):
            try:
                if owner is not None:
                    getattr(owner, method)()
            except (OSError, ValueError):
                continue
