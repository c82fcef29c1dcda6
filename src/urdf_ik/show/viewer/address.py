"""Host and port of the viewer, checked before viser listens: viser would take another port silently."""

import errno
import ipaddress
import socket

from urdf_ik.errors import ArgumentError

DEFAULT_PORT = 8080


def check(host: str, port: int | None) -> None:
    """Find out whether a server can listen there.

    Args:
        host: name or address of one of this machine's interfaces.
        port: None: any port will do.
    """
    if port is not None and not (type(port) is int and 0 <= port <= 65535):
        raise ArgumentError(f"port {port!r} given; it is a whole number from 0 (any free one) to 65535")
    try:
        family, kind, protocol, _, address = socket.getaddrinfo(host, port or 0, type=socket.SOCK_STREAM)[0]
        with socket.socket(family, kind, protocol) as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)  # as the server does
            probe.bind(address)
    except (UnicodeError, ValueError, OSError) as error:  # a label of more than 63 characters, a null byte
        if isinstance(error, OSError) and error.errno == errno.EADDRINUSE:
            raise ArgumentError(
                f"port {port} on {host} is in use; name another one, or leave it out for the first free one"
            ) from None
        reason = getattr(error, "strerror", None) or "no host name or address"
        hint = "127.0.0.1 is this machine alone, 0.0.0.0 everybody; ports from 1024 on are allowed"
        raise ArgumentError(f"cannot listen on {host!r}: {reason}; {hint}") from None


def is_local(host: str) -> bool:
    """Whether only programs on this machine reach a server that listens on ``host``."""
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == "localhost"


def reachable(host: str) -> str:
    """An address at which a server that listens on ``host`` answers on this machine."""
    return {"0.0.0.0": "127.0.0.1", "::": "::1", "": "127.0.0.1"}.get(host, host)


def url(host: str, port: int) -> str:
    """The address to type into a browser on this machine."""
    name = reachable(host)
    return f"http://[{name}]:{port}" if ":" in name else f"http://{name}:{port}"
