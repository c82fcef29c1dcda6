"""Guard: only the page itself, opened at the printed address with its token, may talk to the viewer's server.

A browser lets every web page that its user visits open a connection to this machine. So a request must name this
server (Host), come from the server's own page (Origin) and begin with the token in the printed address.
"""

import dataclasses
import http.client
import logging
import secrets
import socket
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from urdf_ik.errors import ArgumentError
from urdf_ik.support import extras, forks

MAX_MESSAGE = 2**20
"""Greatest size of a message of the page [bytes]."""

_LOCK = forks.lock()
_LOGGER = logging.getLogger("urdf_ik.show.viewer")
_LOGGER.addHandler(logging.NullHandler())  # invalid requests do not belong in the terminal
_LOGGER.propagate = False


HOST, DEFAULT_PORT = "127.0.0.1", 8080
_NAMES = (HOST, "localhost")
"""What a Host header may call this machine: DNS rebinding lets other names lead here."""


def token() -> str:
    """What the path of every request begins with."""
    return secrets.token_urlsafe(24)


def refusal(token: str, path: str, hosts: list[str], origins: list[str]) -> str:
    """Why a request with this path and these Host and Origin headers is refused; '' where it is answered."""
    name, _, port = "".join(hosts).partition(":")
    if len(hosts) != 1 or name not in _NAMES or not port.isdigit():
        return "the Host is not this server"
    # Programs that are no browsers send no Origin.
    if origins and origins not in ([f"http://{hosts[0]}"], [f"https://{hosts[0]}"]):
        return "the Origin is not this page"
    first = path.split("?")[0].removeprefix("/").split("/")[0]
    if not secrets.compare_digest(first.encode(errors="replace"), token.encode()):
        return "open the address that was printed, with its token"
    return ""


def checked(token: str, answer: Callable[[Any, Any], Any]) -> Callable[[Any, Any], Any]:
    """A ``process_request`` of websockets that calls ``answer``, without the token, where nothing is refused."""
    from websockets.datastructures import Headers
    from websockets.http11 import Response

    def process_request(connection: Any, request: Any) -> Any:
        headers = request.headers
        if reason := refusal(token, request.path, headers.get_all("Host"), headers.get_all("Origin")):
            plain = Headers({"Content-Type": "text/plain", "Connection": "close"})
            return Response(403, "Forbidden", plain, f"{reason}\n".encode())
        path = "/" + request.path.removeprefix(f"/{token}").removeprefix("/")
        response = answer(connection, dataclasses.replace(request, path=path))
        if response is not None:
            response.headers["Referrer-Policy"] = "no-referrer"  # or the token would leave with a link
        return response

    return process_request


def start(token: str, port: int) -> Any:
    """A viser server on this machine whose requests begin with the token.

    viser hands each request to websockets' ``serve`` and has no argument for a check. So the check is added to that
    call while the server starts; whether it works is asked of the server itself.
    """
    import viser
    from websockets.asyncio import server

    own = HOST.encode().decode()  # an object that only this server's call passes
    with _LOCK, quiet():
        original: Any = server.serve

        def serve(handler: Any, host: Any = None, *arguments: Any, **options: Any) -> Any:
            if host is own:
                options["process_request"] = checked(token, options["process_request"])
                options |= {"max_size": MAX_MESSAGE, "logger": _LOGGER}
            return original(handler, host, *arguments, **options)

        server.serve = serve  # type: ignore[misc, assignment]
        try:
            started = viser.ViserServer(host=own, port=port, label="urdf-ik", verbose=False)
        finally:
            server.serve = original  # type: ignore[misc]
        setattr(started, "request_share_url", lambda *_, **__: None)  # noqa: B010  a page must not publish the server
        if not _is_refused(started.get_port()):
            started.stop()
            raise extras.missing("requests to the installed viser cannot be checked, a newer one is needed", "viewer")
    return started


def _is_refused(port: int) -> bool:
    """Whether a server refuses a request without a token."""
    connection = http.client.HTTPConnection(HOST, port, timeout=10.0)
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


def require_free(port: int | None) -> None:
    """Refuse a port at which no server can listen; None: any port will do."""
    try:
        with socket.socket() as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)  # as the server does
            probe.bind((HOST, port or 0))
    except (OSError, OverflowError) as error:
        reason = getattr(error, "strerror", None) or "ports go from 0 (any free one) to 65535"
        raise ArgumentError(f"cannot listen at port {port}: {reason}; name another one, or leave it out") from None
