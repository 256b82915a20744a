"""Loaded by the tests and by every Python that they start: no socket may reach beyond this machine.

A connection, a look-up of a name, or a place to listen at that is not on the loopback is refused, and noted in the file
that TAICHIFLAP_SOCKETS names, for what refuses may be caught; `conftest` fails the session then.
"""

import ipaddress
import os
import sys

CALLS = {"socket.connect": 1, "socket.bind": 1, "socket.sendto": 1, "socket.sendmsg": 1}
"""Audit events with an address, and which argument it is."""
LOOKUPS = {"socket.getaddrinfo", "socket.gethostbyname"}
NOBODY = ipaddress.ip_network("203.0.113.0/24")
"""Kept for documentation (RFC 5737): tests may ask for them."""


def numeric(host):
    """An address, or None for a name."""
    try:
        return ipaddress.ip_address(host.decode() if isinstance(host, bytes) else host)
    except ValueError:
        return None


def is_near(event, target):
    """Whether a call stays here; the addresses of Unix sockets are paths, and to look up a number asks nobody."""
    if event in LOOKUPS:
        return target in (None, "", b"", "localhost", b"localhost") or numeric(target) is not None
    if not isinstance(target, tuple) or target[0] == "localhost":
        return True
    address = numeric(target[0])
    return address is not None and (address.is_loopback or (address.version == 4 and address in NOBODY))


def watch(event, arguments):
    """An audit hook."""
    if event not in CALLS and event not in LOOKUPS:
        return
    target = arguments[CALLS.get(event, 0)]
    if is_near(event, target):
        return
    with open(os.environ["TAICHIFLAP_SOCKETS"], "a") as noted:
        noted.write(f"{event} {target!r} by {sys.argv}\n")
    raise PermissionError(1, f"tests stay on this machine: {event} {target!r}")


sys.addaudithook(watch)
