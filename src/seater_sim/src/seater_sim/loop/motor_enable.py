"""The relay of the motors' power, as the contract of the base driver has it (docs/safety.md)."""

from __future__ import annotations

SILENCE_NS = 300_000_000  # so long without a message means off


class MotorEnable:
    """Whether the motors have power. A base that never hears of it, as without a safety gate, has power."""

    def __init__(self, *, watch_silence: bool) -> None:
        """`watch_silence`: false in lock-step, where messages come by the clock on the wall."""
        self._watch_silence = watch_silence
        self._heard_ns: int | None = None
        self._enabled = True

    def told(self, enabled: bool, now_ns: int) -> None:
        """A message has arrived."""
        self._enabled, self._heard_ns = enabled, now_ns

    def on(self, now_ns: int) -> bool:
        """Whether they have it at `now_ns` [ns]."""
        silent = self._watch_silence and self._heard_ns is not None and now_ns - self._heard_ns > SILENCE_NS
        return self._enabled and not silent
