"""A panel that runs already. A second node of its name would end it, and with it the button that somebody holds."""

from __future__ import annotations

import http.client
import xmlrpc.client
from typing import Protocol

import rosgraph

_PATIENCE = 2.0  # [s] for an answer


class Names(Protocol):
    """What is asked of rosgraph.Master."""

    def lookupNode(self, name: str) -> str:
        """Address of a node. Raises rosgraph.MasterError where none is known."""


class _Hasty(xmlrpc.client.Transport):
    def make_connection(self, host: object) -> http.client.HTTPConnection:
        connection = super().make_connection(host)  # type: ignore[arg-type]
        connection.timeout = _PATIENCE
        return connection


def answers(master: Names, name: str) -> bool:
    """Whether a node of this name lives. The master also knows those that were killed."""
    try:
        address = master.lookupNode(name)
        xmlrpc.client.ServerProxy(address, transport=_Hasty()).getPid("/panel_to_be")
    except (rosgraph.MasterException, OSError, http.client.HTTPException, xmlrpc.client.Error):
        return False
    return True
