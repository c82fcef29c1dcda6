"""Guard: only the page itself, opened at the printed address with its token, may talk to the viewer's server.

A browser lets every web page that its user visits open a connection to this machine. So a request must name this
server (Host), come from the server's own page (Origin) and begin with the token in the printed address.
"""

import dataclasses
import errno
import http.client
import ipaddress
import logging
import secrets
import socket
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any
from urllib.parse import urlsplit

from urdf_ik.errors import ArgumentError
from urdf_ik.support import extras, forks

MAX_MESSAGE = 2**20
"""Greatest size of a message of the page [bytes]."""

_LOCK = forks.lock()
_LOGGER = logging.getLogger("urdf_ik.show.viewer")
_LOGGER.addHandler(logging.NullHandler())  # invalid requests do not belong in the terminal
_LOGGER.propagate = False


class Guard:
    """The token of a server that listens on ``host``, and which requests it answers.

    Attributes:
        token: what the path of every request begins with.
    """

    def __init__(self, host: str) -> None:
        self.token = secrets.token_urlsafe(24)
        self._host = host

    def refusal(self, path: str, hosts: list[str], origins: list[str]) -> str:
        """Why a request with this path and these Host and Origin headers is refused; '' where it is answered."""
        if len(hosts) != 1 or not self._is_own(hosts[0]):
            return "the Host is not this server"
        # Programs that are no browsers send no Origin.
        if origins and origins not in ([f"http://{hosts[0]}"], [f"https://{hosts[0]}"]):
            return "the Origin is not this page"
        first = path.split("?")[0].removeprefix("/").split("/")[0]
        if not secrets.compare_digest(first.encode(errors="replace"), self.token.encode()):
            return "open the address that was printed, with its token"
        return ""

    def _is_own(self, host: str) -> bool:
        """Whether a Host header can name this server: DNS rebinding lets other names lead here."""
        try:
            parts = urlsplit(f"//{host}")
            name, _ = parts.hostname or "", parts.port
        except ValueError:
            return False
        if parts.netloc != host or "@" in host:
            return False
        if name == self._host.lower() or is_local(name):
            return True
        try:
            ipaddress.ip_address(name)
        except ValueError:
            return False
        return not is_local(self._host)

    def before(self, answer: Callable[[Any, Any], Any]) -> Callable[[Any, Any], Any]:
        """A ``process_request`` of websockets that calls ``answer``, without the token, where nothing is refused."""
        from websockets.datastructures import Headers
        from websockets.http11 import Response

        def process_request(connection: Any, request: Any) -> Any:
            headers = request.headers
            if reason := self.refusal(request.path, headers.get_all("Host"), headers.get_all("Origin")):
                plain = Headers({"Content-Type": "text/plain", "Connection": "close"})
                return Response(403, "Forbidden", plain, f"{reason}\n".encode())
            path = "/" + request.path.removeprefix(f"/{self.token}").removeprefix("/")
            response = answer(connection, dataclasses.replace(request, path=path))
            if response is not None:
                response.headers["Referrer-Policy"] = "no-referrer"  # or the token would leave with a link
            return response

        return process_request


def start(guard: Guard, host: str, port: int) -> Any:
    """A viser server on ``host`` whose requests ``guard`` checks.

    viser hands each request to websockets' ``serve`` and has no argument for a check. So the check is added to that
    call while the server starts; whether it works is asked of the server itself.
    """
    import viser
    from websockets.asyncio import server

    own = host.encode().decode()  # an object that only this server's call passes
    with _LOCK, quiet():
        original: Any = server.serve

        def serve(handler: Any, host: Any = None, *arguments: Any, **options: Any) -> Any:
            if host is own:
                options["process_request"] = guard.before(options["process_request"])
                options |= {"max_size": MAX_MESSAGE, "logger": _LOGGER}
            return original(handler, host, *arguments, **options)

        server.serve = serve  # type: ignore[misc, assignment]
        try:
            started = viser.ViserServer(host=own, port=port, label="urdf-ik", verbose=False)
        finally:
            server.serve = original  # type: ignore[misc]
        setattr(started, "request_share_url", lambda *_, **__: None)  # noqa: B010  a page must not publish the server
        if not _is_refused(reachable(host), started.get_port()):
            started.stop()
            raise extras.missing("requests to the installed viser cannot be checked, a newer one is needed", "viewer")
    return started


def _is_refused(host: str, port: int) -> bool:
    """Whether a server refuses a request without a token."""
    connection = http.client.HTTPConnection(host, port, timeout=10.0)
    try:
        connection.request("GET", "/")
        return connection.getresponse().status == http.HTTPStatus.FORBIDDEN
    except OSError:
        return False
    finally:
        connection.close()


@contextmanager
def quiet() -> Iterator[None]:
    """Keep viser from printing when it starts and stops: it has no setting for that."""
    import rich

    console = rich.get_console()
    before, console.quiet = console.quiet, True
    try:
        yield
    finally:
        console.quiet = before


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
