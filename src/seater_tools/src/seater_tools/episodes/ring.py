"""The last seconds of what came, or all since a goal began: never more than so many bytes."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Entry:
    """A message as it came; `item` is whatever writes it."""

    time: float  # [s]
    topic: str
    size: int  # [bytes]
    item: Any


class Ring:
    """Entries in the order in which they came."""

    def __init__(self, before: float, most: int) -> None:
        """`before`: [s] that are kept while nothing goes on; `most`: [bytes] in any case."""
        self._before, self._most = before, most
        self._entries: deque[Entry] = deque()
        self._latched: dict[tuple[str, str], Entry] = {}  # the last of each topic and sender
        self._size = 0
        self.dropped = 0  # entries that had to go since `hold`, as there were too many bytes
        self._held = False

    @property
    def size(self) -> int:
        """[bytes] in the ring."""
        return self._size

    def add(self, entry: Entry, latched_by: str | None = None) -> None:
        """`latched_by`: the sender of a latched topic, whose last message is kept, however old."""
        if latched_by is not None:
            self._latched[(entry.topic, latched_by)] = entry
        self._entries.append(entry)
        self._size += entry.size
        while self._entries and self._must_go(entry.time):
            self._size -= self._entries.popleft().size

    def _must_go(self, now: float) -> bool:
        if self._size > self._most:
            self.dropped += self._held
            return True
        oldest = self._entries[0].time
        return not self._held and (oldest < now - self._before or oldest > now)  # a clock that was set back

    def hold(self) -> None:
        """A goal has begun: from now on nothing goes for its age."""
        self._held, self.dropped = True, 0

    def release(self) -> None:
        """The goal has ended, and what it needed was taken: what is too old goes."""
        self._held = False
        while self._entries and self._must_go(self._entries[-1].time):
            self._size -= self._entries.popleft().size

    def taken(self) -> Iterator[Entry]:
        """Latched messages that are older than all else first, with the time of the oldest entry; then all."""
        if not self._entries:
            return
        begin = self._entries[0].time
        for (topic, _), entry in sorted(self._latched.items(), key=lambda kept: kept[1].time):
            if entry.time < begin:
                yield Entry(begin, topic, entry.size, entry.item)
        yield from list(self._entries)
