"""One queue and the one thread that works it, so that nothing else needs a lock."""

from __future__ import annotations

import contextlib
import queue
import threading
from collections.abc import Callable, Mapping
from typing import Any

import rospy

from seater_nmpc.ros.inbox.call import Call

Handler = Callable[[Any], object]


class Worker:
    """Callbacks of topics, actions and services only put; the handlers run one after the other."""

    def __init__(self, failed: Callable[[str], None], done: Callable[[str, Any], None]) -> None:
        """`failed(text)`: a handler raised an error; `done(kind, content)`: after each, whether it failed or not."""
        self._failed, self._done = failed, done
        self._queue: queue.Queue[tuple[str, Any]] = queue.Queue()
        self._handlers: Mapping[str, Handler] = {}

    def put(self, kind: str, content: Any) -> None:
        self._queue.put((kind, content))

    def ask(self, work: Callable[[], str]) -> str:
        """For the thread of a service: the answer of `work`, which is done in the worker's thread."""
        call = Call(work)
        self.put("call", call)
        return call.wait()

    def start(self, handlers: Mapping[str, Handler]) -> None:
        """`handlers`: by kind; calls are answered besides."""
        self._handlers = {**handlers, "call": Call.work}
        threading.Thread(target=self._run, daemon=True).start()

    def work_off(self) -> None:
        """All that waits now."""
        while not self._queue.empty():
            self._work(*self._queue.get())

    def _run(self) -> None:
        while not rospy.is_shutdown():
            with contextlib.suppress(queue.Empty):
                self._work(*self._queue.get(timeout=0.2))

    def _work(self, kind: str, content: Any) -> None:
        try:
            self._handlers[kind](content)
        except Exception as error:  # whatever it is: the chair must stand, and the node must say so
            if isinstance(error, rospy.ROSException) and rospy.is_shutdown():  # a publisher was closed
                return
            rospy.logerr_throttle(1.0, "docking node, %s: %s: %s", kind, type(error).__name__, error)
            self._failed(f"internal error: {error}")
        self._done(kind, content)
