"""Whether messages will arrive: a subscription at the master is not enough, the connections are made after it."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any
from xmlrpc.client import ServerProxy

import rosgraph
import rospy


def links(
    master: Any, *, topics: Iterable[str] | None = None, subscriber: str | None = None
) -> set[tuple[str, str, str]]:
    """(publisher, topic, subscriber) that ought to be connected: of these (resolved) topics, to this node; None:
    all."""
    publishers, subscribers, _ = master.getSystemState()
    listening = {topic: nodes for topic, nodes in subscribers if topics is None or topic in topics}
    return {
        (source, topic, sink)
        for topic, sources in publishers
        for sink in listening.get(topic, [])
        if subscriber in (None, sink)
        for source in sources
        if source != sink
    }


def is_connected(master: Any, publisher: str, topic: str, subscriber: str) -> bool:
    """Whether the publisher has a connection to the subscriber, as the publisher says."""
    try:
        answer: Any = ServerProxy(master.lookupNode(publisher)).getBusInfo(rospy.get_name())
    except (OSError, rosgraph.MasterException):
        return False
    return any(link[1] == subscriber and link[2] == "o" and link[4] == topic for link in answer[2])
