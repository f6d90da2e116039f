"""Bags, read in one way: names with or without the leading slash, and an error that names the file."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

from seater_common.params import why

_BEGIN = b"#ROSBAG V"
Failure = Callable[[str], Exception]  # of the caller's own kind, from a text


class Raw(NamedTuple):
    """A message that is not unpacked."""

    topic: str  # as in the bag
    kind: str  # e.g. nav_msgs/Odometry
    data: bytes
    time: Any  # rospy.Time of the recording
    connection: dict[str, str]  # of its sender: message_definition, md5sum, callerid, latching


@contextmanager
def open_bag(path: str | Path, failure: Failure) -> Iterator[BagFile]:
    """Raises what `failure` makes of a text: it cannot be read, now or later."""
    with opened(path, failure) as bag:
        try:
            file = BagFile(path, bag, failure)
        except Exception as error:  # in a damaged file rosbag stumbles over anything
            raise _unreadable(path, error, failure) from error
        yield file


@contextmanager
def opened(path: str | Path, failure: Failure) -> Iterator[Any]:
    """The rosbag.Bag itself. Raises what `failure` makes of a text: it is no bag, or cannot be opened."""
    import rosbag

    try:
        with open(path, "rb") as file:
            begin = file.read(len(_BEGIN))
        is_one = _BEGIN.startswith(begin)  # or is cut off
        bag = rosbag.Bag(str(path)) if is_one else None
    except Exception as error:  # in a damaged file rosbag stumbles over anything
        raise _unreadable(path, error, failure) from error
    if bag is None:
        raise failure(f"cannot read the bag {path}: is no bag")
    with bag:
        yield bag


class BagFile:
    """An open bag. `topics`: those with messages, as they are in it, by their names without a leading slash."""

    def __init__(self, path: str | Path, bag: Any, failure: Failure) -> None:
        self._path, self._bag, self._failure = path, bag, failure
        self.topics: dict[str, str] = {name.lstrip("/"): name for name in bag.get_type_and_topic_info().topics}

    def require(self, names: Iterable[str]) -> None:
        """Raises `failure` where a topic has no messages."""
        missing = [name for name in names if name.lstrip("/") not in self.topics]
        if missing:
            raise self._failure(f"{self._path}: has no messages on {' and '.join(missing)}")

    def messages(self, names: Iterable[str]) -> Iterator[tuple[str, Any, Any]]:
        """(name without a leading slash, message, time of the recording) in recorded order, of those topics that there
        are."""
        there = self._there(names)
        if there:
            for topic, message, time in self._read(topics=there):
                yield topic.lstrip("/"), message, time

    def raw(self, names: Iterable[str]) -> Iterator[Raw]:
        """The same without unpacking."""
        there = self._there(names)
        if there:
            for topic, (kind, data, *_), time, header in self._read(
                topics=there, raw=True, return_connection_header=True
            ):
                yield Raw(topic, kind, data, time, {_text(key): _text(value) for key, value in header.items()})

    def _there(self, names: Iterable[str]) -> list[str]:
        return [self.topics[name.lstrip("/")] for name in names if name.lstrip("/") in self.topics]

    def _read(self, **options: Any) -> Iterator[Any]:
        messages = self._bag.read_messages(**options)
        while True:
            try:
                message = next(messages, None)
            except Exception as error:  # in a damaged file rosbag stumbles over anything
                raise _unreadable(self._path, error, self._failure) from error
            if message is None:
                return
            yield message


def _unreadable(path: str | Path, error: Exception, failure: Failure) -> Exception:
    if not isinstance(error, OSError) and type(error).__module__ != "rosbag.bag":
        return failure(f"cannot read the bag {path}: it is damaged (rosbag reindex may mend it)")
    remedy = "" if isinstance(error, OSError) else " (rosbag reindex mends one that was cut off)"
    return failure(f"cannot read the bag {path}: {why(error)}{remedy}")


def _text(value: Any) -> str:
    return value.decode() if isinstance(value, bytes) else str(value)
