"""Whether a request was meant for this server, and comes from its own page.

A foreign page in the same browser can send requests here (cross-site request forgery), and can make its own name lead
here (DNS rebinding). The browser then names the foreign page in Origin, or the foreign name in Host.
"""

from __future__ import annotations

import ipaddress
import socket
from collections.abc import Iterable


def own_names() -> set[str]:
    """Names under which a local network knows this machine."""
    name = socket.gethostname().lower()
    return {name, f"{name}.local"}


def host_allowed(host: str, local_address: str, names: Iterable[str]) -> bool:
    """`host`: the header Host; `local_address`: of our end of the connection; `names`: further names and addresses.

    An address has to be the one that the connection was made to; a foreign name could lead to any.
    """
    name = _without_port(host.lower())
    if name in {each.lower() for each in names}:
        return True
    local = _address(local_address)
    if local is None:
        return False
    return local.is_loopback if name == "localhost" else _address(name) == local


def origin_allowed(origin: str | None, scheme: str, host: str, *, required: bool) -> bool:
    """`origin`: the header Origin; None: there is none, which is allowed unless it is `required`."""
    if origin is None:
        return not required
    return origin.lower() == f"{scheme}://{host}".lower()


def _without_port(host: str) -> str:
    if host.startswith("["):
        return host[1:].partition("]")[0]
    return host.rpartition(":")[0] if host.count(":") == 1 else host


def _address(text: str) -> ipaddress.IPv4Address | ipaddress.IPv6Address | None:
    try:
        found = ipaddress.ip_address(text)
    except ValueError:
        return None
    return getattr(found, "ipv4_mapped", None) or found
