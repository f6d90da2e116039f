"""The first import of every program: what answers Ctrl-C.

While the other modules are imported, which takes a second, Python would show the line of the library that it is in.
Later `ended` answers, and rospy in nodes. CasADi loses one half of what arrives while it computes: Ipopt takes it for
a point that cannot be evaluated, the conversion of arguments drops it. What arrives there waits until it is out of it.
"""

from __future__ import annotations

import os.path
import signal
import sys
from types import FrameType, TracebackType  # little more than these: until they are there, nobody answers

_AGAIN = 0.005  # [s] until it is tried again
_PATIENCE = 400  # times: solves take up to a second
_CASADI = f"{os.sep}casadi{os.sep}"


def said(kind: type[BaseException], error: BaseException, trace: TracebackType | None) -> None:
    """For sys.excepthook. Python then ends itself by SIGINT, which shells show as 130."""
    waited_for_master = kind.__module__ == "rospy.exceptions" and sys.modules["rospy"].is_shutdown()
    if not issubclass(kind, KeyboardInterrupt) and not waited_for_master:
        sys.__excepthook__(kind, error, trace)
    elif sys.stderr is not None:
        print(f"\n{os.path.basename(sys.argv[0])}: interrupted", file=sys.stderr)


class _Handler:
    """Of SIGINT, and of the alarm by which it comes again."""

    def __init__(self) -> None:
        self._waited = 0

    def __call__(self, _: int, frame: FrameType | None) -> None:
        """Raises KeyboardInterrupt, at once or later."""
        if _in_casadi(frame) and self._waited < _PATIENCE:
            self._waited += 1
            signal.setitimer(signal.ITIMER_REAL, _AGAIN)
            return
        self._waited = 0
        raise KeyboardInterrupt


def _in_casadi(frame: FrameType | None) -> bool:
    while frame is not None:
        if _CASADI in frame.f_code.co_filename:
            return True
        frame = frame.f_back
    return False


_HANDLER = _Handler()
sys.excepthook = said
if signal.getsignal(signal.SIGINT) is signal.default_int_handler:  # else: in the background of a shell, or tests
    for number in (signal.SIGINT, signal.SIGALRM):
        signal.signal(number, _HANDLER)
