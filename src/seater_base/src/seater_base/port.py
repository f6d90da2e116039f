"""A serial port as bytes in and out, by termios."""

from __future__ import annotations

import os
import select
import termios
import tty
from pathlib import Path


class PortError(Exception):
    """The port cannot be had, or is gone; in words, with the remedy."""


class Port:
    """Raw, without echo and flow control. One thread reads, another may write."""

    def __init__(self, path: str, baud: int) -> None:
        """Raises PortError."""
        self._path = path
        try:
            self._file = os.open(path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
            tty.setraw(self._file)
            settings = termios.tcgetattr(self._file)
            settings[2] |= termios.CLOCAL | termios.CREAD
            settings[4] = settings[5] = getattr(termios, f"B{baud}")
            termios.tcsetattr(self._file, termios.TCSANOW, settings)
            termios.tcflush(self._file, termios.TCIOFLUSH)
        except (OSError, termios.error) as error:
            raise PortError(f"{path}: {_why_not(path, error)}") from error

    def read(self, timeout: float) -> bytes:
        """What has come, after `timeout` [s] at the latest. Raises PortError: unplugged."""
        try:
            if not select.select([self._file], [], [], timeout)[0]:
                return b""
            data = os.read(self._file, 4096)
        except BlockingIOError:
            return b""
        except (OSError, ValueError) as error:
            raise PortError(f"{self._path} is gone ({error}): is the base plugged in?") from error
        if not data:
            raise PortError(f"{self._path} is gone: is the base plugged in?")
        return data

    def write(self, data: bytes) -> None:
        """All or nothing of a line that the port has room for; else it is left out, as a newer one will follow.

        Raises:
            PortError: unplugged.
        """
        try:
            if select.select([], [self._file], [], 0.0)[1]:
                os.write(self._file, data)
        except BlockingIOError:
            return
        except (OSError, ValueError) as error:
            raise PortError(f"{self._path} is gone ({error}): is the base plugged in?") from error

    def close(self) -> None:
        """Once."""
        os.close(self._file)


def _why_not(path: str, error: Exception) -> str:
    if not Path(path).exists():
        return "there is no such port; is the base plugged in?"
    if not os.access(path, os.R_OK | os.W_OK):
        return "no permission: sudo usermod -aG dialout $USER, then log in anew"
    return f"is no serial port, or another program has it ({error})"
