"""Who has answered what: the waiting side of the lock-step, without ROS.

Callbacks only `put` answers; the stepping thread waits until a condition holds. A wait ends early when nobody is left
who could answer, and after a (wall) time limit, which is counted against the one who did not answer.
"""

from __future__ import annotations

import threading
import time
from collections import Counter
from collections.abc import Callable
from typing import Generic, TypeVar

T = TypeVar("T")

KEEP = 200  # answers per topic that are remembered
CHECK = 0.2  # [s] wall time between two looks at who is still there


class Answers(Generic[T]):
    """Answers by topic and stamp [ns]. Thread-safe."""

    def __init__(self) -> None:
        self._condition = threading.Condition()
        self._answers: dict[str, dict[int, T]] = {}
        self._closed = False
        self.missed: Counter[str] = Counter()  # waits that ran into the time limit, by topic

    def put(self, topic: str, stamp_ns: int, answer: T) -> None:
        """An answer has arrived."""
        with self._condition:
            answers = self._answers.setdefault(topic, {})
            answers[stamp_ns] = answer
            if len(answers) > KEEP:
                del answers[min(answers)]
            self._condition.notify_all()

    def get(self, topic: str, stamp_ns: int) -> T | None:
        """The answer to that stamp, if it is there."""
        with self._condition:
            return self._answers.get(topic, {}).get(stamp_ns)

    def close(self) -> None:
        """End all waits: the program ends."""
        with self._condition:
            self._closed = True
            self._condition.notify_all()

    def wait(self, topic: str, stamp_ns: int, limit: float, present: Callable[[], bool]) -> T | None:
        """The answer to `stamp_ns`; None when nobody is `present` any more or after `limit` [s] (counted in
        `missed`)."""
        end = time.monotonic() + limit
        with self._condition:
            while not self._closed:
                answer = self._answers.get(topic, {}).get(stamp_ns)
                if answer is not None:
                    return answer
                left = end - time.monotonic()
                if not present():
                    return None
                if left <= 0.0:
                    self.missed[topic] += 1
                    return None
                self._condition.wait(min(left, CHECK))
        return None
