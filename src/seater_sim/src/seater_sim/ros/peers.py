"""Who is connected to whom, so that no message is lost at the start and nobody who has gone is waited for."""

from __future__ import annotations

import socket
import xmlrpc.client
from typing import Any

import rosgraph
import rospy

WALL_TIMEOUT = 2.0  # [s] for a node that does not answer questions


def publishers_of(subscriber: rospy.Subscriber) -> set[str]:
    """Names of the nodes whose connection to this subscriber stands."""
    impl = subscriber.impl
    if impl is None:
        return set()
    alive = [c for c in list(impl.connections) if not c.done and c.socket is not None]
    return {c.callerid_pub for c in alive if c.callerid_pub not in (None, "unknown")}


def subscribers_of(publisher: rospy.Publisher) -> set[str]:
    """Names of the nodes that are connected to this publisher."""
    impl = publisher.impl
    return set() if impl is None else {c.endpoint_id for c in list(impl.connections) if not c.done}


def sends_to(node: str, topic: str) -> set[str]:
    """Names of the nodes to which another node's publisher of `topic` (resolved) is connected; asked by XML-RPC."""
    default = socket.getdefaulttimeout()
    socket.setdefaulttimeout(WALL_TIMEOUT)
    try:
        uri = rosgraph.Master(rospy.get_name()).lookupNode(node)
        answer: Any = xmlrpc.client.ServerProxy(uri).getBusInfo(rospy.get_name())
    except (OSError, xmlrpc.client.Error, rosgraph.MasterException):
        return set()
    finally:
        socket.setdefaulttimeout(default)
    if answer[0] != 1:
        return set()
    return {link[1] for link in answer[2] if link[2] == "o" and link[4] == topic}
